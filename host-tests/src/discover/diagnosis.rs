//! What a diagnosis found, and its JSON.

use schemars::JsonSchema;
use serde::Serialize;

use crate::dataset::{LengthUnit, Role};
use crate::identify::joint::Interval;
use crate::identify::{Effect, Source, WholeRms};
use crate::model_file::{ModelFile, Stage};

/// What a diagnosis says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// The named effects explain what the baseline left over.
    Named,
    /// They explain a part of it.
    Partial,
    /// Something is missing that no effect of the library explains.
    Unknown,
    /// Nothing is missing.
    None,
}

/// An rms in micrometres for each role; `None` where no record has it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Roles {
    /// Records for fitting.
    pub fit: Option<f64>,
    /// Records for choosing.
    pub select: Option<f64>,
    /// Records opened once, at the end.
    pub report: Option<f64>,
}

/// An effect that was found.
#[derive(Clone, Debug)]
pub struct FoundEffect {
    /// The effect.
    pub effect: Effect,
    /// Others that explain as much.
    pub also_possible: Vec<Effect>,
    /// The models with each of the others in its place, in the same order.
    pub rivals: Vec<ModelFile>,
    /// Excess on the select records after adding it over that before.
    pub left_over: f64,
    /// Its stage of the model.
    pub stage: Option<Stage>,
    /// Intervals of 95 % of its parameters in their order, of an asymmetry the thresholds before the
    /// slopes, the positive side before the negative; `None` where the fit does not move one.
    pub intervals: Vec<Interval>,
    /// Its numbers where it has no stage of its own.
    pub numbers: Vec<(&'static str, f64)>,
}

/// What leaving one effect out does.
#[derive(Clone, Debug)]
pub struct Ablation {
    /// The effect that was left out.
    pub effect: Effect,
    /// Rms on the select records without it, all else fitted anew, in um.
    pub select_um: f64,
}

/// Residuals of a model along the records.
#[derive(Clone, Debug, Default)]
pub struct Residuals {
    /// One entry a record, in the order of the data set.
    pub records: Vec<RecordResiduals>,
}

/// A record's scored samples with what a model leaves over of them.
#[derive(Clone, Debug)]
pub struct RecordResiduals {
    /// Name of the record.
    pub name: String,
    /// Its role.
    pub role: Role,
    /// Time between samples in s.
    pub sample_time_s: f64,
    /// Absolute time of the first scored sample in s.
    pub start_s: f64,
    /// Drive in volts.
    pub drive_v: Vec<f64>,
    /// Measured displacement in um.
    pub displacement_um: Vec<f64>,
    /// Measured less modelled displacement, offset taken out, in um.
    pub residual_um: Vec<f64>,
}

/// The result of a diagnosis.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// Name of the data set.
    pub name: String,
    /// The unit in which figures are reported.
    pub unit: LengthUnit,
    /// What it says.
    pub verdict: Verdict,
    /// The effects in the order of their discovery.
    pub effects: Vec<FoundEffect>,
    /// Rms noise in um and where it was estimated from.
    pub noise: (f64, Source),
    /// Rms of the baseline in um.
    pub baseline: Roles,
    /// Rms in um of the user's own model with all its numbers fitted anew, where that is the baseline.
    pub refitted: Option<Roles>,
    /// Rms of the extended model in um.
    pub extended: Roles,
    /// The bar in um: an rms excess on the select records below it is nothing.
    pub bar_um: f64,
    /// Baseline with each effect of the library alone: effect and rms on the select records in um.
    pub screened: Vec<(Effect, f64)>,
    /// What leaving out each found effect does.
    pub ablation: Vec<Ablation>,
    /// The baseline as a model.
    pub baseline_model: ModelFile,
    /// The extended model.
    pub model: ModelFile,
    /// What the baseline leaves over.
    pub before: Residuals,
    /// What the extended model leaves over.
    pub after: Residuals,
    /// Which record would separate the members of an ambiguity set.
    pub next_record: Option<String>,
    /// The baseline and the extended model on every sample, where the data set was condensed.
    pub whole: Option<[WholeRms; 2]>,
    /// What the figures rest on, a sentence each.
    pub notes: Vec<String>,
}

/// Root of what an rms exceeds the noise by, squares taken.
pub fn excess(rms: f64, noise: f64) -> f64 {
    (rms * rms - noise * noise).max(0.0).sqrt()
}

impl FoundEffect {
    /// The laws of the rest of the ambiguity set, the likeliest first, each once.
    pub fn other_laws(&self) -> Vec<&'static str> {
        let mut others = Vec::new();
        for law in self.also_possible.iter().map(|effect| effect.law()) {
            if law != self.effect.law() && !others.contains(&law) {
                others.push(law);
            }
        }
        others
    }

    /// All its numbers, those of a map one by one, with their intervals.
    pub(super) fn numbers_with_intervals(
        &self,
    ) -> impl Iterator<Item = (String, f64, Interval)> + '_ {
        let mut numbers: Vec<(String, f64)> = Vec::new();
        if let Some(Stage::Asymmetry(map)) = &self.stage {
            for (key, sides) in [("thresholds", &map.thresholds), ("slopes", &map.slopes)] {
                for (sign, side) in [("positive", &sides.positive), ("negative", &sides.negative)] {
                    let named = |(i, &x): (usize, &f64)| (format!("{key}.{sign}.{i}"), x);
                    numbers.extend(side.iter().enumerate().map(named));
                }
            }
        }
        let keyed = self.parameters().into_iter();
        numbers.extend(keyed.map(|(key, x)| (key.to_owned(), x)));
        let ends = self.intervals.iter().copied();
        let ends = ends.chain(std::iter::repeat(None));
        numbers
            .into_iter()
            .zip(ends)
            .map(|((key, x), ends)| (key, x, ends))
    }

    /// Its numbers under the keys of `model.toml`.
    pub fn parameters(&self) -> Vec<(&'static str, f64)> {
        match &self.stage {
            Some(stage) => stage.effect_numbers(),
            None => self.numbers.clone(),
        }
    }
}

impl Diagnosis {
    /// Rms of what effects are held against: the baseline, fitted to the data.
    pub(super) fn fitted_baseline(&self) -> &Roles {
        self.refitted.as_ref().unwrap_or(&self.baseline)
    }

    /// The share of the baseline's excess on the report records that the extended model closes; `None`
    /// where the baseline leaves none.
    pub fn closed(&self) -> Option<f64> {
        let noise = self.noise.0;
        let (before, after) = (self.baseline.report?, self.extended.report?);
        let before = excess(before, noise);
        (before > self.bar_um).then(|| 1.0 - excess(after, noise) / before)
    }
}
