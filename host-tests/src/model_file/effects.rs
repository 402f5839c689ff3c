//! The stages around the hysteresis: a few numbers each.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Stage;

/// First-order lag of the amplifier: tau u' + u = drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AmplifierLag {
    /// tau in s.
    #[schemars(range(min = 0.0))]
    pub tau_s: f64,
}

/// Delay between the drive and the actuator.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TransportDelay {
    /// The delay in s.
    #[schemars(range(min = 0.0))]
    pub delay_s: f64,
}

/// Even curvature: w + q w^2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quadratic {
    /// q in 1/V.
    pub q: f64,
}

/// Odd curvature: w + c w^3.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cubic {
    /// c in 1/V^2.
    pub c: f64,
}

/// A mechanical mode: y'' + 2 zeta w_n y' + w_n^2 y = w_n^2 w.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Resonance {
    /// Natural frequency in Hz.
    #[schemars(range(min = 0.0))]
    pub f_n_hz: f64,
    /// Damping ratio, from 0 to below 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub zeta: f64,
}

/// Creep: w + sum of gain (x_j - w at the start), where x_j follows w with the time constants
/// tau_min, 10 tau_min, .. tau_max.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Creep {
    /// Growth of the step response a decade of time, as a share of the step.
    pub gain_per_decade: f64,
    /// Shortest time constant in s.
    #[schemars(range(min = 0.0))]
    pub tau_min_s: f64,
    /// Longest time constant in s.
    #[schemars(range(min = 0.0))]
    pub tau_max_s: f64,
}

/// Limit of the amplifier: the drive within -limit to limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Saturation {
    /// The limit in V, > 0.
    #[schemars(range(min = 0.0))]
    pub limit_v: f64,
}

/// Limit of the amplifier's rate: |u'| <= slew.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SlewLimit {
    /// The largest rate in V/s, > 0.
    #[schemars(range(min = 0.0))]
    pub slew_v_per_s: f64,
}

/// Power law of the rate in the hysteresis: thresholds alpha_i + beta |u'|^exponent, u' in V/s.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RateLaw {
    /// The exponent, above 0 and up to 4; 1 is the law without this stage.
    #[schemars(range(min = 0.0, max = 4.0))]
    pub exponent: f64,
}

/// Element of Bouc and Wen beside the plays: w grows by weight (u - z), where z' = u' - grow |u'| z -
/// shape u' |z|.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoucWen {
    /// The weight in V/V, >= 0.
    #[schemars(range(min = 0.0))]
    pub weight: f64,
    /// grow in 1/V, > 0 and > -shape.
    #[schemars(range(min = 0.0))]
    pub grow_per_v: f64,
    /// shape in 1/V.
    pub shape_per_v: f64,
}

/// Plays that count for more where the output is large: w = a_0 u + (1 + kappa gain w) sum a_i z_i.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Congruency {
    /// kappa in 1/um of the displacement gain w, the gain being that of the output stage.
    pub kappa: f64,
}

/// A gap behind the hysteresis: the output rests while w crosses it and stays within w +/- width / 2.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Backlash {
    /// The whole width of the gap in V, the unit of w.
    #[schemars(range(min = 0.0))]
    pub width: f64,
}

/// Product of displacement and drive of the sample before: y(k) = x(k) + g y(k-1) u(k-1), x and y less
/// the offset of the output stage, u the commanded drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Interleaving {
    /// g in 1/V.
    pub g: f64,
}

/// First-order lag of the sensor: tau y' + y = displacement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensorLag {
    /// tau in s.
    #[schemars(range(min = 0.0))]
    pub tau_s: f64,
}

/// Drift of what is measured: amplitude (1 - exp(-t / tau)), t the time of the record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drift {
    /// Where it ends, in um.
    pub amplitude: f64,
    /// tau in s, > 0; far beyond the record it is a line.
    #[schemars(range(min = 0.0))]
    pub tau_s: f64,
}

