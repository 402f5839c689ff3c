//! SPI1 of the bipolar converter, 25 MHz, and USART1 of the link.

use stm32h7::stm32h743v::{SPI1, USART1};

use crate::board::Uart;
use crate::board::spi::Registers;

/// SPI1; its clock and pins are set up by the board.
pub struct Spi1(SPI1);

impl Spi1 {
    /// Takes the peripheral into use.
    pub fn new(spi: SPI1) -> Self {
        // 200 MHz / 8, 8 bit a frame.
        // SAFETY: the number of bits less one.
        spi.cfg1()
            .write(|w| unsafe { w.mbr().div8().dsize().bits(7) });
        // The level of the select that a master must see, before it is one.
        spi.cr1().write(|w| w.ssi().slave_not_selected());
        // Idle low, data taken on the falling edge.
        spi.cfg2().write(|w| {
            w.master().master().ssm().enabled().afcntr().controlled();
            w.cpol().idle_low().cpha().second_edge()
        });
        // Without an end: it clocks whenever there is something to send.
        spi.cr1()
            .modify(|_, w| w.ssi().slave_not_selected().spe().enabled());
        spi.cr1().modify(|_, w| w.cstart().started());
        Self(spi)
    }
}

/// Gives a byte to the port; a write of any other width would be as many bytes.
#[inline(always)]
pub fn give(spi: &stm32h7::stm32h743v::spi1::RegisterBlock, byte: u8) {
    // SAFETY: every value is a byte to send.
    spi.txdr8().write(|w| unsafe { w.bits(byte) });
}

impl Registers for Spi1 {
    #[inline(always)]
    fn send(&mut self, byte: u8) {
        while self.0.sr().read().txp().bit_is_clear() {}
        give(&self.0, byte);
    }

    fn exchange(&mut self, byte: u8) -> u8 {
        self.send(byte);
        while self.0.sr().read().rxp().bit_is_clear() {}
        self.0.rxdr8().read().bits()
    }

    #[inline(always)]
    fn finish(&mut self) {
        while self.0.sr().read().txc().bit_is_clear() {}
    }

    fn forget(&mut self) {
        while self.0.sr().read().rxp().bit_is_set() {
            let _ = self.0.rxdr8().read().bits();
        }
        self.0.ifcr().write(|w| w.ovrc().clear());
    }
}

/// USART1; its clock and pins are set up by the board.
pub struct Usart1(USART1);

impl Usart1 {
    /// Opens the port.
    pub fn new(usart: USART1) -> Self {
        // 100 MHz / 108 = 925,926 baud, 0.47 % off.
        // SAFETY: a divider as the reference manual has it.
        usart.brr().write(|w| unsafe { w.bits(108) });
        usart.cr1().write(|w| {
            w.ue().enabled().te().enabled().re().enabled();
            w.rxneie().enabled()
        });
        Self(usart)
    }
}

impl Uart for Usart1 {
    fn receive(&mut self) -> Option<u8> {
        let status = self.0.isr().read();
        if status.ore().bit_is_set() {
            self.0.icr().write(|w| w.orecf().clear());
        }
        let came = status.rxne().bit_is_set();
        came.then(|| self.0.rdr().read().bits() as u8)
    }

    fn has_room(&self) -> bool {
        self.0.isr().read().txe().bit_is_set()
    }

    fn send(&mut self, byte: u8) {
        // SAFETY: every value is a byte to send.
        self.0.tdr().write(|w| unsafe { w.bits(byte.into()) });
    }

    fn ask_for_room(&mut self, ask: bool) {
        self.0.cr1().modify(|_, w| w.txeie().bit(ask));
    }
}
