//! Loops that are not congruent (`congruency`): the plays count for more where the output is large.
//!
//! ```text
//! w = a_0 u + (1 + k w) Z,   Z = sum a_i z_i        that is   w = (a_0 u + Z) / (1 - k Z)
//! ```
//!
//! In a Prandtl-Ishlinskii operator equal swings of the drive make equal loops at any bias; here a loop
//! at the displacement `x` is `1 + kappa x` times as wide, in the way of the product Preisach model
//! (G. Kadar, *On the Preisach function of ferromagnetic hysteresis*, J. Appl. Phys. 61, 4013, 1987).
//! `kappa`, in 1/um, counts behind the gain of the stage, so `k = kappa gain` belongs to `w` in V.
//!
//! The factor `1 + k w` is kept within [`LEAST`] to [`MOST`], and `1 - k Z` above [`LEAST`], so that the map
//! goes on rising, as a plain operator, where the law would turn over.
//!
//! With `w` given, the factor `F = 1 + k w` is a number, and what is left is a plain operator of the
//! weights `a_0, F a_i` with the plays where they stand: pieces of straight lines in `u`. One pass solves
//! it, from the input at which no play moves, past the corner of one play after the other:
//!
//! ```text
//! x = (w - F sum a_i z_i) / a_0;  while x lies beyond the corner c_i of the next play:
//! x = c_i + (x - c_i) S_(i-1) / S_i,   S_i = a_0 + F (a_1 + ... + a_i)
//! ```

use crate::error::{Field, ParameterError};
use crate::hysteresis::RateDependentPi;
use crate::math::{Real, max, min};
use crate::play::{Envelope, play};

/// Least factor on the plays, and least denominator.
pub const LEAST: f64 = 0.25;
/// Largest factor on the plays.
pub const MOST: f64 = 4.0;

/// The law for one kappa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Congruency<T> {
    /// kappa times the gain, in 1/V.
    k: T,
}

impl<T: Real> Congruency<T> {
    /// The law for `kappa` in 1/um on a stage with `gain` in um/V.
    ///
    /// # Errors
    /// A kappa that is not finite, or is not once it is multiplied by the gain.
    pub fn new(kappa: T, gain: T) -> Result<Self, ParameterError> {
        let k = kappa * gain;
        if k.is_finite() {
            Ok(Self { k })
        } else {
            Err(ParameterError::NotFinite(Field::Kappa, 0))
        }
    }

    #[inline(always)]
    fn within(factor: T) -> T {
        max(min(factor, T::from_f64(MOST)), T::from_f64(LEAST))
    }

    /// The factor on the plays where the output is `w`.
    #[inline(always)]
    pub(crate) fn factor(&self, w: T) -> T {
        Self::within(T::ONE + self.k * w)
    }

    /// `w` from the part `a_0 u` of the drive and the sum `Z` of the plays.
    #[inline(always)]
    pub fn step(&self, direct: T, plays: T) -> T {
        let below = max(T::ONE - self.k * plays, T::from_f64(LEAST));
        let factor = Self::within((T::ONE + self.k * direct) / below);
        direct + factor * plays
    }

    /// Whether the plays of `operator` can be solved for with every factor.
    ///
    /// # Errors
    /// The first partial sum of weights that is not positive with the plays scaled by [`MOST`].
    pub fn check<const N: usize>(
        &self,
        operator: &RateDependentPi<T, N>,
    ) -> Result<(), ParameterError> {
        let mut sum = operator.weight_0();
        for (i, &weight) in operator.bank().weights().iter().enumerate() {
            sum = sum + T::from_f64(MOST) * weight;
            if sum <= T::ZERO {
                return Err(ParameterError::PartialSum(Field::Weights, i + 1));
            }
        }
        Ok(())
    }

    /// Drive for which `operator` under this law yields `w`, with the plays at `z` before and an envelope
    /// that opens by `half_width`; the plays follow. `operator` has passed [`Congruency::check`].
    pub fn step_inverse<const N: usize>(
        &self,
        operator: &RateDependentPi<T, N>,
        z: &mut [T; N],
        w: T,
        half_width: T,
    ) -> T {
        let factor = self.factor(w);
        let bank = operator.bank();
        let (thresholds, weights) = (bank.thresholds(), bank.weights());
        let held = z
            .iter()
            .zip(weights)
            .fold(T::ZERO, |sum, (&z, &a)| sum + a * z);
        let mut slope = operator.weight_0();
        let mut x = (w - factor * held) / slope;
        for ((&z, &r), &a) in z.iter().zip(thresholds).zip(weights) {
            // Corners lie further out from play to play, so only one side comes into question.
            let reach = r + half_width;
            let corner = if x > z + reach {
                z + reach
            } else if x < z - reach {
                z - reach
            } else {
                break;
            };
            let next = slope + factor * a;
            x = corner + (x - corner) * (slope / next);
            slope = next;
        }
        let envelope = Envelope {
            lo: x - half_width,
            hi: x + half_width,
        };
        for (z, &r) in z.iter_mut().zip(thresholds) {
            *z = play(*z, envelope, r);
        }
        x
    }
}
