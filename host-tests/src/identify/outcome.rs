//! What an identification found: the model, its figures, and what they rest on.

use schemars::JsonSchema;
use serde::Serialize;

use crate::dataset::{Dataset, LengthUnit, Role};
use crate::error::Error;
use crate::model_file::{Asymmetry, BoucWen, Hysteresis, ModelFile, Output, Stage, TwoSided};
use crate::stage;

use super::cycles::{half_cycle_frequencies, range, turning_points};
use super::fit::{Fitted, Thresholds};
use super::joint::{Core, Joint, JointFit};
use super::noise::Source;
use super::run::{Run, Runs};
use super::score::{offsets, rms};
use super::start::Start;
use super::whole::WholeRms;

/// What the search hands over.
pub(super) struct Findings {
    pub fitted: Fitted,
    pub effects: Vec<Stage>,
    pub thresholds: Thresholds,
    pub beta_visible: bool,
    pub beta_fitted: bool,
    pub noise: Option<(f64, Source)>,
}

/// Rms residual of each role, in micrometres where nothing else is said; none where no record has the role.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Rms {
    /// Records for fitting.
    pub fit: Option<f64>,
    /// Records for choosing the structure.
    pub select: Option<f64>,
    /// Records scored once.
    pub report: Option<f64>,
}

impl Rms {
    /// The same in another unit.
    pub(super) fn in_unit(&self, unit: LengthUnit) -> Self {
        let length = |um: Option<f64>| um.map(|um| unit.from_um(um));
        Self {
            fit: length(self.fit),
            select: length(self.select),
            report: length(self.report),
        }
    }
}

/// How the model explains one record.
#[derive(Clone, Debug)]
pub struct RecordFigures {
    /// Name of the record.
    pub name: String,
    /// Its role.
    pub role: Role,
    /// Rms residual over the scored samples in micrometres.
    pub rms_um: f64,
    /// Rms residual of the best straight line in the drive, same samples, in micrometres.
    pub line_rms_um: f64,
    /// Offset of this record in micrometres.
    pub offset_um: f64,
    /// The state it was taken to start in.
    pub start: String,
    /// Seconds at its start that are not scored.
    pub left_out_s: f64,
    /// Median frequency at which it moves, in hertz; `None` if it turns less than twice.
    pub frequency_hz: Option<f64>,
    /// Time of each sample in seconds.
    pub time_s: Vec<f64>,
    /// Drive in volts.
    pub drive_v: Vec<f64>,
    /// Measured displacement in micrometres.
    pub measured_um: Vec<f64>,
    /// Displacement by the model in micrometres, offset included.
    pub model_um: Vec<f64>,
}

/// The result of an identification.
#[derive(Clone, Debug)]
pub struct Identification {
    /// Name of the data set.
    pub name: String,
    /// The unit in which figures are reported.
    pub unit: LengthUnit,
    /// The identified stage.
    pub model: ModelFile,
    /// How its thresholds were parametrised.
    pub thresholds: Thresholds,
    /// Ratio of the highest to the lowest frequency at which the fit records move.
    pub frequency_span: f64,
    /// Whether that span lets the rate term be told from a delay.
    pub beta_visible: bool,
    /// Whether the rate term was fitted.
    pub beta_fitted: bool,
    /// Rms noise in micrometres and where it was estimated from.
    pub noise: Option<(f64, Source)>,
    /// Rms residuals in micrometres.
    pub rms: Rms,
    /// The same for the best straight line in the drive.
    pub line_rms: Rms,
    /// Each record.
    pub records: Vec<RecordFigures>,
    /// Whether part of the fit records served for selection, for want of a record with that role.
    pub held_back: bool,
    /// The model on every sample, where the data set was condensed to be fitted.
    pub whole: Option<WholeRms>,
    /// What was kept of it, a sentence each.
    pub condensed: Vec<String>,
}

