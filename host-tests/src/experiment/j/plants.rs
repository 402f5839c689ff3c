//! What is driven, and how far it stays from the reference.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::experiment::references::Reference;
use crate::experiment::refused;
use crate::metrics::max_abs_error;
use crate::model_file::ModelFile;
use crate::plant;
use crate::stage::{self, Model};

use super::drives::{PerDrive, drives};

/// Relative error of every parameter of a wrong stage.
pub const WRONG: f64 = 0.05;
/// So many wrong stages are drawn; odd, so that the median is one of them.
pub const WRONG_STAGES: u64 = 9;

/// A stage that the drives are tried on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Plant {
    /// The model itself, its thresholds moved by the rate of the reference, as in the inverse.
    ModelSameRate,
    /// The model itself, its thresholds moved by the rate of its own drive.
    ModelOwnRate,
    /// The simulated stage behind converter, amplifier lag and noisy sensor.
    Stage,
    /// The same, the lag taken out of its displacement as the authors did.
    StageLagRemoved,
    /// Median over simulated stages whose parameters are all 5 % off.
    StageWrongMedian,
    /// The worst of those stages, for each drive by itself.
    StageWrongWorst,
    /// As [`Plant::StageWrongMedian`], the nominal lag taken out.
    StageWrongLagRemovedMedian,
    /// As [`Plant::StageWrongWorst`], the nominal lag taken out.
    StageWrongLagRemovedWorst,
}

impl Plant {
    /// The plant in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::ModelSameRate => "model, rate of the reference",
            Self::ModelOwnRate => "model, rate of its own drive",
            Self::Stage => "simulated stage",
            Self::StageLagRemoved => "simulated stage, lag removed",
            Self::StageWrongMedian => "stages 5 % off, median",
            Self::StageWrongWorst => "stages 5 % off, worst",
            Self::StageWrongLagRemovedMedian => "stages 5 % off, lag removed, median",
            Self::StageWrongLagRemovedWorst => "stages 5 % off, lag removed, worst",
        }
    }
}

/// Largest errors of one plant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// What was driven.
    pub plant: Plant,
    /// Largest distance from the reference in um, for each drive.
    #[serde(flatten)]
    pub largest_um: PerDrive<f64>,
}

/// Largest errors of every plant along a reference in um, from sample `settled` on, the drives made
/// with `file`.
///
/// # Errors
/// A model, signal or stage that is refused.
pub fn largest_errors(
    file: &ModelFile,
    reference: &Reference,
    settled: usize,
) -> Result<Vec<Errors>, Error> {
    let h = reference.sample_time_s;
    let model = stage::model(file, h)?;
    let drives = drives(file, reference)?;
    let error = |displacement: &[f64]| {
        let end = displacement.len();
        max_abs_error(&reference.samples[settled..end], &displacement[settled..]).map_err(refused)
    };
    // As measured, and with the nominal lag removed.
    let of_stage = |stage: &plant::Stage| -> Result<[PerDrive<f64>; 2], Error> {
        let measured = drives.try_map(|u| stage.run(u, h).map_err(refused))?;
        Ok([
            measured.try_map(|y| error(y))?,
            measured.try_map(|y| error(&lag_removed(y, h)))?,
        ])
    };
    let wrong: Vec<[PerDrive<f64>; 2]> = (1..=WRONG_STAGES)
        .into_par_iter()
        .map(|seed| of_stage(&plant::Stage::p753_perturbed(WRONG, seed)))
        .collect::<Result<_, _>>()?;
    let wrong: [Vec<PerDrive<f64>>; 2] =
        [0, 1].map(|removed| wrong.iter().map(|both| both[removed]).collect());
    let median = |sorted: &[f64]| sorted[sorted.len() / 2];
    let worst = |sorted: &[f64]| sorted[sorted.len() - 1];

    let [as_measured, removed] = of_stage(&plant::Stage::p753())?;
    let rows = [
        (
            Plant::ModelSameRate,
            drives.try_map(|u| error(&same_rate(&model, u, &reference.samples)))?,
        ),
        (
            Plant::ModelOwnRate,
            drives.try_map(|u| error(&stage::simulate(&model, u)))?,
        ),
        (Plant::Stage, as_measured),
        (Plant::StageLagRemoved, removed),
        (Plant::StageWrongMedian, PerDrive::over(&wrong[0], median)),
        (Plant::StageWrongWorst, PerDrive::over(&wrong[0], worst)),
        (
            Plant::StageWrongLagRemovedMedian,
            PerDrive::over(&wrong[1], median),
        ),
        (
            Plant::StageWrongLagRemovedWorst,
            PerDrive::over(&wrong[1], worst),
        ),
    ];
    Ok(rows
        .map(|(plant, largest_um)| Errors { plant, largest_um })
        .into())
}

/// The model driven by `drive`, its thresholds moved by the rate of `reference`.
pub fn same_rate(model: &Model, drive: &[f64], reference: &[f64]) -> Vec<f64> {
    let Some((&first, &reference_first)) = drive.first().zip(reference.first()) else {
        return Vec::new();
    };
    let h = model.hysteresis().sample_time();
    let mut state = model.start(first);
    let mut before = reference_first;
    drive
        .iter()
        .zip(reference)
        .map(|(&u, &v)| {
            let rate = (v - before) / h;
            before = v;
            model.step_with_rate(&mut state, u, rate)
        })
        .collect()
}

/// A displacement of the simulated stage moved forward by the lag of its amplifier, linearly between
/// samples; the end, for which the later sample is missing, is left out.
pub fn lag_removed(displacement: &[f64], sample_time_s: f64) -> Vec<f64> {
    let lag = plant::Stage::p753().amplifier_tau_s / sample_time_s;
    (0..displacement.len())
        .map_while(|k| {
            let at = k as f64 + lag;
            let (before, after) = (at.floor() as usize, at.ceil() as usize);
            let (&from, &to) = displacement.get(before).zip(displacement.get(after))?;
            Some(from + (to - from) * (at - at.floor()))
        })
        .collect()
}
