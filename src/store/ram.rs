//! Flash in memory: for the emulator, which has no flash controller, and for a host in place of the
//! target.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};

use super::{RECORD_LEN, SLOTS};

/// Bytes that can be erased at a time.
const ERASE_LEN: usize = RECORD_LEN;

/// Two pieces of memory that behave as flash: an erase sets bits, a write clears them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RamFlash {
    bytes: [[u8; ERASE_LEN]; SLOTS as usize],
}

impl Default for RamFlash {
    fn default() -> Self {
        Self::new()
    }
}

impl RamFlash {
    /// Erased.
    pub const fn new() -> Self {
        Self {
            bytes: [[0xff; ERASE_LEN]; SLOTS as usize],
        }
    }

    /// The bytes of a range that was checked.
    fn range(&mut self, offset: u32, len: usize) -> &mut [u8] {
        let from = offset as usize;
        let all = self.bytes.as_flattened_mut();
        all.get_mut(from..from + len).unwrap_or(&mut [])
    }
}

impl ErrorType for RamFlash {
    type Error = NorFlashErrorKind;
}

impl ReadNorFlash for RamFlash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        bytes.copy_from_slice(self.range(offset, bytes.len()));
        Ok(())
    }

    fn capacity(&self) -> usize {
        ERASE_LEN * SLOTS as usize
    }
}

impl NorFlash for RamFlash {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = ERASE_LEN;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        self.range(from, (to - from) as usize).fill(0xff);
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        let cells = self.range(offset, bytes.len());
        cells
            .iter_mut()
            .zip(bytes)
            .for_each(|(cell, byte)| *cell &= byte);
        Ok(())
    }
}
