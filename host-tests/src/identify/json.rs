//! `identification.json`: the types that it is written from, and their JSON Schema.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value};

use crate::dataset::{LengthUnit, Role};

use super::fit::Thresholds;
use super::noise::Source;
use super::outcome::{Identification, RecordFigures, Rms};
use super::whole::WholeRms;

/// What `hysteron identify` fitted and how well. Lengths are in the data set's unit, parameters under the
/// keys and in the units of `model.toml`.
#[derive(Serialize, JsonSchema)]
#[schemars(title = "hysteron identification")]
struct File<'a> {
    /// Name of the data set.
    name: &'a str,
    /// Unit of all lengths here.
    unit: &'static str,
    /// Rms of the noise; null where nothing shows it.
    noise_floor: Option<f64>,
    /// Where it was estimated from.
    noise_floor_source: Option<Source>,
    /// What the model leaves.
    rms: Rms,
    /// What the best straight line in the drive leaves.
    straight_line_rms: Rms,
    /// The numbers of all stages; of an effect as `stage.key`.
    parameters: Map<String, Value>,
    /// Number of play operators.
    plays: usize,
    /// How their thresholds were parametrised.
    thresholds: Thresholds,
    /// Whether the rate term was fitted.
    beta_fitted: bool,
    /// Highest over lowest frequency at which the fit records move.
    frequency_span: f64,
    /// The records in the order of the data set.
    records: Vec<Record<'a>>,
    /// The model on every sample, where the data set was condensed; else null.
    whole: Option<Whole>,
}

/// How the model explains a record.
#[derive(Serialize, JsonSchema)]
struct Record<'a> {
    /// Its name.
    name: &'a str,
    /// What it served for.
    role: Role,
    /// Rms residual over the scored samples.
    rms: f64,
    /// Its offset.
    offset: f64,
    /// The state it was taken to start in, in words.
    initial_state: &'a str,
    /// Seconds at its start that are not scored.
    left_out_s: f64,
}

/// Rms over every sample.
#[derive(Serialize, JsonSchema)]
struct Whole {
    /// Samples that were scored.
    samples: u64,
    #[serde(flatten)]
    rms: Rms,
}

impl Identification {
    /// The contents of `identification.json`.
    pub fn to_json(&self) -> Value {
        // Strings and numbers under strings always become a value.
        serde_json::to_value(File::new(self)).unwrap_or_default()
    }
}

impl<'a> File<'a> {
    fn new(found: &'a Identification) -> Self {
        let unit = found.unit;
        let records = found.records.iter();
        Self {
            name: &found.name,
            unit: unit.symbol(),
            noise_floor: found.noise.map(|(um, _)| unit.from_um(um)),
            noise_floor_source: found.noise.map(|(_, source)| source),
            rms: found.rms.in_unit(unit),
            straight_line_rms: found.line_rms.in_unit(unit),
            parameters: found.model.parameters(),
            plays: found
                .model
                .hysteresis()
                .map_or(0, |hysteresis| hysteresis.thresholds_v.len()),
            thresholds: found.thresholds,
            beta_fitted: found.beta_fitted,
            frequency_span: found.frequency_span,
            records: records.map(|record| Record::new(record, unit)).collect(),
            whole: found.whole.as_ref().map(|whole| Whole::new(whole, unit)),
        }
    }
}

impl<'a> Record<'a> {
    fn new(record: &'a RecordFigures, unit: LengthUnit) -> Self {
        Self {
            name: &record.name,
            role: record.role,
            rms: unit.from_um(record.rms_um),
            offset: unit.from_um(record.offset_um),
            initial_state: &record.start,
            left_out_s: record.left_out_s,
        }
    }
}

impl Whole {
    fn new(whole: &WholeRms, unit: LengthUnit) -> Self {
        Self {
            samples: whole.samples,
            rms: whole.rms.in_unit(unit),
        }
    }
}

/// The text of `docs/identification.schema.json`.
pub fn schema_text() -> String {
    crate::schema_file::text(&schemars::schema_for!(File<'static>))
}