/// Hum of the mains on what is measured: amplitude sin(2 pi f t + phase) and its third harmonic,
/// third_amplitude sin(6 pi f t + third_phase), t the time of the record.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MainsHum {
    /// f in Hz, > 0.
    #[schemars(range(min = 0.0))]
    pub frequency_hz: f64,
    /// Amplitude in um.
    pub amplitude: f64,
    /// Phase in rad at time zero.
    pub phase_rad: f64,
    /// Amplitude of the third harmonic in um.
    #[serde(default)]
    pub third_amplitude: f64,
    /// Phase of the third harmonic in rad at time zero.
    #[serde(default)]
    pub third_phase_rad: f64,
}

/// Steps of what is measured: the nearest multiple of the step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Quantisation {
    /// The step in um, > 0.
    #[schemars(range(min = 0.0))]
    pub step: f64,
}

impl Stage {
    /// Keys and numbers of an effect; none for the other stages.
    pub fn effect_numbers(&self) -> Vec<(&'static str, f64)> {
        match self {
            Self::Saturation(limit) => vec![("limit_v", limit.limit_v)],
            Self::SlewLimit(limit) => vec![("slew_v_per_s", limit.slew_v_per_s)],
            Self::AmplifierLag(lag) => vec![("tau_s", lag.tau_s)],
            Self::TransportDelay(delay) => vec![("delay_s", delay.delay_s)],
            Self::RateLaw(law) => vec![("exponent", law.exponent)],
            Self::BoucWen(element) => vec![
                ("weight", element.weight),
                ("grow_per_v", element.grow_per_v),
                ("shape_per_v", element.shape_per_v),
            ],
            Self::Congruency(congruency) => vec![("kappa", congruency.kappa)],
            Self::Quadratic(map) | Self::OutputQuadratic(map) => vec![("q", map.q)],
            Self::Cubic(map) => vec![("c", map.c)],
            Self::Backlash(gap) => vec![("width", gap.width)],
            Self::Resonance(mode) => vec![("f_n_hz", mode.f_n_hz), ("zeta", mode.zeta)],
            Self::Creep(creep) => vec![
                ("gain_per_decade", creep.gain_per_decade),
                ("tau_min_s", creep.tau_min_s),
                ("tau_max_s", creep.tau_max_s),
            ],
            Self::Interleaving(product) => vec![("g", product.g)],
            Self::SensorLag(lag) => vec![("tau_s", lag.tau_s)],
            Self::Drift(drift) => vec![("amplitude", drift.amplitude), ("tau_s", drift.tau_s)],
            Self::MainsHum(hum) => vec![
                ("frequency_hz", hum.frequency_hz),
                ("amplitude", hum.amplitude),
                ("phase_rad", hum.phase_rad),
                ("third_amplitude", hum.third_amplitude),
                ("third_phase_rad", hum.third_phase_rad),
            ],
            Self::Quantisation(steps) => vec![("step", steps.step)],
            Self::Hysteresis(_) | Self::Asymmetry(_) | Self::Output(_) | Self::ModifiedPlay(_) => {
                Vec::new()
            }
        }
    }

    /// The stage beside a gain of the other sign, where `sign` is -1: what is added to or measured by the
    /// displacement changes sign with it.
    pub fn signed(&self, sign: f64) -> Self {
        let mut stage = self.clone();
        match &mut stage {
            Self::Congruency(law) => law.kappa *= sign,
            Self::Drift(drift) => drift.amplitude *= sign,
            Self::MainsHum(hum) => {
                hum.amplitude *= sign;
                hum.third_amplitude *= sign;
            }
            _ => {}
        }
        stage
    }

    /// Whether the cascade undoes the stage; of the others some lose what they hold back, and some are
    /// no motion but the sensor's.
    pub fn inverted(&self) -> bool {
        !matches!(
            self,
            Self::Saturation(_)
                | Self::SlewLimit(_)
                | Self::SensorLag(_)
                | Self::Drift(_)
                | Self::MainsHum(_)
                | Self::Quantisation(_)
        )
    }
}
