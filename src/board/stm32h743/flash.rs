//! Sectors 6 and 7 of the second bank of the flash, 128 KiB each: what is saved.
//!
//! The program runs from the first bank and goes on; only the idle loop waits, 2 s for an erase, 4 s at
//! worst. The watchdog is told to wait for it. Words have 32 bytes and an error correction: one that a
//! power cut tore may not be readable, which is no record to the store and must be no bus fault.

use core::arch::asm;

use cortex_m::peripheral::SCB;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use stm32h7::stm32h743v::FLASH;
use stm32h7::stm32h743v::flash::BANK;

use crate::board::{Single, watchdog};

const SECTOR_LEN: usize = 128 * 1024;
const SECTORS: usize = 2;
const FIRST_SECTOR: u8 = 6;
const WORD: usize = 32;

const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// Write protection, sequence, strobe, inconsistency, operation.
const ERRORS: u32 = 1 << 17 | 1 << 18 | 1 << 19 | 1 << 21 | 1 << 22;
/// What the error correction gave up on.
const TORN: u32 = 1 << 26;
/// 32 bits at a time: from 2.7 V.
const PARALLEL: u8 = 0b10;

/// Both sectors.
pub struct Flash(());

impl Flash {
    /// The only one, the first time.
    pub(super) fn take() -> Option<Self> {
        static FLASH: Single = Single::new();
        FLASH.take(|| Self(()))
    }

    fn bank() -> &'static BANK {
        // SAFETY: nothing else uses the registers of the second bank.
        unsafe { &*FLASH::ptr() }.bank2()
    }

    /// Runs what changes flash, unlocked and between checks.
    fn change(&mut self, change: impl FnOnce(&BANK)) -> Result<(), NorFlashErrorKind> {
        let bank = Self::bank();
        self.wait();
        // SAFETY: the keys in their order, and ones that clear flags.
        unsafe {
            if bank.cr().read().lock().bit_is_set() {
                for key in KEYS {
                    bank.keyr().write(|w| w.bits(key));
                }
            }
            bank.ccr().write(|w| w.bits(ERRORS));
        }
        change(bank);
        self.wait();
        let failed = bank.sr().read().bits() & ERRORS != 0;
        bank.cr().write(|w| w.lock().set_bit());
        if failed {
            return Err(NorFlashErrorKind::Other);
        }
        Ok(())
    }

    /// Until nothing is queued; a controller that never is ready ends with the watchdog.
    fn wait(&self) {
        while Self::bank().sr().read().qw().bit_is_set() {}
    }
}

/// Where the sectors begin.
fn start() -> *mut u8 {
    unsafe extern "C" {
        static mut _saved_start: u8;
    }
    &raw mut _saved_start
}

/// Reads a word; `Err` where it is torn. All but the NMI waits for the few instructions.
#[inline(never)]
fn read_word(at: usize, word: &mut [u8; WORD]) -> Result<(), NorFlashErrorKind> {
    const IGNORE_BUS_FAULTS: u32 = 1 << 8;
    let bank = Flash::bank();
    // SAFETY: within the sectors, which are mapped for reading. A bus fault is ignored at the priority
    // that the fault mask gives, and told by the flag; everything is put back as it was.
    let torn = unsafe {
        let scb = &*SCB::PTR;
        asm!("cpsid f", options(nomem, nostack, preserves_flags));
        scb.ccr.modify(|control| control | IGNORE_BUS_FAULTS);
        bank.ccr().write(|w| w.bits(TORN));
        cortex_m::asm::dsb();
        let from = start().add(at).cast::<[u32; WORD / 4]>();
        let words = from.read_volatile();
        cortex_m::asm::dsb();
        let torn = bank.sr().read().bits() & TORN != 0;
        scb.ccr.modify(|control| control & !IGNORE_BUS_FAULTS);
        cortex_m::asm::dsb();
        asm!("cpsie f", options(nomem, nostack, preserves_flags));
        for (bytes, read) in word.as_chunks_mut().0.iter_mut().zip(words) {
            *bytes = read.to_le_bytes();
        }
        torn
    };
    if torn {
        return Err(NorFlashErrorKind::Other);
    }
    Ok(())
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        let (words, _) = bytes.as_chunks_mut();
        for (at, word) in (offset as usize..).step_by(WORD).zip(words) {
            read_word(at, word)?;
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTOR_LEN * SECTORS
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR_LEN;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        for offset in (from..to).step_by(SECTOR_LEN) {
            let sector = FIRST_SECTOR + (offset as usize / SECTOR_LEN) as u8;
            watchdog::wait_long();
            let erased = self.change(|bank| {
                // SAFETY: one of the two sectors; nothing of the program is in them.
                bank.cr().write(|w| unsafe {
                    w.ser().set_bit().snb().bits(sector);
                    w.psize().bits(PARALLEL).start().set_bit()
                });
            });
            watchdog::wait_short();
            erased?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        let (words, _) = bytes.as_chunks::<WORD>();
        for (at, word) in (offset as usize..).step_by(WORD).zip(words) {
            self.change(|bank| {
                // SAFETY: 32 bit at a time, as the erase.
                bank.cr()
                    .write(|w| unsafe { w.pg().set_bit().psize().bits(PARALLEL) });
                cortex_m::asm::dsb();
                for (part, bytes) in (at..).step_by(4).zip(word.as_chunks().0) {
                    let value = u32::from_le_bytes(*bytes);
                    // SAFETY: an aligned word within the sectors, with writing enabled; the eighth
                    // begins the write.
                    unsafe { start().add(part).cast::<u32>().write_volatile(value) };
                }
                cortex_m::asm::dsb();
            })?;
        }
        Ok(())
    }
}
