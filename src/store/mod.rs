//! Settings and model that survive a reset: two slots of flash, one record each.
//!
//! A record is written whole into the slot that does not hold the newest one, after an erase of that
//! slot alone, and counts once its checksum matches. So a power cut at any moment leaves the record
//! before or the new one, whatever a torn erase or write leaves behind. Nothing is ever written to
//! flash that only reads as erased: after a cut its cells may be half way.
//!
//! | bytes | what, lowest byte first |
//! |---|---|
//! | 0..4 | `HYST` |
//! | 4..6 | [`VERSION`] |
//! | 6..8 | length of the body |
//! | 8..12 | number: one more than that of the record before |
//! | 12..16 | CRC-32 of bytes 4 to 12 and the body |
//! | 16.. | body: [`Saved`] in postcard's encoding; then zeros up to a whole word of the flash |

mod boot;
mod ram;

pub use boot::Boot;
pub use ram::RamFlash;

use embedded_storage::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};

use crate::checksum::crc32;
use crate::record::{self, ModelRecord, RecordError};
use crate::settings::{Settings, SettingsError};

/// Version of the record; raised when the encoding of [`Saved`] changes in what it already holds.
pub const VERSION: u16 = 1;

/// Bytes of the longest record: a multiple of the word of every flash this is for.
pub const RECORD_LEN: usize = 512;

/// Slots of a store.
pub const SLOTS: u32 = 2;

const MAGIC: [u8; 4] = *b"HYST";
const HEADER_LEN: usize = 16;
/// Where the bytes begin that the checksum covers, and where itself stands.
const COVERED_AT: usize = 4;
const SUM_AT: usize = 12;

/// What is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    /// The bench.
    pub settings: Settings,
    /// The stage, if there was a model.
    #[serde(deserialize_with = "record::deserialize")]
    pub model: Option<ModelRecord>,
}

/// Why a record in flash, whole by its checksum, is not in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Unfit {
    /// Written by a firmware with another [`VERSION`], this one.
    Version(u16),
    /// Its body is none of this version.
    Body,
    /// Its settings are refused.
    Settings(SettingsError),
    /// Its model is refused; its settings are in force.
    Model(RecordError),
}

/// What flash holds, beside what is in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kept {
    /// No record.
    Nothing,
    /// What is in force.
    InForce,
    /// Something else: what is in force is gone after a reset.
    Other,
    /// A record that was refused at the start.
    Unfit(Unfit),
}

/// The flash refused, or does not hold what was written; the record before is still there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlashError;

/// A place for one [`Saved`], as the link sees it.
pub trait Keep {
    /// The newest whole record; `None` where there is none.
    ///
    /// # Errors
    /// [`Unfit::Version`], [`Unfit::Body`].
    fn load(&mut self) -> Result<Option<Saved>, Unfit>;

    /// Makes `saved` the newest record, unless it is that already.
    ///
    /// # Errors
    /// [`FlashError`].
    fn save(&mut self, saved: &Saved) -> Result<(), FlashError>;
}

/// Two slots of flash, the first two erasable pieces of `F`.
pub struct Store<F> {
    flash: F,
}

type Bytes = [u8; RECORD_LEN];

/// A whole record.
#[derive(Clone, Copy)]
struct Head {
    slot: u32,
    version: u16,
    number: u32,
    /// Bytes with the header.
    len: usize,
}

impl<F: NorFlash> Store<F> {
    /// Over flash of at least two erasable pieces.
    pub const fn new(flash: F) -> Self {
        const {
            assert!(F::ERASE_SIZE >= RECORD_LEN, "a slot holds a record");
            let whole_words =
                RECORD_LEN.is_multiple_of(F::WRITE_SIZE) && RECORD_LEN.is_multiple_of(F::READ_SIZE);
            assert!(whole_words, "a record ends with a word");
        }
        Self { flash }
    }

