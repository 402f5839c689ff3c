//! Quantisation of the measured displacement (`quantisation`): `y = q round(x / q)`, `q > 0` in um, halves
//! away from zero.
//!
//! What lies between two steps is lost, so there is no inverse.

use crate::error::{Field, ParameterError};
use crate::math::{Real, round};

/// Steps of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantisation<T> {
    step: T,
}

impl<T: Real> Quantisation<T> {
    /// Steps of `step` um.
    ///
    /// # Errors
    /// A step that is not positive or not finite.
    pub fn new(step: T) -> Result<Self, ParameterError> {
        super::check_positive(step, Field::Step)?;
        Ok(Self { step })
    }

    /// The nearest step.
    #[inline(always)]
    pub fn step(&self, x: T) -> T {
        let steps = round(x.to_f64() / self.step.to_f64());
        T::from_f64(steps * self.step.to_f64())
    }
}
