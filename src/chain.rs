//! A whole stage with every effect around its hysteresis: drive in volts to displacement in
//! micrometres.
//!
//! ```text
//! drive -> saturation -> slew limit -> amplifier lag -> transport delay
//!       -> Psi, with its rate law, elements and congruency -> Lambda -> quadratic -> cubic -> backlash
//!       -> mechanical modes -> creep -> output quadratic -> gain and offset
//!       -> interleaving -> sensor lag -> + drift -> + mains hum -> quantisation -> displacement
//! ```
//!
//! What stands before the gain counts in volts, what stands behind it in micrometres.
//!
//! Every effect but the hysteresis is optional; without any of them a chain is its
//! [`Model`]. One set of parameters serves every frequency and amplitude.

use crate::effect::backlash::{Backlash, BacklashState};
use crate::effect::congruency::Congruency;
use crate::effect::creep::{Creep, CreepState};
use crate::effect::cubic::Cubic;
use crate::effect::delay::{Delay, DelayState};
use crate::effect::drift::Drift;
use crate::effect::interleaving::{Interleaving, InterleavingState};
use crate::effect::lag::{Lag, LagState};
use crate::effect::mains_hum::MainsHum;
use crate::effect::quadratic::Quadratic;
use crate::effect::quantisation::Quantisation;
use crate::effect::rate_power::RatePower;
use crate::effect::resonance::{Resonance, ResonanceState};
use crate::effect::saturation::Saturation;
use crate::effect::slew_limit::{SlewLimit, SlewState};
use crate::hysteresis::State;
use crate::hysteresis::elements::{Elements, ElementsState};
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
    /// The amplifier's limit.
    pub saturation: Option<Saturation<T>>,
    /// The limit of the amplifier's rate.
    pub slew_limit: Option<SlewLimit<T>>,
    /// The amplifier's lag, before the hysteresis.
    pub amplifier_lag: Option<Lag<T>>,
    /// The way to the actuator.
    pub transport_delay: Option<Delay<T, DELAY_SPAN>>,
    /// Power law of the rate in the hysteresis, whose beta then counts in `V (s/V)^p`.
    pub rate_law: Option<RatePower<T>>,
    /// Elements of Bouc and Wen beside the plays.
    pub elements: Elements<T>,
    /// Plays that count for more where the output is large.
    pub congruency: Option<Congruency<T>>,
    /// Even curvature.
    pub quadratic: Option<Quadratic<T>>,
    /// Odd curvature.
    pub cubic: Option<Cubic<T>>,
    /// A gap in what the hysteresis moves.
    pub backlash: Option<Backlash<T>>,
    /// Mechanical modes, one after the other.
    pub resonances: [Option<Resonance<T>>; MODES],
    /// Creep.
    pub creep: Option<Creep<T, CREEP_DECADES>>,
    /// Even curvature behind the modes, of what moves rather than of what drives it.
    pub output_quadratic: Option<Quadratic<T>>,
    /// Product of displacement and drive of the sample before.
    pub interleaving: Option<Interleaving<T>>,
    /// The sensor's lag.
    pub sensor_lag: Option<Lag<T>>,
    /// Drift of what is measured.
    pub drift: Option<Drift<T>>,
    /// Hum on what is measured.
    pub mains_hum: Option<MainsHum<T>>,
    /// Steps of what is measured.
    pub quantisation: Option<Quantisation<T>>,
}

impl<T> Effects<T> {
    /// The same without what only the measurement sees: sensor lag, drift, hum and quantisation.
    pub fn of_motion(self) -> Self {
        Self {
            sensor_lag: None,
            drift: None,
            mains_hum: None,
            quantisation: None,
            ..self
        }
    }
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
    slew_limit: Option<SlewState<T>>,
    amplifier_lag: Option<LagState<T>>,
    transport_delay: Option<DelayState<T, DELAY_SPAN>>,
    hysteresis: State<T, N>,
    elements: ElementsState<T>,
    backlash: Option<BacklashState<T>>,
    resonances: [Option<ResonanceState<T>>; MODES],
    creep: Option<CreepState<T, CREEP_DECADES>>,
    interleaving: Option<InterleavingState<T>>,
    sensor_lag: Option<LagState<T>>,
    /// Time of the first sample in s, and samples since.
    began: f64,
    samples: u64,
}

impl<T, const N: usize> ChainState<T, N> {
    /// Sets the clock that drift and hum follow: the next sample is that of `time` seconds.
    pub fn set_time(&mut self, time: f64) {
        self.began = time;
        self.samples = 0;
    }
}

impl<T: Real, const N: usize, const M: usize> Chain<T, N, M> {
    /// The chain of a model and what stands around its hysteresis, built for the same sample time.
    pub fn new(model: Model<T, N, M>, effects: Effects<T>) -> Self {
        Self { model, effects }
    }