impl Identification {
    pub(super) fn new(dataset: &Dataset, runs: &Runs, found: Findings) -> Result<Self, Error> {
        let gain = found.fitted.gain();
        let mut model = model_file(
            &dataset.name,
            &found.fitted,
            &found.effects,
            gain,
            runs.sign,
        );
        // What is scored is the file that is written, run by the core that will be flashed.
        let predicted = runs
            .runs
            .iter()
            .map(|run| run_model(&model, run))
            .collect::<Result<Vec<_>, _>>()?;
        let signed = runs.measured();
        let offsets = offsets(&signed, &predicted);
        let lines: Vec<Vec<f64>> = runs
            .runs
            .iter()
            .map(|run| {
                run.drive
                    .iter()
                    .map(|u| runs.sign * runs.mean_gain() * u)
                    .collect()
            })
            .collect();
        let line_offsets = super::score::offsets(&signed, &lines);
        if !runs.own_offsets
            && let Some(Stage::Output(output)) = model.stages.last_mut()
        {
            output.offset_um = offsets[0];
        }
        let figures = |predicted: &[Vec<f64>], offsets: &[f64]| {
            let of = |role| rms(&signed, predicted, offsets, role);
            let fit = of(Role::Fit);
            let select = if runs.held_back {
                None
            } else {
                of(Role::Select)
            };
            Rms {
                fit,
                select,
                report: of(Role::Report),
            }
        };
        let mut records = Vec::new();
        for (i, run) in signed.runs.iter().enumerate() {
            for (at, span) in run.whole_spans() {
                let record = &dataset.records[span.record];
                let one = |predicted: &[f64], offset: f64| {
                    let square: f64 = span
                        .samples
                        .clone()
                        .map(|k| (run.displacement[k] - predicted[k] - offset).powi(2))
                        .sum();
                    (square / span.samples.len().max(1) as f64).sqrt()
                };
                records.push(RecordFigures {
                    name: record.name.clone(),
                    role: record.role,
                    rms_um: one(&predicted[i], offsets[i]),
                    line_rms_um: one(&lines[i], line_offsets[i]),
                    offset_um: offsets[i],
                    start: match record.continues {
                        Some(_) => "where the record before it ended".to_owned(),
                        None => run.start.describe(),
                    },
                    left_out_s: (span.samples.start - at.start) as f64 * run.sample_time_s,
                    frequency_hz: median_frequency(&record.drive_v, record.sample_time_s),
                    time_s: record.time_s.clone(),
                    drive_v: record.drive_v.clone(),
                    measured_um: record.displacement_um.clone(),
                    model_um: predicted[i][at].iter().map(|y| y + offsets[i]).collect(),
                });
            }
        }
        records.sort_by_key(|record| dataset.records.iter().position(|r| r.name == record.name));
        Ok(Self {
            name: dataset.name.clone(),
            unit: dataset.output_unit,
            rms: figures(&predicted, &offsets),
            line_rms: figures(&lines, &line_offsets),
            model,
            thresholds: found.thresholds,
            frequency_span: runs.frequency_span,
            beta_visible: found.beta_visible,
            beta_fitted: found.beta_fitted,
            noise: found.noise,
            records,
            held_back: runs.held_back,
            whole: None,
            condensed: Vec::new(),
        })
    }

    /// What kind of model was found, in a sentence.
    pub fn describe_structure(&self) -> String {
        let Some(hysteresis) = self.model.hysteresis() else {
            return String::new();
        };
        let plays = hysteresis.thresholds_v.len();
        let rate = if hysteresis.beta_s > 0.0 {
            format!("rate term beta = {:.4e} s", hysteresis.beta_s)
        } else if self.beta_visible {
            "no rate term: it does not help".to_owned()
        } else {
            "no rate term: the fit records move at too few frequencies to show one".to_owned()
        };
        let map = match self.model.asymmetry() {
            Some(_) => "with an asymmetry map",
            None => "symmetric",
        };
        let effects: Vec<&str> = self.model.effects().map(Stage::name).collect();
        let map = if effects.is_empty() {
            map.to_owned()
        } else {
            format!("{map}, with {}", effects.join(", "))
        };
        format!(
            "{plays} play operator{}, {map}, {rate}, gain {:.5} um/V",
            if plays == 1 { "" } else { "s" },
            self.model.output().0
        )
    }

    /// What the figures rest on, a sentence each.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = vec![
            "The state of the plays at a record's start is unknown. It is taken from a short menu of \
             histories, the one that explains the record best; where a record has more than one \
             cycle, its first is left out of the score as well."
                .to_owned(),
            format!(
                "The fit records move over a ratio of frequencies of {:.3}; a rate term is only \
                 fitted from 10 on, because below it cannot be told from a delay or a lag.",
                self.frequency_span
            ),
        ];
        if self.held_back {
            notes.push(
                "No record has the role select: the last quarter of each fit record served to \
                 choose the structure, and was given back for the final fit."
                    .to_owned(),
            );
        }
        if self.rms.report.is_none() {
            notes.push("No record has the role report: there is no held-out figure.".to_owned());
        }
        notes.extend(self.condensed.iter().cloned());
        notes
    }
}

