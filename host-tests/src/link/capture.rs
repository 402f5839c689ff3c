//! Recorded samples put together again.

use hysteron::telemetry::Codes;

use super::client::Block;
use crate::error::Error;

/// The samples of one reference, from its first one on.
#[derive(Debug, Default)]
pub(super) struct Capture {
    started: bool,
    codes: Vec<Codes>,
}

impl Capture {
    /// Takes the next block. Number 0 begins anew: a recording starts there, and again where the
    /// reference does. What comes before the first of them is left of an earlier recording.
    ///
    /// # Errors
    /// Samples that are missing.
    pub(super) fn take(&mut self, (first, codes): Block) -> Result<(), Error> {
        if first == 0 {
            self.started = true;
            self.codes.clear();
        }
        if !self.started {
            return Ok(());
        }
        let expected = self.codes.len();
        if first as usize != expected {
            return Err(Error::request(format!(
                "recorded samples from {expected} to {first} were lost on the way; check the line, \
                 close other programs, or lower sample_rate_hz",
            )));
        }
        self.codes.extend(codes);
        Ok(())
    }

    pub(super) fn len(&self) -> usize {
        self.codes.len()
    }

    pub(super) fn into_codes(self) -> Vec<Codes> {
        self.codes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn block(first: u32, drives: impl Iterator<Item = u16>) -> Block {
        let codes = drives.map(|drive| Codes { drive, sensor: 0 });
        (first, codes.collect())
    }

    #[test]
    fn what_came_before_the_reference_is_left_out() {
        let mut capture = Capture::default();
        // The rest of an older recording, the lead, the reference.
        capture.take(block(640, 0..64)).unwrap();
        capture.take(block(0, 90..99)).unwrap();
        capture.take(block(0, 100..164)).unwrap();
        capture.take(block(64, 164..200)).unwrap();
        let drives: Vec<u16> = capture.into_codes().iter().map(|c| c.drive).collect();
        assert_eq!(drives, (100..200).collect::<Vec<u16>>());
    }

    #[test]
    fn a_gap_is_no_recording() {
        let mut capture = Capture::default();
        capture.take(block(0, 0..64)).unwrap();
        let error = capture.take(block(128, 0..64)).unwrap_err().to_string();
        assert!(error.contains("from 64 to 128"), "{error}");
    }
}
