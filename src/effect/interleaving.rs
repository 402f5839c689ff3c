//! Interleaving (`interleaving`): the product of displacement and drive one sample before, which makes
//! the branches of a loop cross beyond a mode (M 34).
//!
//! ```text
//! y_k = x_k + g y_(k-1) u_(k-1)
//! ```
//!
//! `x` and `y` are displacements less their offset, `u` is the commanded drive, `g` counts in 1/V. The
//! recursion is stable for `|g u| < 1`; beyond [`FACTOR_MOST`] the factor `g u` stays there. With the
//! drive known the inverse is the equation itself.

use crate::error::{Field, ParameterError};
use crate::math::{Real, max, min};

/// Largest `|g u|`.
pub const FACTOR_MOST: f64 = 0.95;

/// Interleaving for one `g`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interleaving<T> {
    g: T,
}

/// The product `g y u` of the sample before; the same for both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterleavingState<T>(T);

impl<T: Real> Interleaving<T> {
    /// Interleaving with the coefficient `g` in 1/V.
    ///
    /// # Errors
    /// A coefficient that is not finite.
    pub fn new(g: T) -> Result<Self, ParameterError> {
        if g.is_finite() {
            Ok(Self { g })
        } else {
            Err(ParameterError::NotFinite(Field::InterleavingGain, 0))
        }
    }

    #[inline(always)]
    fn factor(&self, drive: T) -> T {
        let most = T::from_f64(FACTOR_MOST);
        max(min(self.g * drive, most), -most)
    }

    /// State after a long rest at `x` (um) and the drive (V).
    pub fn start(&self, x: T, drive: T) -> InterleavingState<T> {
        let factor = self.factor(drive);
        InterleavingState(factor * x / (T::ONE - factor))
    }

    /// Displacement `y` for the next `x`; `drive` is that of the same sample.
    #[inline(always)]
    pub fn step(&self, state: &mut InterleavingState<T>, x: T, drive: T) -> T {
        let y = x + state.0;
        state.0 = self.factor(drive) * y;
        y
    }

    /// State of the inverse after a long rest at `y` (um) and the drive (V).
    pub fn start_inverse(&self, y: T, drive: T) -> InterleavingState<T> {
        InterleavingState(self.factor(drive) * y)
    }

    /// `x` that belongs to the displacement `y`; [`Interleaving::drove`] follows.
    #[inline(always)]
    pub fn step_inverse(&self, state: &InterleavingState<T>, y: T) -> T {
        y - state.0
    }

    /// Takes in the displacement `y` of a sample and the drive that belongs to it, for the next one.
    #[inline(always)]
    pub fn drove(&self, state: &mut InterleavingState<T>, y: T, drive: T) {
        state.0 = self.factor(drive) * y;
    }
}
