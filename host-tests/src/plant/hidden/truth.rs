//! `truth.toml`: what is hidden in a data set.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Place};
use crate::toml_text::read_text;

/// One figure for each role of records, um.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Roles {
    /// Over the records to fit.
    pub fit: f64,
    /// Over the records to select on.
    pub select: f64,
    /// Over the records to report.
    pub report: f64,
}

/// The truth about a hidden case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Truth {
    /// Version of this form, 1.
    pub version: u32,
    /// Names of the hidden effects, in the order of the signal chain; empty for none.
    pub effects: Vec<String>,
    /// Seed of everything random.
    pub seed: u64,
    /// Tier, 1 to 4.
    pub tier: u8,
    /// Name of the protocol.
    pub protocol: String,
    /// Strength asked for of each effect, percent of the stroke.
    pub strength: f64,
    /// Rms of the noise, percent of the stroke.
    pub noise_percent: f64,
    /// Rms of the noise, um.
    pub noise_um: f64,
    /// Whether the noise is coloured.
    pub noise_coloured: bool,
    /// Rms of what all effects together move, um.
    pub moves_um: Roles,
    /// The same after the best offset and gain on the answers without them, um.
    pub leaves_um: Roles,
    /// The stage without effects.
    pub stage: StageTruth,
    /// The effects.
    #[serde(default, rename = "effect")]
    pub details: Vec<EffectTruth>,
}

/// A stage without effects.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StageTruth {
    /// `plays`, `relays` or `bouc-wen`.
    pub family: String,
    /// Displacement over the drive's whole range, um.
    pub stroke_um: f64,
    /// Displacement for a core that has moved a volt, um/V.
    pub gain_um_per_v: f64,
    /// Displacement at 0 V in the virgin state, um.
    pub offset_um: f64,
    /// Largest width of the slow loop, percent.
    pub hysteresis_percent: f64,
    /// beta of the rate term, s; 0 for none, and where the hidden effect is `rate-dependence`.
    pub beta_s: f64,
    /// Weight of the drive itself.
    pub direct: f64,
    /// Thresholds of plays, V; empty for other families.
    pub thresholds_v: Vec<f64>,
    /// Weights of plays; empty for other families.
    pub weights: Vec<f64>,
}

/// A hidden effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectTruth {
    /// Its name.
    pub name: String,
    /// Strength it has, percent of the stroke: that asked for unless bounded.
    pub strength: f64,
    /// Whether its physical bound came before the strength asked for.
    pub bounded: bool,
    /// Its parameters by key.
    pub parameters: toml::Table,
    /// Rms of what it moves alone, um.
    pub moves_um: Roles,
    /// The same after the best offset and gain on the answers without it, um.
    pub leaves_um: Roles,
}

impl Truth {
    /// The text of `truth.toml`.
    ///
    /// # Errors
    /// A seed beyond what TOML holds, 2^63 - 1.
    pub fn to_toml(&self) -> Result<String, Error> {
        toml::to_string(self).map_err(|refused| {
            Error::request(format!(
                "the truth cannot be written: {refused}; take another seed"
            ))
        })
    }

    /// Reads a `truth.toml`.
    ///
    /// # Errors
    /// One line for a file that cannot be read or is not of this form.
    pub fn load(path: impl AsRef<std::path::Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let text = read_text(path)?;
        toml::from_str(&text).map_err(|refused| {
            Place::file(path).error(format!(
                "is no truth of hidden data: {}; hide again",
                refused.message()
            ))
        })
    }
}
