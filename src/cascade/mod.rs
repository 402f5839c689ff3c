//! From the reference to the drive of a [`Chain`]: its inverses in reverse order.
//!
//! ```text
//! reference -> less offset -> interleaving^-1 -> / gain -> output quadratic^-1 -> creep^-1
//!           -> modes^-1 -> backlash^-1 -> cubic^-1 -> quadratic^-1 -> Lambda^-1 -> Psi^-1
//!           -> amplifier lag^-1 -> advance -> drive
//! ```
//!
//! `Psi^-1` is the explicit inverse or that with a preview; with a congruency it is solved from the
//! plays as they stand, with elements of Bouc and Wen it is searched for. A rate law, a congruency or
//! elements leave the preview aside: it is for plays of the linear law.
//! The amplifier's limits have no inverse, and what only the sensor sees is no motion: saturation, slew
//! limit, sensor lag, drift, hum and quantisation are passed over.
//!
//! The product of interleaving takes the drive of the sample before. Without latency that is the drive
//! that was given out; ahead of time it is not known yet, and the static gain of the stage stands in. A
//! drive that is already made must not: behind a mode the loop through its inverse would grow.
//!
//! Undoing a lag, a mode or a delay takes samples of the reference that are still to come, and so
//! does the preview inverse of the hysteresis. The cascade takes the reference in
//! [`Cascade::latency`] samples ahead of the drive that it yields. It amplifies nothing beyond what
//! the modes and lags of the stage attenuate, but of that all: a reference whose second derivative
//! leaps makes the drive leap behind a mode, so references start and stop smoothly.

mod hysteresis;

use crate::chain::{CREEP_DECADES, Chain, DELAY_SPAN, Effects, MODES};
use crate::effect::asymmetry::Asymmetry;
use crate::effect::backlash::{Backlash, BacklashInverse};
use crate::effect::creep::{Creep, CreepState};
use crate::effect::cubic::Cubic;
use crate::effect::delay::{AdvanceState, Delay};
use crate::effect::derivative::Samples;
use crate::effect::interleaving::{Interleaving, InterleavingState};
use crate::effect::lag::Lag;
use crate::effect::quadratic::Quadratic;
use crate::effect::rate_power::RatePower;
use crate::effect::resonance::Resonance;
use crate::error::{ParameterError, SampleError};
use crate::hysteresis::RateDependentPi;
use crate::hysteresis::preview::PreviewSettings;
use crate::math::Real;
use hysteresis::{Hysteresis, HysteresisState};

/// Inverse of a [`Chain`], with a window of up to `WINDOW` samples where the hysteresis is inverted
/// with a preview.
///
/// Rate laws, congruencies and elements are undone `WITH_LAWS` only: they divide and take powers in each
/// sample, which a target that has no use for them need not carry.
#[derive(Clone, Copy, Debug)]
pub struct Cascade<
    T,
    const N: usize,
    const M: usize,
    const WINDOW: usize,
    const WITH_LAWS: bool = false,
> {
    offset: T,
    per_gain: T,
    /// Drive for a displacement of one, in V/um, where all plays slide.
    per_static_gain: T,
    effects: Undone<T>,
    asymmetry: Option<Asymmetry<T, M>>,
    hysteresis: Hysteresis<T, N, WINDOW>,
    latency: usize,
}

/// The effects that are undone.
#[derive(Clone, Copy, Debug)]
struct Undone<T> {
    amplifier_lag: Option<Lag<T>>,
    transport_delay: Option<Delay<T, DELAY_SPAN>>,
    rate_law: Option<RatePower<T>>,
    quadratic: Option<Quadratic<T>>,
    cubic: Option<Cubic<T>>,
    backlash: Option<Backlash<T>>,
    resonances: [Option<Resonance<T>>; MODES],
    creep: Option<Creep<T, CREEP_DECADES>>,
    output_quadratic: Option<Quadratic<T>>,
    interleaving: Option<Interleaving<T>>,
}

