//! Frames: `COBS(version, body, CRC-32 of both) 0x00`.
//!
//! A zero byte occurs nowhere but at the end of a frame, so a reader that has lost its place finds
//! it again at the next zero. The body is postcard's encoding of a message.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::VERSION;
use crate::checksum::crc32;

/// Bytes of the longest body.
pub const BODY_LEN: usize = 640;
/// Version and checksum around a body.
const AROUND: usize = 1 + CRC_LEN;
const CRC_LEN: usize = 4;
/// Bytes of the longest frame with its closing zero: COBS adds one for every 254 begun.
pub const FRAME_LEN: usize = BODY_LEN + AROUND + (BODY_LEN + AROUND) / 254 + 2;

/// Why bytes are not a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameError {
    /// Not COBS, too short or too long.
    Framing,
    /// The checksum does not match.
    Checksum,
    /// Another version of the protocol.
    Version(u8),
    /// The checksum matches, but the body is no message, or more than one.
    Body,
    /// A message that does not fit into a frame.
    TooLong,
}

/// Writes `message` as a frame into `out` and returns its length, closing zero included.
///
/// # Errors
/// [`FrameError::TooLong`].
pub fn encode<T: Serialize>(message: &T, out: &mut [u8; FRAME_LEN]) -> Result<usize, FrameError> {
    let mut plain = [0; BODY_LEN + AROUND];
    let [first, rest @ ..] = &mut plain;
    *first = VERSION;
    let body = rest.get_mut(..BODY_LEN).ok_or(FrameError::TooLong)?;
    let body_len = postcard::to_slice(message, body)
        .map_err(|_| FrameError::TooLong)?
        .len();
    let covered = 1 + body_len;
    let sum = crc32(&[plain.get(..covered).unwrap_or(&[])]).to_le_bytes();
    let whole = covered + CRC_LEN;
    plain
        .get_mut(covered..whole)
        .ok_or(FrameError::TooLong)?
        .copy_from_slice(&sum);
    let plain = plain.get(..whole).unwrap_or(&[]);
    let len = cobs::try_encode(plain, out).map_err(|_| FrameError::TooLong)?;
    *out.get_mut(len).ok_or(FrameError::TooLong)? = 0;
    Ok(len + 1)
}

/// The message in `frame`, the bytes before a zero; they are overwritten.
///
/// # Errors
/// See [`FrameError`].
pub fn decode<T: DeserializeOwned>(frame: &mut [u8]) -> Result<T, FrameError> {
    let len = cobs::decode_in_place(frame).map_err(|_| FrameError::Framing)?;
    let plain = frame.get(..len).ok_or(FrameError::Framing)?;
    let (covered, sum) = plain
        .split_last_chunk::<CRC_LEN>()
        .ok_or(FrameError::Framing)?;
    if crc32(&[covered]) != u32::from_le_bytes(*sum) {
        return Err(FrameError::Checksum);
    }
    let (&version, body) = covered.split_first().ok_or(FrameError::Framing)?;
    if version != VERSION {
        return Err(FrameError::Version(version));
    }
    match postcard::take_from_bytes(body) {
        Ok((message, [])) => Ok(message),
        _ => Err(FrameError::Body),
    }
}

/// Collects bytes up to the end of a frame.
#[derive(Debug)]
pub struct Reader {
    buffer: [u8; FRAME_LEN],
    len: usize,
    overrun: bool,
}

impl Default for Reader {
    fn default() -> Self {
        Self::new()
    }
}

impl Reader {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            buffer: [0; FRAME_LEN],
            len: 0,
            overrun: false,
        }
    }

    /// Takes a byte; one that ends a frame yields its message or what is wrong with it. Frames
    /// without a byte are skipped, so zeros may be sent to find the way back.
    pub fn push<T: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<T, FrameError>> {
        if byte != 0 {
            match self.buffer.get_mut(self.len) {
                Some(slot) => {
                    *slot = byte;
                    self.len += 1;
                }
                None => self.overrun = true,
            }
            return None;
        }
        let len = core::mem::take(&mut self.len);
        if core::mem::take(&mut self.overrun) {
            return Some(Err(FrameError::Framing));
        }
        match self.buffer.get_mut(..len) {
            None | Some([]) => None,
            Some(frame) => Some(decode(frame)),
        }
    }
}