fn median_frequency(drive: &[f64], sample_time_s: f64) -> Option<f64> {
    let turns = turning_points(drive, range(drive));
    let mut frequencies = half_cycle_frequencies(drive, &turns, sample_time_s);
    frequencies.sort_by(f64::total_cmp);
    frequencies.get(frequencies.len() / 2).copied()
}

/// The fitted stage with its gain taken out of the weights, which is their sum with those of elements among
/// the `effects`: so core and map compute in volts. `sign` is that of the stage's gain.
pub(super) fn model_file(
    name: &str,
    fitted: &Fitted,
    effects: &[Stage],
    gain: f64,
    sign: f64,
) -> ModelFile {
    let mut stages: Vec<Stage> = effects.iter().map(|stage| stage.signed(sign)).collect();
    stages.push(Stage::Hysteresis(Hysteresis {
        thresholds_v: fitted.plays.thresholds.clone(),
        weights: fitted.weights.iter().map(|a| a / gain).collect(),
        beta_s: fitted.plays.beta,
    }));
    if let Some(map) = &fitted.map {
        let (positive_slopes, positive) = map.positive.dead_zones(gain);
        let (negative_slopes, negative) = map.negative.dead_zones(gain);
        stages.push(Stage::Asymmetry(Asymmetry {
            thresholds: TwoSided { positive, negative },
            slopes: TwoSided {
                positive: positive_slopes,
                negative: negative_slopes,
            },
        }));
    }
    stages.push(Stage::Output(Output {
        gain_um_per_v: sign * gain,
        offset_um: 0.0,
    }));
    stages.sort_by_key(Stage::place);
    ModelFile::new(name, stages)
}

/// The elements of a core as stages in front of a gain.
fn elements(core: &Core, gain: f64) -> impl Iterator<Item = Stage> {
    let weights = core.weights.iter().skip(core.thresholds.len() + 1);
    let active = core.elements.iter().zip(weights).filter(|(_, a)| **a > 0.0);
    active.map(move |(element, a)| {
        Stage::BoucWen(BoucWen {
            weight: a / gain,
            grow_per_v: element.grow_per_v,
            shape_per_v: element.shape_per_v(),
        })
    })
}

/// A jointly fitted stage as a model file: plays without weight left out, the offset that of the
/// records for fitting, or zero where each has its own.
///
/// # Errors
/// Numbers that the core refuses.
pub fn joint_model(name: &str, joint: &Joint, fit: &JointFit<'_>) -> Result<ModelFile, Error> {
    let runs = fit.runs();
    let gain = joint.core.weights.iter().sum();
    let mut stages = joint.terms.stages(fit.seen(), gain);
    stages.extend(elements(&joint.core, gain));
    let mut model = model_file(name, &joint.fitted(), &stages, gain, runs.sign);
    let predicted = fit.predicted(&joint.core, &joint.terms)?;
    if !runs.own_offsets {
        let offset = offsets(runs, &predicted).first().copied().unwrap_or(0.0);
        for stage in &mut model.stages {
            if let Stage::Output(output) = stage {
                output.offset_um = runs.sign * offset;
            }
        }
    }
    Ok(model)
}

/// Displacement in micrometres by the core along a run, from the run's own start.
fn run_model(file: &ModelFile, run: &Run) -> Result<Vec<f64>, Error> {
    let chain = stage::chain(file, run.sample_time_s)?;
    let operator = chain.model().hysteresis();
    let begin = |z: &[f64]| {
        operator
            .start_from(run.before(0), z)
            .map_err(|refused| Error::request(format!("start of a record: {refused}")))
    };
    let thresholds = operator.bank().thresholds();
    let z: Vec<f64> = thresholds
        .iter()
        .map(|&r| run.start.play(run.drive[0], r).0)
        .collect();
    let mut state = chain.start_from(run.before(0), begin(&z)?);
    if run.start == Start::Periodic {
        for &u in &run.drive {
            chain.step(&mut state, u);
        }
    }
    Ok(run
        .drive
        .iter()
        .map(|&u| chain.step(&mut state, u))
        .collect())
}
