//! What answers samples and link bytes.

use hysteron::link::FRAME_LEN;

use crate::error::Error;

/// Most link bytes that a target takes at once.
pub(super) const CHUNK_LEN: usize = 255;
/// Most link bytes that a target answers at once.
const ANSWER_LEN: usize = 2048;

/// What a target did in a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ticked {
    /// State of the output: 0 Off, 1 Hold, 2 Run, 3 Fault.
    pub state: u8,
    /// Code of the converter.
    pub code: u16,
    /// Whether the amplifier is driven.
    pub driver_enabled: bool,
    /// Instructions of the sample; zero where nothing counts them.
    pub instructions: u32,
}

/// A firmware, or what behaves like it.
pub trait Target {
    /// One sample with this sensor code; `late` tells that the one before it was late.
    ///
    /// # Errors
    /// A target that failed or is gone.
    fn tick(&mut self, sensor: u16, late: bool) -> Result<Ticked, Error>;

    /// Takes at most 255 bytes from the host and gives what the target sends.
    ///
    /// # Errors
    /// A target that failed or is gone.
    fn chunk(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error>;

    /// Takes bytes from the host, none to hear only, and gives what the target sends.
    ///
    /// # Errors
    /// A target that failed or is gone.
    fn link(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error> {
        if bytes.is_empty() {
            return self.chunk(&[]);
        }
        let mut answer = Vec::new();
        for chunk in bytes.chunks(CHUNK_LEN) {
            answer.extend(self.chunk(chunk)?);
        }
        Ok(answer)
    }
}

/// Whether an answer of so many bytes has room for another frame.
pub(super) fn has_room(len: usize) -> bool {
    len + FRAME_LEN <= ANSWER_LEN
}