    /// The whole record of a slot. What cannot be read is none: a torn write may leave a word that the
    /// flash's own error correction gives up on.
    fn read(&mut self, slot: u32, bytes: &mut Bytes) -> Option<Head> {
        self.flash.read(slot * F::ERASE_SIZE as u32, bytes).ok()?;
        let (magic, rest) = bytes.split_first_chunk()?;
        let (&version, rest) = rest.split_first_chunk()?;
        let (&body_len, rest) = rest.split_first_chunk()?;
        let (&number, rest) = rest.split_first_chunk()?;
        let (&sum, _) = rest.split_first_chunk()?;
        let len = HEADER_LEN + usize::from(u16::from_le_bytes(body_len));
        let whole = *magic == MAGIC && checksum(bytes.get(..len)?)? == u32::from_le_bytes(sum);
        whole.then_some(Head {
            slot,
            version: u16::from_le_bytes(version),
            number: u32::from_le_bytes(number),
            len,
        })
    }

    /// The newest record; `bytes` hold it.
    fn newest(&mut self, bytes: &mut Bytes) -> Option<Head> {
        let (first, second) = (self.read(0, bytes), self.read(1, bytes));
        match (first, second) {
            // Numbers go around after 2^32 saves; flash wears out long before.
            (Some(a), Some(b)) if b.number.wrapping_sub(a.number) >= 1 << 31 => {
                self.read(a.slot, bytes)
            }
            (Some(a), None) => self.read(a.slot, bytes),
            (_, newer) => newer,
        }
    }
}

impl<F: NorFlash> Keep for Store<F> {
    fn load(&mut self) -> Result<Option<Saved>, Unfit> {
        let mut bytes = [0; RECORD_LEN];
        let Some(head) = self.newest(&mut bytes) else {
            return Ok(None);
        };
        // A later version reads the bodies of those before it here.
        if head.version != VERSION {
            return Err(Unfit::Version(head.version));
        }
        match postcard::take_from_bytes(bytes.get(HEADER_LEN..head.len).unwrap_or(&[])) {
            Ok((saved, [])) => Ok(Some(saved)),
            _ => Err(Unfit::Body),
        }
    }

    fn save(&mut self, saved: &Saved) -> Result<(), FlashError> {
        let mut before = [0; RECORD_LEN];
        let newest = self.newest(&mut before);
        let mut bytes = [0; RECORD_LEN];
        let number = newest.map_or(0, |head| head.number.wrapping_add(1));
        let len = encode(saved, number, &mut bytes).ok_or(FlashError)?;
        // A host that missed the reply asks again; the flash need not suffer for it.
        if let Some(head) = newest
            && head.version == VERSION
            && before.get(HEADER_LEN..head.len) == bytes.get(HEADER_LEN..len)
        {
            return Ok(());
        }
        let slot = newest.map_or(0, |head| (head.slot + 1) % SLOTS);
        let at = slot * F::ERASE_SIZE as u32;
        let words = bytes.get(..len.next_multiple_of(F::WRITE_SIZE));
        let erased = self.flash.erase(at, at + F::ERASE_SIZE as u32);
        erased.map_err(|_| FlashError)?;
        let written = self.flash.write(at, words.ok_or(FlashError)?);
        written.map_err(|_| FlashError)?;
        match self.read(slot, &mut before) {
            Some(head) if before.get(..head.len) == bytes.get(..len) => Ok(()),
            _ => Err(FlashError),
        }
    }
}

/// Writes a record and returns its length; `None` where it does not fit.
fn encode(saved: &Saved, number: u32, bytes: &mut Bytes) -> Option<usize> {
    let (header, room) = bytes.split_first_chunk_mut::<HEADER_LEN>()?;
    let body_len = postcard::to_slice(saved, room).ok()?.len();
    let (magic, rest) = header.split_first_chunk_mut()?;
    let (version, rest) = rest.split_first_chunk_mut()?;
    let (length, rest) = rest.split_first_chunk_mut()?;
    *magic = MAGIC;
    *version = VERSION.to_le_bytes();
    *length = u16::try_from(body_len).ok()?.to_le_bytes();
    *rest.first_chunk_mut()? = number.to_le_bytes();
    let len = HEADER_LEN + body_len;
    let sum = checksum(bytes.get(..len)?)?.to_le_bytes();
    bytes.get_mut(SUM_AT..HEADER_LEN)?.copy_from_slice(&sum);
    Some(len)
}

/// Of a record, its own checksum left out.
fn checksum(record: &[u8]) -> Option<u32> {
    let (before, after) = (record.get(COVERED_AT..SUM_AT)?, record.get(HEADER_LEN..)?);
    Some(crc32(&[before, after]))
}