    /// State after a long rest at the drive `first` (V): plays at zero or as near to it as that
    /// drive allows, lags and modes settled, creep done; time zero at the first sample.
    pub fn start(&self, first: T) -> ChainState<T, N> {
        self.start_from(first, self.model.start(self.limit(first)))
    }

    /// As [`Chain::start`] with plays that stand elsewhere; `hysteresis` is the state before the drive
    /// `first`.
    pub fn start_from(&self, first: T, hysteresis: State<T, N>) -> ChainState<T, N> {
        let effects = &self.effects;
        let drive = self.limit(first);
        let elements = effects.elements.start();
        let mut settled = (hysteresis, elements);
        let w = self.bend(self.core(&mut settled.0, &mut settled.1, drive));
        let moved = match &effects.output_quadratic {
            Some(quadratic) => quadratic.step(w),
            None => w,
        };
        let (mut y, offset) = (self.model.scale(moved), self.model.offset());
        let interleaving = effects.interleaving.map(|product| {
            let mut state = product.start(y - offset, first);
            y = product.step(&mut state, y - offset, first) + offset;
            state
        });
        ChainState {
            slew_limit: effects.slew_limit.map(|limit| limit.start(drive)),
            amplifier_lag: effects.amplifier_lag.map(|lag| lag.start(drive)),
            transport_delay: effects.transport_delay.map(|delay| delay.start(drive)),
            hysteresis,
            elements,
            backlash: effects.backlash.map(|gap| gap.start(w)),
            resonances: effects
                .resonances
                .map(|mode| mode.map(|mode| mode.start(w))),
            creep: effects.creep.map(|creep| creep.start(w)),
            interleaving,
            sensor_lag: effects.sensor_lag.map(|lag| lag.start(y)),
            began: 0.0,
            samples: 0,
        }
    }

    /// Displacement (um) as it is measured for the next drive sample (V), which is finite.
    #[inline(always)]
    pub fn step(&self, state: &mut ChainState<T, N>, drive: T) -> T {
        let effects = &self.effects;
        let mut u = self.limit(drive);
        if let (Some(limit), Some(at)) = (&effects.slew_limit, &mut state.slew_limit) {
            u = limit.step(at, u);
        }
        if let (Some(lag), Some(at)) = (&effects.amplifier_lag, &mut state.amplifier_lag) {
            u = lag.step(at, u);
        }
        if let (Some(delay), Some(at)) = (&effects.transport_delay, &mut state.transport_delay) {
            u = delay.step(at, u);
        }
        let mut w = self.bend(self.core(&mut state.hysteresis, &mut state.elements, u));
        if let (Some(gap), Some(at)) = (&effects.backlash, &mut state.backlash) {
            w = gap.step(at, w);
        }
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
        self.measure(state, self.model.scale(w), drive)
    }

    /// The drive within the amplifier's limit.
    #[inline(always)]
    fn limit(&self, drive: T) -> T {
        match &self.effects.saturation {
            Some(saturation) => saturation.step(drive),
            None => drive,
        }
    }

    /// The hysteresis with its rate law, elements and congruency.
    #[inline(always)]
    fn core(&self, state: &mut State<T, N>, elements: &mut ElementsState<T>, u: T) -> T {
        let operator = self.model.hysteresis();
        let rate = self.effects.rate_law.as_ref().map(|law| {
            let rate = (u - state.previous()) / operator.sample_time();
            law.step(rate)
        });
        let envelope = operator.envelope(state, u, rate);
        let mut w = match rate {
            Some(rate) => operator.step_with_rate(state, u, rate),
            None => operator.step(state, u),
        };
        if !self.effects.elements.is_empty() {
            w = w + self.effects.elements.step(elements, u, envelope);
        }
        match &self.effects.congruency {
            Some(congruency) => {
                let direct = operator.weight_0() * u;
                congruency.step(direct, w - direct)
            }
            None => w,
        }
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

    /// What stands behind the gain, on a displacement in um.
    #[inline(always)]
    fn measure(&self, state: &mut ChainState<T, N>, displacement: T, drive: T) -> T {
        let effects = &self.effects;
        let mut y = displacement;
        if let (Some(product), Some(at)) = (&effects.interleaving, &mut state.interleaving) {
            let offset = self.model.offset();
            y = product.step(at, y - offset, drive) + offset;
        }
        if let (Some(lag), Some(at)) = (&effects.sensor_lag, &mut state.sensor_lag) {
            y = lag.step(at, y);
        }
        if effects.drift.is_some() || effects.mains_hum.is_some() {
            let h = self.model.hysteresis().sample_time().to_f64();
            let time = state.began + h * state.samples as f64;
            state.samples = state.samples.wrapping_add(1);
            if let Some(drift) = &effects.drift {
                y = y + drift.at(time);
            }
            if let Some(hum) = &effects.mains_hum {
                y = y + hum.at(time);
            }
        }
        match &effects.quantisation {
            Some(quantisation) => quantisation.step(y),
            None => y,
        }
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
