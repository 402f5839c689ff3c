//! SPI1 of the bipolar converter, 21 MHz, and USART1 of the link.

use stm32f4::stm32f405::{SPI1, USART1};

use crate::board::Uart;
use crate::board::spi::Registers;

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
}

impl Registers for Spi1 {
    #[inline(always)]
    fn send(&mut self, byte: u8) {
        while self.0.sr().read().txe().bit_is_clear() {}
        // SAFETY: every value of the data register is a byte to send.
        self.0.dr().write(|w| unsafe { w.bits(byte.into()) });
    }

    fn exchange(&mut self, byte: u8) -> u8 {
        self.send(byte);
        while self.0.sr().read().rxne().bit_is_clear() {}
        self.0.dr().read().bits() as u8
    }

    #[inline(always)]
    fn finish(&mut self) {
        while self.0.sr().read().bsy().bit_is_set() {}
    }

    fn forget(&mut self) {
        let _ = self.0.dr().read().bits();
        let _ = self.0.sr().read().bits();
    }
}

/// USART1; its clock and pins are set up by the board.
pub struct Usart1(USART1);

impl Usart1 {
    /// Opens the port.
    pub fn new(usart: USART1) -> Self {
        // 84 MHz / 91 = 923,077 baud, 0.16 % off.
        // SAFETY: a divider as the reference manual has it.
        usart.brr().write(|w| unsafe { w.bits(91) });
        usart.cr1().write(|w| {
            w.ue().enabled().te().enabled().re().enabled();
            w.rxneie().enabled()
        });
        Self(usart)
    }
}

impl Uart for Usart1 {
    fn receive(&mut self) -> Option<u8> {
        let status = self.0.sr().read();
        let came = status.rxne().bit_is_set() || status.ore().bit_is_set();
        came.then(|| self.0.dr().read().bits() as u8)
    }

    fn has_room(&self) -> bool {
        self.0.sr().read().txe().bit_is_set()
    }

    fn send(&mut self, byte: u8) {
        // SAFETY: every value is a byte to send.
        self.0.dr().write(|w| unsafe { w.bits(byte.into()) });
    }

    fn ask_for_room(&mut self, ask: bool) {
        self.0.cr1().modify(|_, w| w.txeie().bit(ask));
    }
}
