//! Flash that loses its power: bits are only cleared by writes and set by erases, a write that is cut
//! off leaves a part of a word, and an erase that is cut off leaves anything.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use rand::rngs::SmallRng;
use rand::{Rng, RngCore, SeedableRng};

/// Two erasable pieces of `ERASE` bytes in words of `WORD`.
#[derive(Clone)]
pub struct Nor<const WORD: usize, const ERASE: usize> {
    bytes: Vec<u8>,
    /// Words that a complete erase left, and nothing has written since.
    fresh: Vec<bool>,
    /// Words that the error correction gives up on: those cut off in a write, of flash that has one.
    torn: Vec<bool>,
    random: SmallRng,
    /// Operations until the power goes.
    left: Option<usize>,
    pub operations: usize,
    pub erases: usize,
    /// Every write fails, with the power on.
    pub broken: bool,
}

impl<const WORD: usize, const ERASE: usize> Nor<WORD, ERASE> {
    /// As nobody has left it: anything.
    pub fn new(seed: u64) -> Self {
        let mut random = SmallRng::seed_from_u64(seed);
        let mut bytes = vec![0; 2 * ERASE];
        random.fill_bytes(&mut bytes);
        Self {
            bytes,
            fresh: vec![false; 2 * ERASE / WORD],
            torn: vec![false; 2 * ERASE / WORD],
            random,
            left: None,
            operations: 0,
            erases: 0,
            broken: false,
        }
    }

    /// The same flash, whose power goes in its operation number `operation`, with its own chances.
    pub fn cut_in(&self, operation: usize, seed: u64) -> Self {
        Self {
            random: SmallRng::seed_from_u64(seed),
            left: Some(operation),
            ..self.clone()
        }
    }

    /// Power again.
    pub fn power_on(&mut self) {
        self.left = None;
    }

    /// Whether the power holds for an operation; `Err` once it is gone.
    fn operate(&mut self) -> Result<bool, NorFlashErrorKind> {
        if self.broken {
            return Err(NorFlashErrorKind::Other);
        }
        self.operations += 1;
        match &mut self.left {
            None => Ok(true),
            // Gone for good.
            Some(usize::MAX) => Err(NorFlashErrorKind::Other),
            Some(0) => {
                self.left = Some(usize::MAX);
                Ok(false)
            }
            Some(left) => {
                *left -= 1;
                Ok(true)
            }
        }
    }

    fn cut_erase(&mut self, from: usize, to: usize) {
        let kind = self.random.random_range(0..6);
        let edge = self.random.random_range(from..to);
        for at in from..to {
            let old = self.bytes[at];
            let any = self.random.random::<u8>();
            self.bytes[at] = match kind {
                0 => old,
                1 => 0xff,
                2 => any,
                3 => old | any,
                4 if at < edge => 0xff,
                5 if at >= edge => 0xff,
                _ => old,
            };
        }
    }

    fn cut_write(&mut self, at: usize, bytes: &[u8]) {
        let kind = self.random.random_range(0..4);
        for (cell, byte) in self.bytes[at..].iter_mut().zip(bytes) {
            let any = self.random.random::<u8>();
            *cell &= match kind {
                0 => 0xff,
                1 => *byte,
                _ => byte | any,
            };
        }
        // Words of 32 bytes have an error correction of their own.
        self.torn[at / WORD] = WORD == 32 && kind > 1 && self.random.random();
    }
}

impl<const WORD: usize, const ERASE: usize> ErrorType for Nor<WORD, ERASE> {
    type Error = NorFlashErrorKind;
}

impl<const WORD: usize, const ERASE: usize> ReadNorFlash for Nor<WORD, ERASE> {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        check_read(self, offset, bytes.len())?;
        let from = offset as usize;
        let to = from + bytes.len();
        if self.torn[from / WORD..to.div_ceil(WORD)].contains(&true) {
            return Err(NorFlashErrorKind::Other);
        }
        bytes.copy_from_slice(&self.bytes[from..to]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const WORD: usize, const ERASE: usize> NorFlash for Nor<WORD, ERASE> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = ERASE;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        let (from, to) = (from as usize, to as usize);
        let whole = self.operate()?;
        self.erases += 1;
        let words = from / WORD..to / WORD;
        self.torn[words.clone()].fill(false);
        self.fresh[words].fill(whole);
        if whole {
            self.bytes[from..to].fill(0xff);
            return Ok(());
        }
        self.cut_erase(from, to);
        Err(NorFlashErrorKind::Other)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        check_write(self, offset, bytes.len())?;
        for (index, word) in bytes.chunks(WORD).enumerate() {
            let at = offset as usize + index * WORD;
            let whole = self.operate()?;
            assert!(self.fresh[at / WORD], "written without an erase");
            self.fresh[at / WORD] = false;
            if !whole {
                self.cut_write(at, word);
                return Err(NorFlashErrorKind::Other);
            }
            self.bytes[at..at + WORD].copy_from_slice(word);
        }
        Ok(())
    }
}
