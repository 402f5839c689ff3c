//! From the reference to the drive: the inverses of a model in reverse order.
//!
//! ```text
//! drive = Psi^-1[Lambda^-1((reference - offset) / gain)]                      (J 28)
//! ```
//!
//! `Psi^-1` is the explicit inverse in a [`Compensator`] and the preview inverse in a
//! [`PreviewCompensator`].

use crate::effect::asymmetry::Asymmetry;
use crate::error::SampleError;
use crate::hysteresis::preview::{PreviewInverse, PreviewState};
use crate::hysteresis::{RateDependentPi, State};
use crate::math::Real;

/// From a displacement to the output of the hysteresis operator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unshape<T, const M: usize> {
    pub(crate) offset: T,
    pub(crate) per_gain: T,
    /// Inverse of the asymmetry map.
    pub(crate) asymmetry: Option<Asymmetry<T, M>>,
}

impl<T: Real, const M: usize> Unshape<T, M> {
    #[inline(always)]
    fn step(&self, reference: T) -> Result<T, SampleError> {
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
}

/// Inverse of a [`crate::model::Model`]; made by [`crate::model::Model::compensator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compensator<T, const N: usize, const M: usize> {
    unshape: Unshape<T, M>,
    hysteresis: RateDependentPi<T, N>,
}

impl<T: Real, const N: usize, const M: usize> Compensator<T, N, M> {
    pub(crate) fn new(unshape: Unshape<T, M>, hysteresis: RateDependentPi<T, N>) -> Self {
        Self {
            unshape,
            hysteresis,
        }
    }

    /// State before the first reference sample `first` (um): plays at zero, rate zero.
    ///
    /// # Errors
    /// A first sample that is not finite.
    pub fn start(&self, first: T) -> Result<State<T, N>, SampleError> {
        Ok(self.hysteresis.start(self.unshape.step(first)?))
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
        let w = self.unshape.step(reference)?;
        if at_rest {
            state.rest_at(w);
        }
        Ok(self.hysteresis.step(state, w))
    }

    /// Takes the reference as if it had stood at `reference` (um) in the sample before.
    ///
    /// # Errors
    /// As [`Compensator::step`].
    pub fn rest_at(&self, state: &mut State<T, N>, reference: T) -> Result<(), SampleError> {
        state.rest_at(self.unshape.step(reference)?);
        Ok(())
    }

    /// The inverse hysteresis operator.
    pub fn hysteresis(&self) -> &RateDependentPi<T, N> {
        &self.hysteresis
    }
}

/// As [`Compensator`], with the preview inverse: made by
/// [`crate::model::Model::preview_compensator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewCompensator<T, const N: usize, const M: usize, const WINDOW: usize> {
    unshape: Unshape<T, M>,
    hysteresis: PreviewInverse<T, N, WINDOW>,
}

impl<T: Real, const N: usize, const M: usize, const WINDOW: usize>
    PreviewCompensator<T, N, M, WINDOW>
{
    pub(crate) fn new(unshape: Unshape<T, M>, hysteresis: PreviewInverse<T, N, WINDOW>) -> Self {
        Self {
            unshape,
            hysteresis,
        }
    }

    /// Samples between a reference sample going in and its drive coming out.
    pub const fn latency(&self) -> usize {
        self.hysteresis.latency()
    }

    /// State for a reference (um) that has rested at `first` until now, plays at zero before.
    ///
    /// # Errors
    /// A first sample that is not finite.
    pub fn start(&self, first: T) -> Result<PreviewState<T, N, WINDOW>, SampleError> {
        Ok(self.hysteresis.start(self.unshape.step(first)?))
    }

    /// Drive (V) for the reference sample (um) that came [`PreviewCompensator::latency`] samples ago.
    ///
    /// # Errors
    /// As [`Compensator::step`].
    #[inline(always)]
    pub fn step(
        &self,
        state: &mut PreviewState<T, N, WINDOW>,
        reference: T,
    ) -> Result<T, SampleError> {
        let w = self.unshape.step(reference)?;
        Ok(self.hysteresis.step(state, w))
    }
}
