//! From the reference to the drive: the inverses of a model in reverse order.
//!
//! ```text
//! drive = Psi^-1[Lambda^-1((reference - offset) / gain)]                      (J 28)
//! ```

use crate::effect::asymmetry::Asymmetry;
use crate::error::SampleError;
use crate::hysteresis::{RateDependentPi, State};
use crate::math::Real;

/// Inverse of a [`crate::model::Model`]; made by [`crate::model::Model::compensator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensator<T, const N: usize, const M: usize> {
    offset: T,
    per_gain: T,
    asymmetry: Option<Asymmetry<T, M>>,
    hysteresis: RateDependentPi<T, N>,
}

impl<T: Real, const N: usize, const M: usize> Compensator<T, N, M> {
    pub(crate) fn new(
        offset: T,
        per_gain: T,
        asymmetry: Option<Asymmetry<T, M>>,
        hysteresis: RateDependentPi<T, N>,
    ) -> Self {
        Self {
            offset,
            per_gain,
            asymmetry,
            hysteresis,
        }
    }

    /// State before the first reference sample `first` (um): plays at zero, rate zero.
    ///
    /// # Errors
    /// A first sample that is not finite.
    pub fn start(&self, first: T) -> Result<State<T, N>, SampleError> {
        Ok(self.hysteresis.start(self.unshape(first)?))
    }

    /// Drive (V) that brings the stage to the next reference sample (um).
    ///
    /// # Errors
    /// A reference that is infinite or NaN, or so large that it leaves the range of `T` on its way
    /// to the plays, is turned away; the state is unchanged.
    #[inline(always)]
    pub fn step(&self, state: &mut State<T, N>, reference: T) -> Result<T, SampleError> {
        self.step_from(state, reference, false)
    }

    /// As [`Compensator::step`], and `at_rest` as if the reference had stood there before: the rate is
    /// taken as zero, so that a state that was left behind can be taken up again.
    ///
    /// # Errors
    /// As [`Compensator::step`].
    #[inline(always)]
    pub fn step_from(
        &self,
        state: &mut State<T, N>,
        reference: T,
        at_rest: bool,
    ) -> Result<T, SampleError> {
        let w = self.unshape(reference)?;
        if at_rest {
            state.rest_at(w);
        }
        Ok(self.hysteresis.step(state, w))
    }

    #[inline(always)]
    fn unshape(&self, reference: T) -> Result<T, SampleError> {
        let shaped = (reference - self.offset) * self.per_gain;
        let w = match &self.asymmetry {
            Some(asymmetry) => asymmetry.step(shaped),
            None => shaped,
        };
        // A NaN or an infinity comes through the maps as such, so one check here covers them all.
        if w.is_finite() {
            Ok(w)
        } else {
            Err(SampleError::NotFinite)
        }
    }

    /// The inverse hysteresis operator.
    pub fn hysteresis(&self) -> &RateDependentPi<T, N> {
        &self.hysteresis
    }
}
