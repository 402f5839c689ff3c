//! What a compensator that looks ahead has read of a reference, for one that takes over from it.

use crate::record::LOOK_AHEAD;

/// Samples that are kept.
const LEN: usize = 128;
const _: () = assert!(LEN > LOOK_AHEAD + 1 && LEN.is_power_of_two());

/// The latest samples of a reference: those whose drive is still to come, and one more.
#[derive(Debug)]
pub(crate) struct Replay {
    samples: [f32; LEN],
    /// Samples that were read from the reference, that the compensator was given, and whose drive
    /// came out; all since the start.
    read: u32,
    given: u32,
    out: u32,
}

impl Replay {
    /// None yet.
    pub(crate) const fn new() -> Self {
        Self {
            samples: [0.0; LEN],
            read: 0,
            given: 0,
            out: 0,
        }
    }

    /// Begins anew.
    pub(crate) fn clear(&mut self) {
        (self.read, self.given, self.out) = (0, 0, 0);
    }

    #[inline(always)]
    fn at(&self, number: u32) -> f32 {
        self.samples[number as usize % LEN]
    }

    /// A sample that was read and is given to the compensator for the first time.
    #[inline(always)]
    pub(crate) fn push(&mut self, sample: f32) {
        self.samples[self.read as usize % LEN] = sample;
        self.read = self.read.wrapping_add(1);
        self.given = self.read;
    }

    /// The next sample that another compensator was given before.
    #[inline(always)]
    pub(crate) fn again(&mut self) -> Option<f32> {
        if self.given == self.read {
            return None;
        }
        let sample = self.at(self.given);
        self.given = self.given.wrapping_add(1);
        Some(sample)
    }

    /// The last sample, while a drive is still to come.
    #[inline(always)]
    pub(crate) fn last(&self) -> Option<f32> {
        (self.out != self.read).then(|| self.at(self.read.wrapping_sub(1)))
    }

    /// A drive came out.
    #[inline(always)]
    pub(crate) fn put_out(&mut self) {
        self.out = self.out.wrapping_add(1);
    }

    /// Back to the first sample whose drive is still to come; the one before it, if there is one.
    pub(crate) fn rewind(&mut self) -> Option<f32> {
        self.given = self.out;
        (self.out != 0).then(|| self.at(self.out.wrapping_sub(1)))
    }
}
