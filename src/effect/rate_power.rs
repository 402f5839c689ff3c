//! A power law of the rate (`rate-law`): thresholds that widen by `beta |u'|^p` in place of `beta |u'|`.
//!
//! ```text
//! r_i = alpha_i + beta |u'|^p,     p > 0, about 0.2 to 3
//! ```
//!
//! (J 19, 24) is `p = 1`. With `u'` in V/s, `beta` counts in `V (s/V)^p`. A common shift of all thresholds
//! leaves the analytic inverse as it is (J 14, 22), so the same law serves it, with `a_0 beta`.

use crate::error::{Field, ParameterError};
use crate::math::{Real, min};

/// Largest exponent: beyond it a threshold leaves the range of numbers at common rates.
pub const EXPONENT_MOST: f64 = 4.0;
/// Largest value of the law; with any finite beta it stays a number.
const MOST: f64 = 1e30;

/// `|u'|^p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RatePower<T> {
    exponent: T,
}

impl<T: Real> RatePower<T> {
    /// The law with the exponent `p`.
    ///
    /// # Errors
    /// An exponent that is not positive, not finite or above [`EXPONENT_MOST`].
    pub fn new(exponent: T) -> Result<Self, ParameterError> {
        super::check_positive(exponent, Field::Exponent)?;
        if exponent > T::from_f64(EXPONENT_MOST) {
            return Err(ParameterError::TooLarge(Field::Exponent));
        }
        Ok(Self { exponent })
    }

    /// `|rate|^p`, what beta is multiplied with.
    #[inline(always)]
    pub fn step(&self, rate: T) -> T {
        min(rate.abs().powf(self.exponent), T::from_f64(MOST))
    }
}
