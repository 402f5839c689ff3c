//! `model.toml`: an identified or published model as an ordered list of stages.
//!
//! `docs/model.md` is the format's description. This module guards the form (keys, units, order,
//! array lengths, finite numbers); whether the numbers make an invertible model is judged by the
//! core when the model is built.

mod builtin;
mod effects;
mod modified_play;
mod parse;
mod write;

use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};

pub use builtin::{BUILTIN_NAMES, builtin, resolve};
pub use effects::{
    AmplifierLag, Backlash, BoucWen, Congruency, Creep, Cubic, Drift, Interleaving, MainsHum,
    Quadratic, Quantisation, RateLaw, Resonance, Saturation, SensorLag, SlewLimit, TransportDelay,
};
pub use modified_play::{Harmonics, Law, ModifiedPlay};
pub use parse::{ORDER, load, parse};

/// The version of the format that this program writes, and the newest that it reads.
pub const VERSION: u32 = 1;

/// A model: what a `model.toml` holds.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "hysteron model")]
pub struct ModelFile {
    /// Marks the file as a model.
    pub format: Format,
    /// Version of the format.
    #[schemars(range(min = 1, max = 1))]
    pub version: u32,
    /// Name of the model, for reports.
    pub name: String,
    /// Units of everything in the file.
    pub units: Units,
    /// Stages in the order of the signal, drive to displacement: `saturation`, `slew-limit`,
    /// `amplifier-lag`, `transport-delay`, `hysteresis`, `bouc-wen`, `rate-law`, `congruency`, `asymmetry`,
    /// `quadratic`, `cubic`, `backlash`, `resonance`, `creep`, `output-quadratic`, `output`,
    /// `interleaving`, `sensor-lag`, `drift`, `mains-hum`, `quantisation`, all but the hysteresis where
    /// there are any; or `modified-play` alone.
    #[serde(rename = "stage")]
    #[schemars(length(min = 1))]
    pub stages: Vec<Stage>,
}

/// The mark of a model file.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
pub enum Format {
    /// The only mark there is.
    #[default]
    #[serde(rename = "hysteron-model")]
    HysteronModel,
}

/// The units of a model file; stated in the file so that no reader has to guess.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Units {
    /// Unit of time.
    pub time: ModelTimeUnit,
    /// Unit of the drive.
    pub drive: ModelDriveUnit,
    /// Unit of the displacement.
    pub displacement: ModelDisplacementUnit,
}

/// Unit of time in a model.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
pub enum ModelTimeUnit {
    /// Seconds.
    #[default]
    #[serde(rename = "s")]
    Second,
}

/// Unit of the drive in a model.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
pub enum ModelDriveUnit {
    /// Volts.
    #[default]
    #[serde(rename = "V")]
    Volt,
}

/// Unit of the displacement in a model.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
pub enum ModelDisplacementUnit {
    /// Micrometres.
    #[default]
    #[serde(rename = "um")]
    Micrometre,
}

/// One stage of a model, told apart by its `name`.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "name", rename_all = "kebab-case")]
pub enum Stage {
    /// The rate-dependent bank of play operators.
    Hysteresis(Hysteresis),
    /// The one-sided dead-zone bank on the output of the hysteresis.
    Asymmetry(Asymmetry),
    /// Gain and offset from the normalised displacement to micrometres.
    Output(Output),
    /// The modified play model, alone.
    ModifiedPlay(ModifiedPlay),
    /// The amplifier's lag, before the hysteresis.
    AmplifierLag(AmplifierLag),
    /// The delay before the hysteresis.
    TransportDelay(TransportDelay),
    /// Even curvature behind the hysteresis.
    Quadratic(Quadratic),
    /// Odd curvature behind the hysteresis.
    Cubic(Cubic),
    /// A mechanical mode; up to three of them.
    Resonance(Resonance),
    /// Creep.
    Creep(Creep),
    /// Even curvature behind the modes.
    OutputQuadratic(Quadratic),
    /// The amplifier's limit.
    Saturation(Saturation),
    /// The limit of the amplifier's rate.
    SlewLimit(SlewLimit),
    /// Power law of the rate in the hysteresis.
    RateLaw(RateLaw),
    /// An element of Bouc and Wen beside the plays; up to three of them.
    BoucWen(BoucWen),
    /// Plays that count for more where the output is large.
    Congruency(Congruency),
    /// A gap behind the hysteresis.
    Backlash(Backlash),
    /// Product of displacement and drive of the sample before.
    Interleaving(Interleaving),
    /// The sensor's lag.
    SensorLag(SensorLag),
    /// Drift of what is measured.
    Drift(Drift),
    /// Hum on what is measured.
    MainsHum(MainsHum),
    /// Steps of what is measured.
    Quantisation(Quantisation),
}

/// Rate-dependent Prandtl-Ishlinskii operator: w = a_0 u + sum a_i z_i, where z_i is a play of u with
/// threshold alpha_i + beta |u'|.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hysteresis {
    /// alpha_1 .. alpha_n in V: increasing and > 0.
    #[schemars(inner(range(min = 0.0)))]
    pub thresholds_v: Vec<f64>,
    /// a_0 .. a_n in V/V, one more than thresholds; a_0 belongs to the drive itself.
    #[schemars(length(min = 1))]
    pub weights: Vec<f64>,
    /// beta in s: how much a threshold grows for each V/s of rate. 0 for a rate-independent operator.
    #[schemars(range(min = 0.0))]
    pub beta_s: f64,
}

/// Asymmetry map: Lambda(w) = sum g_i max(w - rho_i, 0) for w >= 0 and sum g_i min(w + rho_i, 0) for
/// w < 0, each side with its own numbers, rho_0 = 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Asymmetry {
    /// rho_1 .. in V of each side: increasing and > 0; may be empty.
    pub thresholds: TwoSided,
    /// g_0 .. of each side, a pure number, one more than thresholds of that side.
    pub slopes: TwoSided,
}

