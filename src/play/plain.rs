//! The plain form: one stored output a play.

use super::{Envelope, PlayBank, play};
use crate::error::ParameterError;
use crate::math::Real;

/// Size of a bank whose plays are all stepped, whether they are there or not.
const SMALL: usize = 4;

/// Outputs of a bank's plays, all of them stepped in each sample: constant time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlainState<T, const N: usize> {
    z: [T; N],
}

impl<T: Real, const N: usize> PlainState<T, N> {
    /// Every play at zero.
    pub fn zero() -> Self {
        Self { z: [T::ZERO; N] }
    }

    /// The plays of `bank` at the outputs `z`.
    ///
    /// # Errors
    /// As [`PlayBank::check_outputs`].
    pub fn new(bank: &PlayBank<T, N>, z: &[T]) -> Result<Self, ParameterError> {
        bank.check_outputs(z)?;
        let mut state = Self::zero();
        state.z.iter_mut().zip(z).for_each(|(to, &from)| *to = from);
        Ok(state)
    }

    /// Moves the plays to the envelope of the next sample and returns `sum w_i z_i`.
    #[inline(always)]
    pub fn step(&mut self, bank: &PlayBank<T, N>, envelope: Envelope<T>) -> T {
        // -0 is neutral in every sum, +0 is not, so only with -0 the first addition can be left out.
        self.step_onto(bank, envelope, -T::ZERO)
    }

    /// `direct` plus what [`PlainState::step`] returns.
    #[inline(always)]
    pub(super) fn step_onto(
        &mut self,
        bank: &PlayBank<T, N>,
        envelope: Envelope<T>,
        direct: T,
    ) -> T {
        let mut sum = direct;
        if N <= SMALL || bank.len == N {
            // The trip count is a constant, so the compiler can unroll. In a small bank a spare play,
            // which nothing moves, costs less than telling how many there are.
            let rows = self.z.iter_mut().zip(&bank.thresholds).zip(&bank.weights);
            for ((z, &r), &w) in rows {
                *z = play(*z, envelope, r);
                sum = sum + w * *z;
            }
        } else {
            // Two at a time; an odd one is joined by a spare play.
            let (z, _) = self.z.as_chunks_mut::<2>();
            let (r, _) = bank.thresholds.as_chunks::<2>();
            let (w, _) = bank.weights.as_chunks::<2>();
            let pairs = z.iter_mut().zip(r).zip(w).take(bank.len.div_ceil(2));
            for (([z0, z1], &[r0, r1]), &[w0, w1]) in pairs {
                *z0 = play(*z0, envelope, r0);
                *z1 = play(*z1, envelope, r1);
                sum = sum + w0 * *z0;
                sum = sum + w1 * *z1;
            }
        }
        sum
    }

    /// Output of each play; entries beyond the bank's length are zero.
    pub fn outputs(&self) -> [T; N] {
        self.z
    }
}
