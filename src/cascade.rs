//! From the reference to the drive of a [`Chain`]: its inverses in reverse order.
//!
//! ```text
//! reference -> (less offset) / gain -> output quadratic^-1 -> creep^-1 -> modes^-1 -> cubic^-1
//!           -> quadratic^-1 -> Lambda^-1 -> Psi^-1 -> amplifier lag^-1 -> advance -> drive
//! ```
//!
//! Undoing a lag, a mode or a delay takes samples of the reference that are still to come, and so
//! does the preview inverse of the hysteresis. The cascade takes the reference in
//! [`Cascade::latency`] samples ahead of the drive that it yields. It amplifies nothing beyond what
//! the modes and lags of the stage attenuate, but of that all: a reference whose second derivative
//! leaps makes the drive leap behind a mode, so references start and stop smoothly.

use crate::chain::{CREEP_DECADES, Chain, Effects, MODES};
use crate::effect::asymmetry::Asymmetry;
use crate::effect::creep::CreepState;
use crate::effect::delay::AdvanceState;
use crate::effect::derivative::Samples;
use crate::effect::lag::Lag;
use crate::effect::resonance::Resonance;
use crate::error::{ParameterError, SampleError};
use crate::hysteresis::preview::{PreviewInverse, PreviewSettings, PreviewState};
use crate::hysteresis::{RateDependentPi, State};
use crate::math::Real;

/// Inverse of a [`Chain`], with a window of up to `WINDOW` samples where the hysteresis is inverted
/// with a preview.
#[derive(Clone, Copy, Debug)]
pub struct Cascade<T, const N: usize, const M: usize, const WINDOW: usize> {
    offset: T,
    per_gain: T,
    effects: Effects<T>,
    asymmetry: Option<Asymmetry<T, M>>,
    hysteresis: Hysteresis<T, N, WINDOW>,
}

/// How the hysteresis is inverted.
#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
enum Hysteresis<T, const N: usize, const WINDOW: usize> {
    Explicit(RateDependentPi<T, N>),
    Preview(PreviewInverse<T, N, WINDOW>),
}

impl<T: Real, const N: usize, const WINDOW: usize> Hysteresis<T, N, WINDOW> {
    /// The drive for the next input, `at_rest` if it has rested there until now.
    // Not inlined, nor are the maps: each is met in several places, and large.
    #[inline(never)]
    fn step(
        &self,
        state: &mut HysteresisState<T, N, WINDOW>,
        input: T,
        at_rest: bool,
    ) -> Result<T, SampleError> {
        match (self, state) {
            (Self::Explicit(inverse), HysteresisState::Explicit(at)) => {
                if at_rest {
                    at.rest_at(input);
                }
                Ok(inverse.step(at, input))
            }
            (Self::Preview(inverse), HysteresisState::Preview(at)) => Ok(if at_rest {
                inverse.rest_at(at, input)
            } else {
                inverse.step(at, input)
            }),
            // A state of another cascade: there is no drive to give.
            _ => Err(SampleError::NotFinite),
        }
    }
}

/// State of a cascade.
#[derive(Clone, Copy, Debug)]
pub struct CascadeState<T, const N: usize, const WINDOW: usize> {
    creep: Option<CreepState<T, CREEP_DECADES>>,
    resonances: [Option<Samples<T>>; MODES],
    hysteresis: HysteresisState<T, N, WINDOW>,
    amplifier_lag: Option<Samples<T>>,
    advance: Option<AdvanceState<T>>,
}

#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
enum HysteresisState<T, const N: usize, const WINDOW: usize> {
    Explicit(State<T, N>),
    Preview(PreviewState<T, N, WINDOW>),
}

impl<T: Real, const N: usize, const M: usize, const WINDOW: usize> Cascade<T, N, M, WINDOW> {
    /// The inverse of `chain`; of its hysteresis with a preview where `preview` says how.
    ///
    /// # Errors
    /// A parameter of an inverse that leaves the range of `T`; those of
    /// [`PreviewInverse::new`].
    pub fn new(
        chain: &Chain<T, N, M>,
        preview: Option<PreviewSettings>,
    ) -> Result<Self, ParameterError> {
        let model = chain.model();
        let hysteresis = match preview {
            None => Hysteresis::Explicit(model.hysteresis().inverse()?),
            Some(settings) => {
                Hysteresis::Preview(PreviewInverse::new(model.hysteresis(), settings)?)
            }
        };
        Ok(Self {
            offset: model.offset(),
            per_gain: T::ONE / model.gain(),
            effects: *chain.effects(),
            asymmetry: model.asymmetry().map(Asymmetry::inverse).transpose()?,
            hysteresis,
        })
    }

    /// Samples between a reference sample going in and its drive coming out: that drive, applied when
    /// it comes, moves the stage to that sample.
    pub fn latency(&self) -> usize {
        let modes = self.effects.resonances.iter().flatten().count();
        let hysteresis = match &self.hysteresis {
            Hysteresis::Explicit(_) => 0,
            Hysteresis::Preview(preview) => preview.latency(),
        };
        let lag = self.effects.amplifier_lag.map_or(0, |_| Lag::<T>::LATENCY);
        let delay = self.effects.transport_delay.map_or(0, |d| d.latency());
        modes * Resonance::<T>::LATENCY + hysteresis + lag + delay
    }

