//! Effects around the hysteresis as a fit sees them: a list of terms and a list of numbers.

use hysteron::chain::Effects;
use hysteron::error::ParameterError;

use crate::model_file::{self, Stage};
use crate::stage;

/// An effect that can be fitted together with the hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effect {
    /// The amplifier's lag: tau in s.
    AmplifierLag,
    /// Delay before the hysteresis, in s.
    TransportDelay,
    /// Even curvature.
    Quadratic,
    /// Odd curvature.
    Cubic,
    /// A mechanical mode: frequency in Hz, damping ratio.
    Resonance,
    /// Creep: its gain a decade.
    Creep,
    /// Even curvature behind the modes.
    OutputQuadratic,
}

/// What the numbers are measured by.
#[derive(Clone, Copy, Debug)]
pub struct Scale {
    /// Time between samples in s.
    pub sample_time_s: f64,
    /// Half the range of the displacement in um.
    pub displacement_um: f64,
    /// Length of the longest record in s.
    pub duration_s: f64,
}

/// Effects with their numbers, lengths in micrometres behind the hysteresis.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// The effects in the order of the signal.
    pub effects: Vec<Effect>,
    /// Their numbers one after the other, each made dimensionless so that a step of 1e-2 matters:
    /// times in samples, curvatures at half the range, frequency and damping as logarithms.
    pub numbers: Vec<f64>,
}

impl Terms {
    /// `effects` at values that do nothing, or for a mode at `f_n_hz`.
    pub fn new(effects: &[Effect], f_n_hz: f64) -> Self {
        let mut effects = effects.to_vec();
        effects.sort();
        let numbers = effects
            .iter()
            .flat_map(|effect| match effect {
                Effect::Resonance => vec![f_n_hz.ln(), 0.03f64.ln()],
                _ => vec![0.0],
            })
            .collect();
        Self { effects, numbers }
    }

    /// Pulls numbers back to what the effects allow.
    pub fn limit(&mut self, scale: &Scale) {
        let nyquist = 0.45 / scale.sample_time_s;
        let mut numbers = self.numbers.iter_mut();
        for effect in &self.effects {
            let mut clamp = |low: f64, high: f64| {
                if let Some(number) = numbers.next() {
                    *number = number.clamp(low, high);
                }
            };
            match effect {
                Effect::AmplifierLag => clamp(0.0, 1e4),
                Effect::TransportDelay => clamp(0.0, 25.0),
                Effect::Quadratic | Effect::OutputQuadratic => clamp(-0.3, 0.3),
                Effect::Cubic => clamp(-0.2, 1.0),
                Effect::Resonance => {
                    clamp((0.5 / scale.duration_s).ln(), nyquist.ln());
                    clamp(1e-4f64.ln(), 0.9f64.ln());
                }
                Effect::Creep => clamp(-0.2, 1.0),
            }
        }
    }

    /// The blocks of the core, for a sample time of their own; everything behind the hysteresis in
    /// micrometres.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn build(&self, scale: &Scale, h: f64) -> Result<Effects<f64>, ParameterError> {
        stage::effects(&self.stages(scale, 1.0), h).map_err(|(_, refused)| refused)
    }

    /// The stages of a model file whose hysteresis has the given gain in um/V.
    pub fn stages(&self, scale: &Scale, gain: f64) -> Vec<Stage> {
        let mut numbers = self.numbers.iter().copied();
        let mut next = || numbers.next().unwrap_or(0.0);
        // In volts a curvature counts as often as the gain turns them into micrometres.
        let per_um = 1.0 / scale.displacement_um;
        self.effects
            .iter()
            .map(|effect| match effect {
                Effect::AmplifierLag => Stage::AmplifierLag(model_file::AmplifierLag {
                    tau_s: next() * scale.sample_time_s,
                }),
                Effect::TransportDelay => Stage::TransportDelay(model_file::TransportDelay {
                    delay_s: next() * scale.sample_time_s,
                }),
                Effect::Quadratic => Stage::Quadratic(model_file::Quadratic {
                    q: next() * per_um * gain,
                }),
                Effect::OutputQuadratic => Stage::OutputQuadratic(model_file::Quadratic {
                    q: next() * per_um * gain,
                }),
                Effect::Cubic => Stage::Cubic(model_file::Cubic {
                    c: next() * (per_um * gain).powi(2),
                }),
                Effect::Resonance => Stage::Resonance(model_file::Resonance {
                    f_n_hz: next().exp(),
                    zeta: next().exp(),
                }),
                Effect::Creep => {
                    // From ten samples to about the length of the longest record.
                    let tau_min_s = 10.0 * scale.sample_time_s;
                    let decades = (scale.duration_s / tau_min_s)
                        .log10()
                        .floor()
                        .clamp(0.0, 6.0);
                    Stage::Creep(model_file::Creep {
                        gain_per_decade: next(),
                        tau_min_s,
                        tau_max_s: tau_min_s * 10f64.powf(decades),
                    })
                }
            })
            .collect()
    }
}
