//! The catalogue of effects that a stage may have besides its hysteresis: for each one its name, where
//! a fit starts, what bounds it, and its stage of a model file.
//!
//! A fit moves plain numbers of about one; an effect turns them into physical ones with the help of
//! what the data have [`Seen`]. A new effect is one file here, one block in the core, and its lines in
//! [`Effect`].

mod amplifier_lag;
mod asymmetry;
mod backlash;
mod congruency;
mod creep;
mod cubic;
mod drift;
mod interleaving;
mod lag;
mod mains_hum;
mod output_quadratic;
mod quadratic;
mod quantisation;
mod rate_dependence;
mod rate_law;
mod resonance;
mod saturation;
mod sensor_lag;
mod slew_limit;
mod transport_delay;

#[cfg(test)]
mod tests;

use serde::Serialize;

pub use mains_hum::hum_starts;
pub use quantisation::step as reading_step;

use crate::model_file::Stage;

use super::run::Runs;

/// An effect of a stage, in the order in which they act.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Effect {
    /// The amplifier's largest voltage.
    Saturation,
    /// The amplifier's largest rate.
    SlewLimit,
    /// The amplifier's lag.
    AmplifierLag,
    /// Delay before the hysteresis.
    TransportDelay,
    /// Thresholds that widen with the rate.
    RateDependence,
    /// A power other than one in that law.
    RateLaw,
    /// Weights that grow with the displacement.
    Congruency,
    /// A map of one-sided dead zones.
    Asymmetry,
    /// Even curvature.
    Quadratic,
    /// Odd curvature.
    Cubic,
    /// A gap behind the hysteresis.
    Backlash,
    /// A mechanical mode; the only effect that may come more than once.
    Resonance,
    /// Creep.
    Creep,
    /// Even curvature behind the modes.
    OutputQuadratic,
    /// The product of displacement and drive one sample before.
    Interleaving,
    /// The sensor's lag.
    SensorLag,
    /// Drift with absolute time.
    Drift,
    /// A line of the mains.
    MainsHum,
    /// Steps of the sensor's reading.
    Quantisation,
}

/// What an effect is to a fit. Numbers are dimensionless; lengths behind the hysteresis are in
/// micrometres, unless a model file's stage has a `gain` (um/V) behind it.
pub trait Template: Sync {
    /// Name in model files, reports and on the command line.
    fn name(&self) -> &'static str;
    /// Values from which fits start.
    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>>;
    /// Least and largest value of each number of a start; a number with equal ones is held.
    fn bounds(&self, seen: &Seen, numbers: &[f64]) -> Vec<(f64, f64)>;
    /// The stage of a model file; the rate term has none of its own.
    fn stage(&self, numbers: &[f64], seen: &Seen, gain: f64) -> Option<Stage>;
    /// The way back: the numbers of a stage that acts on an output of the hysteresis of `gain` um/V.
    /// `None` for the stage of another effect.
    fn numbers(&self, stage: &Stage, seen: &Seen, gain: f64) -> Option<Vec<f64>>;
    /// Why the records cannot show it, if so.
    fn hidden(&self, _seen: &Seen) -> Option<&'static str> {
        None
    }
    /// Whether a compensator undoes it; the others limit what can be reached.
    fn inverted(&self) -> bool {
        true
    }
}

/// What the data show of the stage's scales.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Least time between samples in s.
    pub sample_time_s: f64,
    /// Half the range of the displacement in um.
    pub displacement_um: f64,
    /// Length of the longest record in s.
    pub duration_s: f64,
    /// First and last absolute time in s.
    pub time_s: (f64, f64),
    /// Largest magnitude of the drive in V.
    pub drive_v: f64,
    /// Largest rate of the drive in V/s.
    pub rate_v_per_s: f64,
    /// Widest threshold of a play in V.
    pub threshold_v: f64,
    /// Least and largest displacement by the mean gain alone, in um.
    pub line_um: (f64, f64),
    /// Ratio of the highest to the lowest frequency at which the drive moves.
    pub frequency_span: f64,
    /// Step in um that all readings are whole multiples apart, if there is one.
    pub step_um: Option<f64>,
}

