//! `faults.json`: the types that it is written from, and their JSON Schema.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::{Failure, Outcome};

/// What `hysteron faults` injected and what came of it.
#[derive(Serialize, JsonSchema)]
#[schemars(title = "hysteron fault campaign")]
struct File<'a> {
    /// Of the first run; each further one has the next.
    seed: u64,
    /// Runs.
    runs: u64,
    /// Whether the firmware ran in its emulator beside the host's replica.
    emulated: bool,
    /// Faults injected.
    injected: u64,
    /// Samples judged.
    samples: u64,
    /// Faults of each kind.
    kinds: BTreeMap<&'static str, u64>,
    /// All that did not hold; at most one a run, which ends there.
    failures: &'a [Failure],
}

impl Outcome {
    /// The contents of `faults.json`.
    pub fn to_json(&self) -> Value {
        let file = File {
            seed: self.seed,
            runs: self.runs,
            emulated: self.emulated,
            injected: self.injected(),
            samples: self.samples,
            kinds: self
                .rows
                .iter()
                .map(|row| (row.key, row.injected))
                .collect(),
            failures: &self.failures,
        };
        // Strings and numbers under strings always become a value.
        serde_json::to_value(file).unwrap_or_default()
    }
}

/// The text of `docs/faults.schema.json`.
pub fn schema_text() -> String {
    crate::schema_file::text(&schemars::schema_for!(File<'static>))
}