    /// State after a long rest at the reference `first` (um).
    ///
    /// # Errors
    /// A first sample that is not finite.
    pub fn start(&self, first: T) -> Result<CascadeState<T, N, WINDOW>, SampleError> {
        let w = self.unscale(first)?;
        let bent = self.unbend(w);
        let effects = &self.effects;
        let mut hysteresis = match &self.hysteresis {
            Hysteresis::Explicit(inverse) => HysteresisState::Explicit(inverse.start(bent)),
            Hysteresis::Preview(preview) => HysteresisState::Preview(preview.start(bent)),
        };
        let drive = self.hysteresis.step(&mut hysteresis, bent, true)?;
        Ok(CascadeState {
            creep: effects.creep.map(|creep| creep.start(w)),
            resonances: effects
                .resonances
                .map(|mode| mode.map(|mode| mode.start_inverse(w))),
            hysteresis,
            amplifier_lag: effects.amplifier_lag.map(|lag| lag.start_inverse(drive)),
            advance: effects
                .transport_delay
                .map(|delay| delay.start_inverse(drive)),
        })
    }

    /// Takes the state up again for a reference that rests at `reference` (um) from now on, plays and
    /// creep where they stand, and returns the drive there (V).
    ///
    /// # Errors
    /// As [`Cascade::step`].
    pub fn rest_at(
        &self,
        state: &mut CascadeState<T, N, WINDOW>,
        reference: T,
    ) -> Result<T, SampleError> {
        let effects = &self.effects;
        let mut w = self.unscale(reference)?;
        if let (Some(creep), Some(at)) = (&effects.creep, &mut state.creep) {
            w = creep.step_inverse(at, w);
        }
        for (mode, at) in effects.resonances.iter().zip(&mut state.resonances) {
            *at = mode.map(|mode| mode.start_inverse(w));
        }
        let bent = self.unbend(w);
        let u = self.hysteresis.step(&mut state.hysteresis, bent, true)?;
        state.amplifier_lag = effects.amplifier_lag.map(|lag| lag.start_inverse(u));
        state.advance = effects.transport_delay.map(|delay| delay.start_inverse(u));
        Ok(u)
    }

    /// The inverse hysteresis operator, whose plays [`Cascade::plays`] are.
    pub fn inverse(&self) -> &RateDependentPi<T, N> {
        match &self.hysteresis {
            Hysteresis::Explicit(inverse) => inverse,
            Hysteresis::Preview(preview) => preview.inverse(),
        }
    }

    /// Outputs of the inverse plays at the latest drive, entries beyond their number of no account.
    pub fn plays(&self, state: &mut CascadeState<T, N, WINDOW>) -> [T; N] {
        match &mut state.hysteresis {
            HysteresisState::Explicit(at) => at.plays().outputs(self.inverse().bank()),
            HysteresisState::Preview(at) => *at.plays(),
        }
    }

    /// Puts the inverse plays elsewhere, one output a play; [`Cascade::rest_at`] comes next.
    ///
    /// # Errors
    /// Outputs that no input can have led to (J 8); the state is unchanged.
    pub fn put_plays(
        &self,
        state: &mut CascadeState<T, N, WINDOW>,
        outputs: &[T],
    ) -> Result<(), ParameterError> {
        let inverse = self.inverse();
        match &mut state.hysteresis {
            HysteresisState::Explicit(at) => *at = inverse.start_from(T::ZERO, outputs)?,
            HysteresisState::Preview(at) => {
                inverse.bank().check_outputs(outputs)?;
                for (to, &from) in at.plays().iter_mut().zip(outputs) {
                    *to = from;
                }
            }
        }
        Ok(())
    }

    /// Drive (V) for the reference sample (um) of [`Cascade::latency`] samples ago.
    ///
    /// # Errors
    /// A reference that is infinite or NaN, or that leaves the range of `T` on its way, is turned
    /// away; the state is unchanged.
    #[inline(always)]
    pub fn step(
        &self,
        state: &mut CascadeState<T, N, WINDOW>,
        reference: T,
    ) -> Result<T, SampleError> {
        let effects = &self.effects;
        let mut w = self.unscale(reference)?;
        if let (Some(creep), Some(at)) = (&effects.creep, &mut state.creep) {
            w = creep.step_inverse(at, w);
        }
        let modes = effects.resonances.iter().zip(&mut state.resonances);
        for (mode, at) in modes.rev() {
            if let (Some(mode), Some(at)) = (mode, at) {
                w = mode.step_inverse(at, w);
            }
        }
        let bent = self.unbend(w);
        let mut u = self.hysteresis.step(&mut state.hysteresis, bent, false)?;
        if let (Some(lag), Some(at)) = (&effects.amplifier_lag, &mut state.amplifier_lag) {
            u = lag.step_inverse(at, u);
        }
        if let (Some(delay), Some(at)) = (&effects.transport_delay, &mut state.advance) {
            u = delay.step_inverse(at, u);
        }
        Ok(u)
    }

    #[inline(never)]
    fn unscale(&self, reference: T) -> Result<T, SampleError> {
        let w = (reference - self.offset) * self.per_gain;
        let w = match &self.effects.output_quadratic {
            Some(quadratic) => quadratic.step_inverse(w),
            None => w,
        };
        if w.is_finite() {
            Ok(w)
        } else {
            Err(SampleError::NotFinite)
        }
    }

    #[inline(never)]
    fn unbend(&self, w: T) -> T {
        let mut w = w;
        if let Some(cubic) = &self.effects.cubic {
            w = cubic.step_inverse(w);
        }
        if let Some(quadratic) = &self.effects.quadratic {
            w = quadratic.step_inverse(w);
        }
        if let Some(asymmetry) = &self.asymmetry {
            w = asymmetry.step(w);
        }
        w
    }
}
