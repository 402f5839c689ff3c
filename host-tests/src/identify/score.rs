//! How well a fitted stage explains records, and the choice of the state that they start from.

use rayon::prelude::*;

use crate::dataset::Role;

use super::fit::Fitted;
use super::plays::Walk;
use super::run::{Run, Runs};
use super::start::Start;

/// Displacement in micrometres, less its offset, that a fitted stage predicts along a run.
pub fn predict(fitted: &Fitted, run: &Run) -> Vec<f64> {
    let mut walk = Walk::new(&fitted.plays, run);
    (0..run.drive.len())
        .map(|k| {
            walk.step(&fitted.plays, run, k);
            fitted.displacement(run.drive[k], &walk.outputs)
        })
        .collect()
}

/// Mean and mean square about it of measurement less prediction, over the scored samples of the
/// roles that `wanted` accepts.
fn residual_moments(run: &Run, predicted: &[f64], wanted: impl Fn(Role) -> bool) -> (f64, f64) {
    let residuals = || {
        run.spans
            .iter()
            .filter(|span| wanted(span.role))
            .flat_map(|span| span.samples.clone())
            .map(|k| run.displacement[k] - predicted[k])
    };
    let count = residuals().count().max(1) as f64;
    let mean = residuals().sum::<f64>() / count;
    (
        mean,
        residuals().map(|e| (e - mean).powi(2)).sum::<f64>() / count,
    )
}

/// The offset of each run in micrometres: its own mean residual, or one for all from the records
/// for fitting.
pub fn offsets(runs: &Runs, predicted: &[Vec<f64>]) -> Vec<f64> {
    let own = |(run, predicted): (&Run, &Vec<f64>)| residual_moments(run, predicted, |_| true).0;
    if runs.own_offsets {
        return runs.runs.iter().zip(predicted).map(own).collect();
    }
    // As in the fit, every record counts the same, whatever its length.
    let means: Vec<f64> = runs
        .scored(Role::Fit)
        .filter(|(_, run, _)| !run.loose)
        .map(|(i, run, span)| {
            let sum: f64 = span
                .samples
                .clone()
                .map(|k| run.displacement[k] - predicted[i][k])
                .sum();
            sum / span.samples.len().max(1) as f64
        })
        .collect();
    let shared = means.iter().sum::<f64>() / means.len().max(1) as f64;
    let offset = |(run, predicted): (&Run, &Vec<f64>)| {
        if run.loose {
            own((run, predicted))
        } else {
            shared
        }
    };
    // A prediction may stop short of the runs that nobody asks for.
    let mut offsets: Vec<f64> = runs.runs.iter().zip(predicted).map(offset).collect();
    offsets.resize(runs.runs.len(), shared);
    offsets
}

/// Root of the mean over a role's records of their mean square residual, in micrometres; `None`
/// when no record has the role.
pub fn rms(runs: &Runs, predicted: &[Vec<f64>], offsets: &[f64], role: Role) -> Option<f64> {
    let squares: Vec<f64> = runs
        .scored(role)
        .filter(|(_, _, span)| !span.samples.is_empty())
        .map(|(i, run, span)| {
            let sum: f64 = span
                .samples
                .clone()
                .map(|k| (run.displacement[k] - predicted[i][k] - offsets[i]).powi(2))
                .sum();
            sum / span.samples.len() as f64
        })
        .collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Score of a fitted stage on one role.
pub fn score(fitted: &Fitted, runs: &Runs, role: Role) -> Option<f64> {
    let predicted: Vec<Vec<f64>> = runs.runs.iter().map(|run| predict(fitted, run)).collect();
    rms(runs, &predicted, &offsets(runs, &predicted), role)
}

/// Gives every run the history from the menu under which the fitted stage explains it best.
pub fn choose_starts(fitted: &Fitted, runs: &mut Runs) {
    let menu = Start::menu(runs.drive_range);
    let shared = {
        let predicted: Vec<Vec<f64>> = runs.runs.iter().map(|run| predict(fitted, run)).collect();
        offsets(runs, &predicted)
    };
    let own = runs.own_offsets;
    runs.runs
        .par_iter_mut()
        .zip(shared)
        .for_each(|(run, offset)| {
            let mut trial = run.clone();
            let mut best = (f64::INFINITY, run.start);
            for &start in &menu {
                trial.start = start;
                let (mean, variance) = residual_moments(&trial, &predict(fitted, &trial), |_| true);
                let square = if own {
                    variance
                } else {
                    variance + (mean - offset).powi(2)
                };
                // An equal history further down the menu is not a better one.
                if square < best.0 * (1.0 - 1e-9) {
                    best = (square, start);
                }
            }
            run.start = best.1;
        });
}
