//! Sectors 1 and 2 of the flash, 16 KiB each: what is saved.
//!
//! The program runs from the same flash, so the core stands still, interrupts too, whenever one of
//! them wants an instruction while a sector is erased (0.25 s, 0.5 s at worst) or a word written
//! (16 us, 100 us at worst). The watchdog is told to wait for it.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use stm32f4::stm32f405::FLASH;

use crate::board::{Single, watchdog};

const SECTOR_LEN: usize = 16 * 1024;
const SECTORS: usize = 2;
const FIRST_SECTOR: u8 = 1;

const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// Flags of what went wrong, cleared by ones.
const ERRORS: u32 = 0b1111_0010;

/// Both sectors.
pub struct Flash(());

impl Flash {
    /// The only one, the first time.
    pub(super) fn take() -> Option<Self> {
        static FLASH: Single = Single::new();
        FLASH.take(|| Self(()))
    }

    fn registers() -> &'static stm32f4::stm32f405::flash::RegisterBlock {
        // SAFETY: once the clocks are set up, nothing else uses these registers.
        unsafe { &*FLASH::ptr() }
    }

    /// Runs what changes flash, unlocked and between checks.
    fn change(&mut self, change: impl FnOnce()) -> Result<(), NorFlashErrorKind> {
        let registers = Self::registers();
        self.wait();
        // SAFETY: the keys in their order, and ones that clear flags.
        unsafe {
            for key in KEYS {
                registers.keyr().write(|w| w.bits(key));
            }
            registers.sr().write(|w| w.bits(ERRORS));
        }
        change();
        self.wait();
        let failed = registers.sr().read().bits() & ERRORS != 0;
        registers.cr().write(|w| w.lock().locked());
        if failed {
            return Err(NorFlashErrorKind::Other);
        }
        Ok(())
    }

    /// Until the flash is ready; a controller that never is ends with the watchdog.
    fn wait(&self) {
        while Self::registers().sr().read().bsy().bit_is_set() {}
    }
}

/// Where the sectors begin.
fn start() -> *mut u8 {
    unsafe extern "C" {
        static mut _saved_start: u8;
    }
    &raw mut _saved_start
}

impl ErrorType for Flash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        for (at, byte) in (offset as usize..).zip(bytes) {
            // SAFETY: within the sectors, which are mapped for reading.
            *byte = unsafe { start().add(at).read_volatile() };
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        SECTOR_LEN * SECTORS
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = SECTOR_LEN;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        let registers = Self::registers();
        for offset in (from..to).step_by(SECTOR_LEN) {
            let sector = FIRST_SECTOR + (offset as usize / SECTOR_LEN) as u8;
            watchdog::wait_long();
            let erased = self.change(|| {
                // SAFETY: one of the two sectors; nothing of the program is in them.
                registers.cr().write(|w| unsafe {
                    w.psize().psize32().ser().sector_erase();
                    w.snb().bits(sector).strt().start()
                });
            });
            watchdog::wait_short();
            // The caches may hold what was there.
            registers.acr().modify(|_, w| w.dcen().disabled());
            registers.acr().modify(|_, w| w.dcrst().reset());
            registers.acr().modify(|_, w| w.dcrst().no_reset());
            registers.acr().modify(|_, w| w.dcen().enabled());
            erased?;
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        let registers = Self::registers();
        let (words, _) = bytes.as_chunks();
        for (at, word) in (offset as usize..).step_by(Self::WRITE_SIZE).zip(words) {
            let word = u32::from_le_bytes(*word);
            self.change(|| {
                registers.cr().write(|w| w.psize().psize32().pg().program());
                // SAFETY: an aligned word within the sectors, with writing enabled.
                unsafe { start().add(at).cast::<u32>().write_volatile(word) };
                cortex_m::asm::dsb();
            })?;
        }
        Ok(())
    }
}