/// Frequencies the records must span for a rate term to be told from a delay: a decade.
pub const DECADE: f64 = 10.0;

impl Seen {
    /// The scales of the records for fitting.
    pub fn new(runs: &Runs) -> Self {
        let mut seen = Self {
            sample_time_s: f64::INFINITY,
            displacement_um: 0.5 * runs.mean_gain() * runs.drive_range,
            duration_s: 0.0,
            time_s: (f64::INFINITY, f64::NEG_INFINITY),
            drive_v: 0.0,
            rate_v_per_s: runs.highest_rate(),
            threshold_v: runs.widest_threshold(),
            line_um: (0.0, 0.0),
            frequency_span: runs.frequency_span,
            step_um: runs.step_um,
        };
        for run in &runs.runs {
            let length = run.drive.len() as f64 * run.sample_time_s;
            seen.sample_time_s = seen.sample_time_s.min(run.sample_time_s);
            seen.duration_s = seen.duration_s.max(length);
            seen.time_s.0 = seen.time_s.0.min(run.start_s);
            seen.time_s.1 = seen.time_s.1.max(run.start_s + length);
            for &u in &run.drive {
                seen.drive_v = seen.drive_v.max(u.abs());
                let line = runs.mean_gain() * u;
                seen.line_um = (seen.line_um.0.min(line), seen.line_um.1.max(line));
            }
        }
        seen
    }
}

impl Effect {
    /// All effects that can be fitted, in the order in which they act.
    pub const ALL: [Self; 19] = [
        Self::Saturation,
        Self::SlewLimit,
        Self::AmplifierLag,
        Self::TransportDelay,
        Self::RateDependence,
        Self::RateLaw,
        Self::Congruency,
        Self::Asymmetry,
        Self::Quadratic,
        Self::Cubic,
        Self::Backlash,
        Self::Resonance,
        Self::Creep,
        Self::OutputQuadratic,
        Self::Interleaving,
        Self::SensorLag,
        Self::Drift,
        Self::MainsHum,
        Self::Quantisation,
    ];

    /// What the effect is to a fit.
    pub fn template(self) -> &'static dyn Template {
        match self {
            Self::Saturation => &saturation::Saturation,
            Self::SlewLimit => &slew_limit::SlewLimit,
            Self::AmplifierLag => &amplifier_lag::AmplifierLag,
            Self::TransportDelay => &transport_delay::TransportDelay,
            Self::RateDependence => &rate_dependence::RateDependence,
            Self::RateLaw => &rate_law::RateLaw,
            Self::Congruency => &congruency::Congruency,
            Self::Asymmetry => &asymmetry::Asymmetry,
            Self::Quadratic => &quadratic::Quadratic,
            Self::Cubic => &cubic::Cubic,
            Self::Backlash => &backlash::Backlash,
            Self::Resonance => &resonance::Resonance,
            Self::Creep => &creep::Creep,
            Self::OutputQuadratic => &output_quadratic::OutputQuadratic,
            Self::Interleaving => &interleaving::Interleaving,
            Self::SensorLag => &sensor_lag::SensorLag,
            Self::Drift => &drift::Drift,
            Self::MainsHum => &mains_hum::MainsHum,
            Self::Quantisation => &quantisation::Quantisation,
        }
    }

    /// Name in model files, reports and on the command line.
    pub fn name(self) -> &'static str {
        self.template().name()
    }

    /// Name of the physical law: even curvature is `quadratic` wherever in the chain it acts.
    pub fn law(self) -> &'static str {
        match self {
            Self::OutputQuadratic => Self::Quadratic.name(),
            other => other.name(),
        }
    }

    /// The effect of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|effect| effect.name() == name)
    }
}

/// Logarithmic spacing of `count` values from `low` to `high`, both included.
fn spread(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    let steps = count.saturating_sub(1).max(1) as f64;
    (0..count).map(move |i| low * (high / low).powf(i as f64 / steps))
}
