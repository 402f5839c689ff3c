//! The prefix form: every output stored, and only the captured ones moved and summed anew.
//!
//! With increasing thresholds and an admissible state the plays that a sample captures are the first
//! ones, see the stack form. So the comparisons end at the first play that stays. The captured ones
//! follow one front, and their part of the sum is a product with prefix sums; the others are summed
//! from their outputs, and nothing at all where nothing was captured. Each sum is made of the outputs
//! as they are, so nothing drifts.

use super::{Envelope, PlayBank};
use crate::math::Real;

/// Outputs of a bank's plays and their weighted sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrefixState<T, const N: usize> {
    z: [T; N],
    sum: T,
}

impl<T: Real, const N: usize> PrefixState<T, N> {
    /// Every play at zero.
    pub fn zero() -> Self {
        Self {
            z: [T::ZERO; N],
            sum: T::ZERO,
        }
    }

    /// Moves the plays to the envelope of the next sample and returns `sum w_i z_i`.
    #[inline(always)]
    pub fn step(&mut self, bank: &PlayBank<T, N>, envelope: Envelope<T>) -> T {
        let (mut captured, mut front, mut sign) = (0usize, envelope.lo, -T::ONE);
        // The thresholds of plays that are not there are infinite, so they stay.
        for (z, &r) in self.z.iter_mut().zip(&bank.thresholds) {
            let pushed = envelope.lo - r;
            let moves = pushed > *z;
            if !moves {
                break;
            }
            *z = pushed;
            captured += 1;
        }
        // With `lo <= hi` only one of the envelopes captures.
        if captured == 0 {
            (front, sign) = (envelope.hi, T::ONE);
            for (z, &r) in self.z.iter_mut().zip(&bank.thresholds) {
                let pushed = envelope.hi + r;
                let moves = pushed < *z;
                if !moves {
                    break;
                }
                *z = pushed;
                captured += 1;
            }
        }
        if let Some(sums) = bank.sums.get(captured.wrapping_sub(1)) {
            let mut sum = front * sums.weight + sign * sums.moment;
            let stay = captured..bank.len;
            let z = self.z.get(stay.clone()).unwrap_or(&[]);
            let weights = bank.weights.get(stay).unwrap_or(&[]);
            for (&z, &w) in z.iter().zip(weights) {
                sum = sum + w * z;
            }
            self.sum = sum;
        }
        self.sum
    }

    /// Output of each play; entries beyond the bank's length are zero.
    #[inline(always)]
    pub fn outputs(&self) -> &[T; N] {
        &self.z
    }

    /// `sum w_i z_i` after the latest step.
    #[inline(always)]
    pub fn sum(&self) -> T {
        self.sum
    }
}
