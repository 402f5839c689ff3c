//! The stages around the hysteresis: a few numbers each.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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
