//! Saturation of the amplifier (`saturation`): `u = max(-L, min(L, drive))`, `L > 0` in V.
//!
//! What lies beyond the limit is lost, so there is no inverse: a drive that keeps to the limit passes
//! unchanged.

use crate::error::{Field, ParameterError};
use crate::math::{Real, max, min};

/// A symmetric limit of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Saturation<T> {
    limit: T,
}

impl<T: Real> Saturation<T> {
    /// A limit of `limit` volts to both sides.
    ///
    /// # Errors
    /// A limit that is not positive or not finite.
    pub fn new(limit: T) -> Result<Self, ParameterError> {
        super::check_positive(limit, Field::SaturationLimit)?;
        Ok(Self { limit })
    }

    /// The drive within the limit.
    #[inline(always)]
    pub fn step(&self, drive: T) -> T {
        max(min(drive, self.limit), -self.limit)
    }
}
