//! The schema of `dataset.toml`.

use schemars::{JsonSchema, Schema};
use serde::Deserialize;

use super::{Role, Zero};
use crate::units::{LengthUnit, TimeUnit, VoltageUnit};

/// Description of a data set: its signals and its records.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "hysteron data set")]
pub(super) struct Description {
    /// Name of the data set, for reports.
    pub(super) name: String,
    /// Which columns hold the signals, and in which unit.
    pub(super) signals: Signals,
    /// The records, at least one of them to fit.
    #[serde(rename = "record")]
    #[schemars(length(min = 1))]
    pub(super) records: Vec<RecordEntry>,
}

/// The three signals; every record has the same columns.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Signals {
    /// Absolute time, on one clock for all records that belong together.
    pub(super) time: TimeSignal,
    /// Drive voltage.
    pub(super) input: InputSignal,
    /// Measured displacement.
    pub(super) output: OutputSignal,
}

/// Column of the time.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeSignal {
    /// Exact name of the column, array or field in each file.
    pub(super) column: String,
    /// Unit of the column.
    pub(super) unit: TimeUnit,
}

/// Column of the drive.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct InputSignal {
    /// Exact name of the column, array or field in each file.
    pub(super) column: String,
    /// Unit of the column.
    pub(super) unit: VoltageUnit,
    /// Whether the offset is one for all records or arbitrary in each.
    #[serde(default)]
    pub(super) zero: Zero,
}

/// Column of the displacement.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct OutputSignal {
    /// Exact name of the column, array or field in each file.
    pub(super) column: String,
    /// Unit of the column.
    pub(super) unit: LengthUnit,
    /// Whether the offset is one for all records or arbitrary in each.
    #[serde(default)]
    pub(super) zero: Zero,
}

/// One record.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RecordEntry {
    /// CSV, .npz or .npy file, relative to the folder of this description and inside it.
    pub(super) file: String,
    /// What the record serves for.
    pub(super) role: Role,
}

/// The JSON Schema of `dataset.toml`, generated from the types that read it.
pub fn schema() -> Schema {
    schemars::schema_for!(Description)
}

/// The text of `docs/dataset.schema.json`.
pub fn schema_text() -> String {
    crate::schema_file::text(&schema())
}
