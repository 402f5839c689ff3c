//! A converter's bus as `embedded-hal` has it: master, mode 1, 8 bit.

use core::convert::Infallible;

use embedded_hal::spi::{ErrorType, SpiBus};

/// The registers of a part's SPI.
pub trait Registers {
    /// Sends a byte as soon as there is room for it; what comes back may be lost.
    fn send(&mut self, byte: u8);

    /// Sends a byte and waits for the one that comes back; nothing else is under way.
    fn exchange(&mut self, byte: u8) -> u8;

    /// Waits until all has been sent. A master clocks a byte out whatever the other end does, so this
    /// is bounded.
    fn finish(&mut self);

    /// Drops what came back.
    fn forget(&mut self);
}

/// The bus over them.
pub struct Spi<R>(pub R);

impl<R> ErrorType for Spi<R> {
    type Error = Infallible;
}

impl<R: Registers> Spi<R> {
    fn drain(&mut self) {
        self.0.finish();
        self.0.forget();
    }
}

impl<R: Registers> SpiBus for Spi<R> {
    fn read(&mut self, words: &mut [u8]) -> Result<(), Infallible> {
        self.drain();
        words.iter_mut().for_each(|word| *word = self.0.exchange(0));
        Ok(())
    }

    #[inline(always)]
    fn write(&mut self, words: &[u8]) -> Result<(), Infallible> {
        // What comes back is not read: the overrun it leaves does not disturb writes.
        for &word in words {
            self.0.send(word);
        }
        Ok(())
    }

    fn transfer(&mut self, read: &mut [u8], write: &[u8]) -> Result<(), Infallible> {
        self.drain();
        let longer = read.len().max(write.len());
        for at in 0..longer {
            let received = self.0.exchange(write.get(at).copied().unwrap_or(0));
            if let Some(word) = read.get_mut(at) {
                *word = received;
            }
        }
        Ok(())
    }

    fn transfer_in_place(&mut self, words: &mut [u8]) -> Result<(), Infallible> {
        self.drain();
        words
            .iter_mut()
            .for_each(|word| *word = self.0.exchange(*word));
        Ok(())
    }

    #[inline(always)]
    fn flush(&mut self) -> Result<(), Infallible> {
        self.0.finish();
        Ok(())
    }
}
