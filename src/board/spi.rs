//! SPI1 as an `embedded-hal` bus: master, mode 1, 21 MHz, 8 bit.

use core::convert::Infallible;

use embedded_hal::spi::{ErrorType, SpiBus};
use stm32f4::stm32f405::SPI1;

/// SPI1; its clock and pins are set up by the board.
pub struct Spi1(SPI1);

impl Spi1 {
    /// Takes the peripheral into use.
    pub fn new(spi: SPI1) -> Self {
        spi.cr1().write(|w| {
            w.mstr().master().ssm().enabled().ssi().slave_not_selected();
            // Idle low, data taken on the falling edge, 84 MHz / 4.
            w.cpol()
                .idle_low()
                .cpha()
                .second_edge()
                .br()
                .div4()
                .spe()
                .enabled()
        });
        Self(spi)
    }

    #[inline(always)]
    fn send(&mut self, byte: u8) {
        // A master clocks a byte out in 0.4 us whatever the other end does: the wait is bounded.
        while self.0.sr().read().txe().bit_is_clear() {}
        // SAFETY: every value of the data register is a byte to send.
        self.0.dr().write(|w| unsafe { w.bits(byte.into()) });
    }

    /// Drops what came back during earlier writes.
    fn drain(&mut self) {
        let _ = self.flush();
        let _ = self.0.dr().read().bits();
        let _ = self.0.sr().read().bits();
    }

    fn exchange(&mut self, byte: u8) -> u8 {
        self.send(byte);
        while self.0.sr().read().rxne().bit_is_clear() {}
        self.0.dr().read().bits() as u8
    }
}

impl ErrorType for Spi1 {
    type Error = Infallible;
}

impl SpiBus for Spi1 {
    fn read(&mut self, words: &mut [u8]) -> Result<(), Infallible> {
        self.drain();
        words.iter_mut().for_each(|word| *word = self.exchange(0));
        Ok(())
    }

    #[inline(always)]
    fn write(&mut self, words: &[u8]) -> Result<(), Infallible> {
        // What comes back is not read: the overrun it leaves does not disturb writes.
        for &word in words {
            self.send(word);
        }
        Ok(())
    }

    fn transfer(&mut self, read: &mut [u8], write: &[u8]) -> Result<(), Infallible> {
        self.drain();
        let longer = read.len().max(write.len());
        for at in 0..longer {
            let received = self.exchange(write.get(at).copied().unwrap_or(0));
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
            .for_each(|word| *word = self.exchange(*word));
        Ok(())
    }

    #[inline(always)]
    fn flush(&mut self) -> Result<(), Infallible> {
        while self.0.sr().read().bsy().bit_is_set() {}
        Ok(())
    }
}
