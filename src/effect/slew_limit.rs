//! Slew limit of the amplifier (`slew-limit`): its output follows the drive at `|u'| <= S`, `S > 0` in
//! V/s.
//!
//! ```text
//! u_k = u_(k-1) + max(-S h, min(S h, drive_k - u_(k-1)))
//! ```
//!
//! What it holds back is lost, so there is no inverse: a drive that keeps to the limit passes
//! unchanged.

use crate::error::{Field, ParameterError};
use crate::math::{Real, max, min};

/// A limit of the drive's rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlewLimit<T> {
    /// S h
    step: T,
}

/// The output before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlewState<T>(T);

impl<T: Real> SlewLimit<T> {
    /// A limit of `slew` V/s for samples `sample_time` seconds apart.
    ///
    /// # Errors
    /// A slew or a sample time that is not positive or not finite.
    pub fn new(slew: T, sample_time: T) -> Result<Self, ParameterError> {
        super::check_sample_time(sample_time)?;
        super::check_positive(slew, Field::SlewLimit)?;
        Ok(Self {
            step: slew * sample_time,
        })
    }

    /// State after a long rest at `input`.
    pub fn start(&self, input: T) -> SlewState<T> {
        SlewState(input)
    }

    /// Output for the next input.
    #[inline(always)]
    pub fn step(&self, state: &mut SlewState<T>, input: T) -> T {
        // Within the limit the input itself, without the rounding of a difference.
        state.0 = max(min(input, state.0 + self.step), state.0 - self.step);
        state.0
    }
}
