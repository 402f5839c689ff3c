//! `diagnosis.json`: the types that it is written from, and their JSON Schema.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::dataset::LengthUnit;
use crate::identify::joint::Interval;
use crate::identify::{Effect, Rms, Source};
use crate::model_file::{Stage, TwoSided};

use super::diagnosis::{self, Diagnosis, FoundEffect, Verdict};
use super::localise;

/// What `hysteron diagnose` found. Lengths are in the data set's unit, parameters under the keys and in
/// the units of `model.toml`.
#[derive(Serialize, JsonSchema)]
#[schemars(title = "hysteron diagnosis")]
struct File {
    /// Name of the data set.
    name: String,
    /// What it says.
    verdict: Verdict,
    /// The effects in the order of their discovery.
    effects: Vec<Found>,
    /// What baseline and extended model leave over.
    gap: Gap,
    /// Where the baseline's gap lies, the most telling first.
    #[serde(rename = "where")]
    places: Vec<Place>,
    /// The baseline with one effect alone, by effect: rms on the `select` records.
    screened_select_rms: BTreeMap<&'static str, f64>,
    /// The extended model without one effect, by effect: rms on the `select` records.
    ablation_select_rms: BTreeMap<&'static str, f64>,
    /// Which record would tell the members of an ambiguity set apart.
    next_record: Option<String>,
    /// Rms over every sample, where the data set was condensed; else null.
    whole: Option<Whole>,
    /// What the figures rest on.
    notes: Vec<String>,
}

/// An effect that was found.
#[derive(Serialize, JsonSchema)]
struct Found {
    /// Its name.
    name: &'static str,
    /// Name of its stage in `model.toml`: `output-quadratic` for `quadratic` that acts behind the modes.
    stage: &'static str,
    /// The rest of the ambiguity set.
    also_possible: Vec<&'static str>,
    /// Excess after adding it over the excess before, on the `select` records.
    left_over: f64,
    /// Whether the compensator undoes it.
    inverted: bool,
    /// Its parameters by key.
    parameters: BTreeMap<&'static str, Parameter>,
    /// Intervals of 95 % by the same keys: low and high. A parameter that the fit does not move has none.
    intervals: BTreeMap<&'static str, Ends>,
}

/// A number, or lists of them for the two signs of a signal.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Parameter {
    Number(f64),
    Sides(TwoSided),
}

/// Low and high end, or lists of them for the two signs of a signal.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Ends {
    Number((f64, f64)),
    Sides {
        positive: Vec<Interval>,
        negative: Vec<Interval>,
    },
}

/// What is left over, and what of it is noise.
#[derive(Serialize, JsonSchema)]
struct Gap {
    /// Unit of all lengths here.
    unit: &'static str,
    /// Rms of the noise.
    noise_floor: f64,
    /// Where it was estimated from.
    noise_floor_source: Source,
    /// What an effect must gain to be worth its name: half the noise floor, or from a bootstrap.
    bar: f64,
    /// The baseline; a model of the user's own as it was given.
    baseline: Roles,
    /// That model with all its numbers fitted anew; null for a baseline of plays.
    refitted: Option<Roles>,
    /// The extended model.
    extended: Roles,
    /// 1 - excess(extended.report) / excess(baseline.report); null where the baseline leaves none.
    closed: Option<f64>,
}

/// Rms by role; null where no record has it.
#[derive(Serialize, JsonSchema)]
struct Roles {
    /// Records for fitting.
    fit: Option<f64>,
    /// Records for choosing.
    select: Option<f64>,
    /// Records opened once, at the end.
    report: Option<f64>,
}

/// Rms over every sample by role, by the models as they are written.
#[derive(Serialize, JsonSchema)]
struct Whole {
    /// Samples that were scored.
    samples: u64,
    /// The baseline.
    baseline: Roles,
    /// The extended model.
    extended: Roles,
}

