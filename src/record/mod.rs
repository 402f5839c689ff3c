//! A model on its way to the target: what a `model.toml` holds, in single precision, and which
//! compensator is to be made of it.
//!
//! Effects are a list in the order of the signal, drive to displacement, so that a new one is a new
//! kind of [`Effect`] and needs no new message. A record is judged whole when its compensator is
//! built; nothing of a bad one comes into force.

mod build;
mod target;

pub use build::LOOK_AHEAD;
pub use target::{Motion, TargetCompensator};

use heapless::Vec;
use serde::{Deserialize, Deserializer, Serialize};

use crate::dim::Law;
use crate::error::ParameterError;
use crate::hysteresis::modified_play::Harmonics;
use crate::hysteresis::preview::PlantRate;

/// Plays that the target has room for.
pub const PLAYS: usize = 16;
/// Weights: one more than plays.
pub const WEIGHTS: usize = PLAYS + 1;
/// Dead zones on each side of the asymmetry map that the target has room for.
pub const DEAD_ZONES: usize = 4;
/// Slopes on each side: one more than dead zones.
pub const SLOPES: usize = DEAD_ZONES + 1;
/// Effects that a record has room for.
pub const EFFECTS: usize = 12;
/// Reference samples that a preview inverse of the target can look at: as many as it has time for at
/// 10 kHz.
pub const WINDOW: usize = 26;

/// How far the sample time of a modified play model may be from that of the settings, over it.
pub const SAMPLE_TIME_TOLERANCE: f32 = 1e-4;

/// A model and its compensator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub enum ModelRecord {
    /// Hysteresis and what stands around it.
    Chain(ChainRecord),
    /// The modified play model with all its terms, compensated by direct inverse multiplication.
    ModifiedPlay(ModifiedPlayRecord),
}

/// Hysteresis and what stands around it; names and keys as in `model.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChainRecord {
    /// `alpha_1..alpha_n` in V.
    pub thresholds_v: Vec<f32, PLAYS>,
    /// `a_0..a_n`.
    pub weights: Vec<f32, WEIGHTS>,
    /// `beta` in s.
    pub beta_s: f32,
    /// The map of one-sided dead zones behind the hysteresis.
    pub asymmetry: Option<AsymmetryRecord>,
    /// In the order of the signal.
    pub effects: Vec<Effect, EFFECTS>,
    /// Gain in um/V.
    pub gain_um_per_v: f32,
    /// Displacement at rest in um.
    pub offset_um: f32,
    /// How all that is inverted.
    pub inverse: Inverse,
}

/// What stands before the hysteresis and behind the asymmetry map; keys as in `model.toml`.
///
/// A new one comes last, wherever it is in the signal: those before it keep their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Effect {
    /// The amplifier's lag.
    AmplifierLag {
        /// Time constant in s.
        tau_s: f32,
    },
    /// The way to the actuator.
    TransportDelay {
        /// Delay in s.
        delay_s: f32,
    },
    /// Even curvature.
    Quadratic {
        /// In 1/V.
        q: f32,
    },
    /// Odd curvature.
    Cubic {
        /// In 1/V^2.
        c: f32,
    },
    /// A mechanical mode; up to [`crate::chain::MODES`] of them.
    Resonance {
        /// Natural frequency in Hz.
        f_n_hz: f32,
        /// Damping ratio.
        zeta: f32,
    },
    /// Creep.
    Creep {
        /// Creep for each decade of time.
        gain_per_decade: f32,
        /// Shortest time constant in s.
        tau_min_s: f32,
        /// Longest time constant in s.
        tau_max_s: f32,
    },
    /// Even curvature behind the modes.
    OutputQuadratic {
        /// In 1/V.
        q: f32,
    },
    /// A gap behind the curvatures, before the modes.
    Backlash {
        /// Whole width in V.
        width: f32,
    },
    /// Product of displacement and drive of the sample before, behind gain and offset.
    Interleaving {
        /// In 1/V.
        g: f32,
    },
}

/// How a [`ChainRecord`] is inverted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Inverse {
    /// The analytic inverse with the rate of the reference; effects are left as they are.
    Explicit,
    /// The preview inverse; effects are left as they are.
    Preview(Preview),
    /// Inverses of all effects around the preview inverse, or around the explicit one where `beta` is
    /// zero.
    Cascade(Preview),
}

/// How a preview inverse works; one sweep a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Preview {
    /// Reference samples that it looks at, `2..=WINDOW`;
    /// [`crate::hysteresis::preview::window_for`] proposes a number.
    pub window: u8,
    /// Which rate of its drive the stage sees.
    pub plant_rate: PlantRate,
}

/// Both sides of the asymmetry map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AsymmetryRecord {
    /// For arguments `>= 0`.
    pub positive: Zones,
    /// For arguments `< 0`.
    pub negative: Zones,
}

/// One side of the asymmetry map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Zones {
    /// `rho_1..rho_m`.
    pub thresholds: Vec<f32, DEAD_ZONES>,
    /// `g_0..g_m`.
    pub slopes: Vec<f32, SLOPES>,
}

/// The modified play model; keys as in `model.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModifiedPlayRecord {
    /// Largest drive of the plane in V.
    pub u_max_v: f32,
    /// `2A` and the slopes of the plays `1..N-1`, in um/V.
    pub slopes_um_per_v: Vec<f32, PLAYS>,
    /// Offset of the plane in um.
    pub offset_um: f32,
    /// `alpha` in s.
    pub alpha_s: f32,
    /// `beta` in s.
    pub beta_s: f32,
    /// `g` in 1/V.
    pub interleaving_per_v: f32,
    /// `c_1..c_3`.
    pub feedback: [f32; 3],
    /// Frequency of the harmonic terms in Hz.
    pub frequency_hz: f32,
    /// Their form.
    pub harmonics: Harmonics,
    /// `A_11`, `A_31`, `A_51`.
    pub sine: [f32; 3],
    /// `A_12`, `A_32`, `A_52`.
    pub cosine: [f32; 3],
    /// Time between the samples that the model was identified with, in s.
    pub sample_time_s: f32,
    /// How it is inverted.
    pub law: Law,
}

/// Why a record is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordError {
    /// An effect comes twice or in the wrong place; its index from zero.
    Order(u8),
    /// A parameter is wrong.
    Parameter(ParameterError),
    /// A modified play model was identified at another sample time than that of the settings.
    SampleTime,
    /// A preview inverse is to look at fewer than two samples or more than [`WINDOW`].
    Window,
}

/// One copy of it on the target, whatever the record is a part of.
#[inline(never)]
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
    from: D,
) -> Result<Option<ModelRecord>, D::Error> {
    Option::deserialize(from)
}

impl From<ParameterError> for RecordError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl Effect {
    /// Its place in the order of the signal.
    fn place(self) -> u8 {
        match self {
            Self::AmplifierLag { .. } => 0,
            Self::TransportDelay { .. } => 1,
            Self::Quadratic { .. } => 2,
            Self::Cubic { .. } => 3,
            Self::Backlash { .. } => 4,
            Self::Resonance { .. } => 5,
            Self::Creep { .. } => 6,
            Self::OutputQuadratic { .. } => 7,
            Self::Interleaving { .. } => 8,
        }
    }
}