impl<T: Real> Undone<T> {
    fn new(effects: &Effects<T>) -> Self {
        Self {
            amplifier_lag: effects.amplifier_lag,
            transport_delay: effects.transport_delay,
            rate_law: effects.rate_law,
            quadratic: effects.quadratic,
            cubic: effects.cubic,
            backlash: effects.backlash,
            resonances: effects.resonances,
            creep: effects.creep,
            output_quadratic: effects.output_quadratic,
            interleaving: effects.interleaving,
        }
    }
}

/// State of a cascade.
#[derive(Clone, Copy, Debug)]
pub struct CascadeState<T, const N: usize, const WINDOW: usize> {
    interleaving: Option<InterleavingState<T>>,
    creep: Option<CreepState<T, CREEP_DECADES>>,
    resonances: [Option<Samples<T>>; MODES],
    backlash: Option<BacklashInverse<T>>,
    hysteresis: HysteresisState<T, N, WINDOW>,
    amplifier_lag: Option<Samples<T>>,
    advance: Option<AdvanceState<T>>,
}

impl<T: Real, const N: usize, const M: usize, const WINDOW: usize, const WITH_LAWS: bool>
    Cascade<T, N, M, WINDOW, WITH_LAWS>
{
    /// The inverse of `chain`; of its hysteresis with a preview where `preview` says how and no rate law,
    /// congruency or element stands against it.
    ///
    /// # Errors
    /// A parameter of an inverse that leaves the range of `T`; plays, a congruency or elements that cannot be
    /// inverted; a rate law, a congruency or elements without `WITH_LAWS`.
    pub fn new(
        chain: &Chain<T, N, M>,
        preview: Option<PreviewSettings>,
    ) -> Result<Self, ParameterError> {
        let (model, effects) = (chain.model(), chain.effects());
        let operator = model.hysteresis();
        let hysteresis = Hysteresis::new::<WITH_LAWS>(operator, effects, preview)?;
        let bank = operator.bank().weights();
        let elements = operator.weight_0() + effects.elements.weight();
        let weights = bank.iter().fold(elements, |sum, &a| sum + a);
        Ok(Self {
            offset: model.offset(),
            per_gain: T::ONE / model.gain(),
            per_static_gain: T::ONE / (model.gain() * weights),
            effects: Undone::new(effects),
            asymmetry: model.asymmetry().map(Asymmetry::inverse).transpose()?,
            latency: latency(&Undone::new(effects)) + hysteresis.latency(),
            hysteresis,
        })
    }

    /// Samples between a reference sample going in and its drive coming out: that drive, applied when
    /// it comes, moves the stage to that sample.
    pub fn latency(&self) -> usize {
        self.latency
    }

    /// State after a long rest at the reference `first` (um).
    ///
    /// # Errors
    /// A first sample that is not finite.
    pub fn start(&self, first: T) -> Result<CascadeState<T, N, WINDOW>, SampleError> {
        let effects = &self.effects;
        let y = first - self.offset;
        let interleaving = effects
            .interleaving
            .map(|product| product.start_inverse(y, y * self.per_static_gain));
        let w = self.unscale(interleaving.as_ref(), y)?;
        let bent = self.unbend(w);
        let mut hysteresis = self.hysteresis.start(bent);
        let law = self.law();
        let drive = self
            .hysteresis
            .step::<WITH_LAWS>(&mut hysteresis, law, bent, true)?;
        Ok(CascadeState {
            interleaving,
            creep: effects.creep.map(|creep| creep.start(w)),
            resonances: effects
                .resonances
                .map(|mode| mode.map(|mode| mode.start_inverse(w))),
            backlash: effects.backlash.map(|gap| gap.start_inverse(w)),
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
        let y = reference - self.offset;
        let interleaving = effects
            .interleaving
            .map(|product| product.start_inverse(y, y * self.per_static_gain));
        let mut w = self.unscale(interleaving.as_ref(), y)?;
        state.interleaving = interleaving;
        if let (Some(creep), Some(at)) = (&effects.creep, &mut state.creep) {
            w = creep.step_inverse(at, w);
        }
        for (mode, at) in effects.resonances.iter().zip(&mut state.resonances) {
            *at = mode.map(|mode| mode.start_inverse(w));
        }
        if let (Some(gap), Some(at)) = (&effects.backlash, &mut state.backlash) {
            w = gap.step_inverse(at, w);
        }
        let bent = self.unbend(w);
        let law = self.law();
        let u = self
            .hysteresis
            .step::<WITH_LAWS>(&mut state.hysteresis, law, bent, true)?;
        state.amplifier_lag = effects.amplifier_lag.map(|lag| lag.start_inverse(u));
        state.advance = effects.transport_delay.map(|delay| delay.start_inverse(u));
        Ok(u)
    }

    /// The hysteresis operator whose plays [`Cascade::plays`] are: the inverse one, with a congruency or
    /// elements that of the model.
    pub fn inverse(&self) -> &RateDependentPi<T, N> {
        self.hysteresis.operator()
    }

    /// Outputs of the inverse plays at the latest drive, entries beyond their number of no account.
    pub fn plays(&self, state: &mut CascadeState<T, N, WINDOW>) -> [T; N] {
        self.hysteresis.plays(&mut state.hysteresis)
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
        self.hysteresis.put_plays(&mut state.hysteresis, outputs)
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
        let y = reference - self.offset;
        let mut w = self.unscale(state.interleaving.as_ref(), y)?;
        if let (Some(creep), Some(at)) = (&effects.creep, &mut state.creep) {
            w = creep.step_inverse(at, w);
        }
        let modes = effects.resonances.iter().zip(&mut state.resonances);
        for (mode, at) in modes.rev() {
            if let (Some(mode), Some(at)) = (mode, at) {
                w = mode.step_inverse(at, w);
            }
        }
        if let (Some(gap), Some(at)) = (&effects.backlash, &mut state.backlash) {
            w = gap.step_inverse(at, w);
        }
        let bent = self.unbend(w);
        let law = self.law();
        let mut u = self
            .hysteresis
            .step::<WITH_LAWS>(&mut state.hysteresis, law, bent, false)?;
        if let (Some(lag), Some(at)) = (&effects.amplifier_lag, &mut state.amplifier_lag) {
            u = lag.step_inverse(at, u);
        }
        if let (Some(delay), Some(at)) = (&effects.transport_delay, &mut state.advance) {
            u = delay.step_inverse(at, u);
        }
        if let (Some(product), Some(at)) = (&effects.interleaving, &mut state.interleaving) {
            let drive = if self.latency == 0 {
                u
            } else {
                y * self.per_static_gain
            };
            product.drove(at, y, drive);
        }
        Ok(u)
    }

    /// The rate law, if it can be there.
    #[inline(always)]
    fn law(&self) -> Option<&RatePower<T>> {
        self.effects.rate_law.as_ref().filter(|_| WITH_LAWS)
    }

    /// From a displacement less its offset to what the modes and creep yield.
    #[inline(never)]
    fn unscale(&self, interleaving: Option<&InterleavingState<T>>, y: T) -> Result<T, SampleError> {
        let x = match (&self.effects.interleaving, interleaving) {
            (Some(product), Some(at)) => product.step_inverse(at, y),
            _ => y,
        };
        let w = x * self.per_gain;
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

fn latency<T: Real>(effects: &Undone<T>) -> usize {
    let modes = effects.resonances.iter().flatten().count();
    let lag = effects.amplifier_lag.map_or(0, |_| Lag::<T>::LATENCY);
    let delay = effects.transport_delay.map_or(0, |d| d.latency());
    modes * Resonance::<T>::LATENCY + lag + delay
}