/// Where the gap lies along an axis.
#[derive(Serialize, JsonSchema)]
struct Place {
    /// The axis.
    axis: String,
    /// A sentence.
    summary: String,
    /// Share of the gap.
    #[schemars(range(min = 0.0, max = 1.0))]
    share: f64,
}

impl Diagnosis {
    /// The contents of `diagnosis.json`.
    pub fn to_json(&self, places: &[localise::Place]) -> Value {
        // Strings and numbers under strings always become a value.
        serde_json::to_value(File::new(self, places)).unwrap_or_default()
    }
}

impl File {
    fn new(found: &Diagnosis, places: &[localise::Place]) -> Self {
        let length = |um: f64| found.unit.from_um(um);
        let by_effect = |(effect, um): (Effect, f64)| (effect.name(), length(um));
        let ablation = found.ablation.iter().map(|out| (out.effect, out.select_um));
        Self {
            name: found.name.clone(),
            verdict: found.verdict,
            effects: found.effects.iter().map(Found::new).collect(),
            gap: Gap {
                unit: found.unit.symbol(),
                noise_floor: length(found.noise.0),
                noise_floor_source: found.noise.1,
                bar: length(found.bar_um),
                baseline: Roles::new(&found.baseline, found.unit),
                refitted: found.refitted.map(|roles| Roles::new(&roles, found.unit)),
                extended: Roles::new(&found.extended, found.unit),
                closed: found.closed(),
            },
            places: places
                .iter()
                .map(|place| Place {
                    axis: place.axis.to_owned(),
                    summary: place.summary.clone(),
                    share: place.share,
                })
                .collect(),
            screened_select_rms: found.screened.iter().copied().map(by_effect).collect(),
            ablation_select_rms: ablation.map(by_effect).collect(),
            next_record: found.next_record.clone(),
            whole: found.whole.as_ref().map(|[baseline, extended]| Whole {
                samples: extended.samples,
                baseline: Roles::of_all(&baseline.rms, found.unit),
                extended: Roles::of_all(&extended.rms, found.unit),
            }),
            notes: found.notes.clone(),
        }
    }
}

impl Found {
    fn new(found: &FoundEffect) -> Self {
        let (mut parameters, mut intervals) = (BTreeMap::new(), BTreeMap::new());
        let mut ends = found.intervals.iter().copied();
        if let Some(Stage::Asymmetry(map)) = &found.stage {
            for (key, sides) in [("thresholds", &map.thresholds), ("slopes", &map.slopes)] {
                parameters.insert(key, Parameter::Sides(sides.clone()));
                let mut side = |numbers: &[f64]| ends.by_ref().take(numbers.len()).collect();
                let sides = Ends::Sides {
                    positive: side(&sides.positive),
                    negative: side(&sides.negative),
                };
                intervals.insert(key, sides);
            }
        }
        for (key, value) in found.parameters() {
            parameters.insert(key, Parameter::Number(value));
            if let Some(ends) = ends.next().flatten() {
                intervals.insert(key, Ends::Number(ends));
            }
        }
        Self {
            name: found.effect.law(),
            stage: found.effect.name(),
            also_possible: found.other_laws(),
            left_over: found.left_over,
            inverted: found.effect.template().inverted(),
            parameters,
            intervals,
        }
    }
}

impl Roles {
    fn of_all(rms: &Rms, unit: LengthUnit) -> Self {
        let (fit, select, report) = (rms.fit, rms.select, rms.report);
        Self::new(
            &diagnosis::Roles {
                fit,
                select,
                report,
            },
            unit,
        )
    }

    fn new(roles: &diagnosis::Roles, unit: LengthUnit) -> Self {
        let length = |um: Option<f64>| um.map(|um| unit.from_um(um));
        Self {
            fit: length(roles.fit),
            select: length(roles.select),
            report: length(roles.report),
        }
    }
}

/// The text of `docs/diagnosis.schema.json`.
pub fn schema_text() -> String {
    crate::schema_file::text(&schemars::schema_for!(File))
}
