//! A whole stage with every effect around its hysteresis: drive in volts to displacement in
//! micrometres.
//!
//! ```text
//! drive -> amplifier lag -> transport delay -> Psi -> Lambda -> quadratic -> cubic
//!       -> mechanical modes -> creep -> output quadratic -> gain and offset -> displacement
//! ```
//!
//! Every effect but the hysteresis is optional; without any of them a chain is its
//! [`Model`]. One set of parameters serves every frequency and amplitude.

use crate::effect::creep::{Creep, CreepState};
use crate::effect::cubic::Cubic;
use crate::effect::delay::{Delay, DelayState};
use crate::effect::lag::{Lag, LagState};
use crate::effect::quadratic::Quadratic;
use crate::effect::resonance::{Resonance, ResonanceState};
use crate::hysteresis::State;
use crate::math::Real;
use crate::model::Model;

/// Samples that a transport delay spans: delays of up to three samples less.
pub const DELAY_SPAN: usize = 32;
/// Mechanical modes.
pub const MODES: usize = 3;
/// Decades of creep.
pub const CREEP_DECADES: usize = 8;

/// What stands around the hysteresis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effects<T> {
    /// The amplifier's lag, before the hysteresis.
    pub amplifier_lag: Option<Lag<T>>,
    /// The way to the actuator.
    pub transport_delay: Option<Delay<T, DELAY_SPAN>>,
    /// Even curvature.
    pub quadratic: Option<Quadratic<T>>,
    /// Odd curvature.
    pub cubic: Option<Cubic<T>>,
    /// Mechanical modes, one after the other.
    pub resonances: [Option<Resonance<T>>; MODES],
    /// Creep.
    pub creep: Option<Creep<T, CREEP_DECADES>>,
    /// Even curvature behind the modes, of what moves rather than of what drives it.
    pub output_quadratic: Option<Quadratic<T>>,
}

/// A stage with up to `N` plays, up to `M` dead zones on each side of its asymmetry map, and effects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain<T, const N: usize, const M: usize> {
    pub(crate) model: Model<T, N, M>,
    pub(crate) effects: Effects<T>,
}

/// State of a chain.
#[derive(Clone, Copy, Debug)]
pub struct ChainState<T, const N: usize> {
    amplifier_lag: Option<LagState<T>>,
    transport_delay: Option<DelayState<T, DELAY_SPAN>>,
    hysteresis: State<T, N>,
    resonances: [Option<ResonanceState<T>>; MODES],
    creep: Option<CreepState<T, CREEP_DECADES>>,
}

impl<T: Real, const N: usize, const M: usize> Chain<T, N, M> {
    /// The chain of a model and what stands around its hysteresis, built for the same sample time.
    pub fn new(model: Model<T, N, M>, effects: Effects<T>) -> Self {
        Self { model, effects }
    }

    /// State after a long rest at the drive `first` (V): plays at zero or as near to it as that
    /// drive allows, lags and modes settled, creep done.
    pub fn start(&self, first: T) -> ChainState<T, N> {
        self.start_from(first, self.model.start(first))
    }

    /// As [`Chain::start`] with plays that stand elsewhere; `hysteresis` is the state before the drive
    /// `first`.
    pub fn start_from(&self, first: T, hysteresis: State<T, N>) -> ChainState<T, N> {
        let effects = &self.effects;
        let mut settled = hysteresis;
        let w = self.bend(self.model.hysteresis().step(&mut settled, first));
        ChainState {
            amplifier_lag: effects.amplifier_lag.map(|lag| lag.start(first)),
            transport_delay: effects.transport_delay.map(|delay| delay.start(first)),
            hysteresis,
            resonances: effects
                .resonances
                .map(|mode| mode.map(|mode| mode.start(w))),
            creep: effects.creep.map(|creep| creep.start(w)),
        }
    }

    /// Displacement (um) for the next drive sample (V), which is finite.
    #[inline(always)]
    pub fn step(&self, state: &mut ChainState<T, N>, drive: T) -> T {
        let effects = &self.effects;
        let mut u = drive;
        if let (Some(lag), Some(at)) = (&effects.amplifier_lag, &mut state.amplifier_lag) {
            u = lag.step(at, u);
        }
        if let (Some(delay), Some(at)) = (&effects.transport_delay, &mut state.transport_delay) {
            u = delay.step(at, u);
        }
        let mut w = self.bend(self.model.hysteresis().step(&mut state.hysteresis, u));
        for (mode, at) in effects.resonances.iter().zip(&mut state.resonances) {
            if let (Some(mode), Some(at)) = (mode, at) {
                w = mode.step(at, w);
            }
        }
        if let (Some(creep), Some(at)) = (&effects.creep, &mut state.creep) {
            w = creep.step(at, w);
        }
        if let Some(quadratic) = &effects.output_quadratic {
            w = quadratic.step(w);
        }
        self.model.scale(w)
    }

    /// The maps without memory behind the hysteresis.
    #[inline(always)]
    fn bend(&self, w: T) -> T {
        let mut w = self.model.map(w);
        if let Some(quadratic) = &self.effects.quadratic {
            w = quadratic.step(w);
        }
        if let Some(cubic) = &self.effects.cubic {
            w = cubic.step(w);
        }
        w
    }

    /// Hysteresis, asymmetry, gain and offset.
    pub fn model(&self) -> &Model<T, N, M> {
        &self.model
    }

    /// What stands around the hysteresis.
    pub fn effects(&self) -> &Effects<T> {
        &self.effects
    }
}