/// Numbers for the two signs of a signal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TwoSided {
    /// For w >= 0.
    pub positive: Vec<f64>,
    /// For w < 0.
    pub negative: Vec<f64>,
}

/// Gain and offset: displacement = offset + gain w, where w is what the stages before yield, in V.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Output {
    /// The gain in um/V, not zero.
    pub gain_um_per_v: f64,
    /// The displacement in um where w = 0.
    pub offset_um: f64,
}

impl Stage {
    /// Where the stage stands in the order of the signal.
    pub fn place(&self) -> usize {
        let rank = parse::ORDER.iter().position(|name| *name == self.name());
        rank.unwrap_or_default()
    }

    /// The stage's name in the file.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Hysteresis(_) => "hysteresis",
            Self::Asymmetry(_) => "asymmetry",
            Self::Output(_) => "output",
            Self::ModifiedPlay(_) => "modified-play",
            Self::AmplifierLag(_) => "amplifier-lag",
            Self::TransportDelay(_) => "transport-delay",
            Self::Quadratic(_) => "quadratic",
            Self::Cubic(_) => "cubic",
            Self::Resonance(_) => "resonance",
            Self::Creep(_) => "creep",
            Self::OutputQuadratic(_) => "output-quadratic",
            Self::Saturation(_) => "saturation",
            Self::SlewLimit(_) => "slew-limit",
            Self::RateLaw(_) => "rate-law",
            Self::BoucWen(_) => "bouc-wen",
            Self::Congruency(_) => "congruency",
            Self::Backlash(_) => "backlash",
            Self::Interleaving(_) => "interleaving",
            Self::SensorLag(_) => "sensor-lag",
            Self::Drift(_) => "drift",
            Self::MainsHum(_) => "mains-hum",
            Self::Quantisation(_) => "quantisation",
        }
    }
}

impl ModelFile {
    /// A model in the current version of the format.
    pub fn new(name: impl Into<String>, stages: Vec<Stage>) -> Self {
        Self {
            format: Format::default(),
            version: VERSION,
            name: name.into(),
            units: Units::default(),
            stages,
        }
    }

    /// The modified play model, where the file holds one: then it is the only stage.
    pub fn modified_play(&self) -> Option<&ModifiedPlay> {
        self.stages.iter().find_map(|stage| match stage {
            Stage::ModifiedPlay(model) => Some(model),
            _ => None,
        })
    }

    /// The hysteresis stage; every model that was parsed has one, or else is a modified play model.
    pub fn hysteresis(&self) -> Option<&Hysteresis> {
        self.stages.iter().find_map(|stage| match stage {
            Stage::Hysteresis(hysteresis) => Some(hysteresis),
            _ => None,
        })
    }

    /// The asymmetry stage, where there is one.
    pub fn asymmetry(&self) -> Option<&Asymmetry> {
        self.stages.iter().find_map(|stage| match stage {
            Stage::Asymmetry(asymmetry) => Some(asymmetry),
            _ => None,
        })
    }

    /// The same model without its rate terms: beta = 0, and alpha = 0 where there is one.
    pub fn rate_independent(mut self) -> Self {
        for stage in &mut self.stages {
            match stage {
                Stage::Hysteresis(hysteresis) => hysteresis.beta_s = 0.0,
                Stage::ModifiedPlay(model) => (model.alpha_s, model.beta_s) = (0.0, 0.0),
                _ => {}
            }
        }
        self
    }

    /// The effects around the hysteresis, in the order of the signal.
    pub fn effects(&self) -> impl Iterator<Item = &Stage> {
        self.stages
            .iter()
            .filter(|stage| !stage.effect_numbers().is_empty())
    }

    /// The effects that change what the hysteresis itself does: without them its numbers mean something
    /// else.
    pub fn core_effects(&self) -> impl Iterator<Item = &Stage> {
        self.stages.iter().filter(|stage| {
            matches!(
                stage,
                Stage::BoucWen(_) | Stage::RateLaw(_) | Stage::Congruency(_)
            )
        })
    }

    /// Gain in um/V and offset in um: 1 and 0 where there is no output stage.
    pub fn output(&self) -> (f64, f64) {
        let output = self.stages.iter().find_map(|stage| match stage {
            Stage::Output(output) => Some((output.gain_um_per_v, output.offset_um)),
            _ => None,
        });
        output.unwrap_or((1.0, 0.0))
    }

    /// The parameters of all stages under their keys, for JSON and tables.
    pub fn parameters(&self) -> serde_json::Map<String, serde_json::Value> {
        let mut parameters = serde_json::Map::new();
        for stage in &self.stages {
            // A stage is a flat set of numbers: it always becomes an object.
            if let Ok(serde_json::Value::Object(mut fields)) = serde_json::to_value(stage) {
                fields.remove("name");
                // Effects share keys, and modes come more than once.
                for (key, value) in stage.effect_numbers() {
                    fields.remove(key);
                    let key = format!("{}.{key}", stage.name());
                    let mut free = key.clone();
                    let mut number = 1;
                    while parameters.contains_key(&free) {
                        number += 1;
                        free = format!("{key}.{number}");
                    }
                    parameters.insert(free, value.into());
                }
                parameters.append(&mut fields);
            }
        }
        parameters
    }
}

/// The JSON Schema of `model.toml`, generated from the types that hold it.
pub fn schema() -> Schema {
    schemars::schema_for!(ModelFile)
}

/// The text of `docs/model.schema.json`.
pub fn schema_text() -> String {
    crate::schema_file::text(&schema())
}
