//! The stage `modified-play`: paper M's model, a whole one by itself.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Modified play model with output feedback, harmonic terms and interleaving: displacement in um for
/// a drive in V. The printed plane of plays, collapsed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModifiedPlay {
    /// Time between the samples that it was identified with, in s: it holds at this one only.
    #[schemars(range(min = 0.0))]
    pub sample_time_s: f64,
    /// Largest drive in V that the plane covers, > 0; the compensator stays within it.
    #[schemars(range(min = 0.0))]
    pub u_max_v: f64,
    /// 2A, then the slopes of the plays 1 .. N-1 with thresholds i u_max / N, in um/V.
    #[schemars(length(min = 2, max = 16))]
    pub slopes_um_per_v: Vec<f64>,
    /// Displacement in um with drive and plays at zero.
    pub offset_um: f64,
    /// Slope alpha of the lower envelope in s.
    #[schemars(range(min = 0.0))]
    pub alpha_s: f64,
    /// Slope beta of the upper envelope in s.
    #[schemars(range(min = 0.0))]
    pub beta_s: f64,
    /// g in 1/V.
    pub interleaving_per_v: f64,
    /// c_1, c_2, c_3.
    pub feedback: [f64; 3],
    /// Frequency of the harmonic terms in Hz.
    #[schemars(range(min = 0.0))]
    pub frequency_hz: f64,
    /// Form of the harmonic terms.
    pub harmonics: Harmonics,
    /// A_11, A_31, A_51, in um over the drive's powers in V: 1, 3, 5 as printed, 0, 2, 4 corrected.
    pub sine: [f64; 3],
    /// A_12, A_32, A_52, likewise.
    pub cosine: [f64; 3],
    /// How it is inverted.
    pub law: Law,
}

/// Form of the harmonic terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Harmonics {
    /// Odd powers of the drive times sine and cosine.
    Printed,
    /// Even powers of the drive times sine and cosine.
    Corrected,
}

/// How the model is inverted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// With the plays one sample late.
    Printed,
    /// Solved within the sample, at a held rate.
    Exact,
}

impl From<Harmonics> for hysteron::hysteresis::modified_play::Harmonics {
    fn from(form: Harmonics) -> Self {
        match form {
            Harmonics::Printed => Self::Printed,
            Harmonics::Corrected => Self::Corrected,
        }
    }
}

impl From<Law> for hysteron::dim::Law {
    fn from(law: Law) -> Self {
        match law {
            Law::Printed => Self::Printed,
            Law::Exact => Self::Exact,
        }
    }
}
