//! Quantisation: the step over half the range of the displacement, read off the readings; no fit moves
//! it.

use crate::model_file::{self, Stage};

use super::super::run::Runs;
use super::{Seen, Template};

/// Readings that are looked at.
const LOOKED_AT: usize = 4_000;
/// How far the distance of two readings may be from whole steps, in steps.
const WHOLE: f64 = 0.02;
/// Share of half the range below which a step is the rounding of a file.
const LEAST: f64 = 1e-4;

/// See the [module](self).
pub struct Quantisation;

/// The step in um that all readings are whole multiples apart, if there is one.
pub fn step(runs: &Runs) -> Option<f64> {
    let total: usize = runs.runs.iter().map(|run| run.displacement.len()).sum();
    let stride = total.div_ceil(LOOKED_AT).max(1);
    let all = runs.runs.iter().flat_map(|run| &run.displacement);
    let mut readings: Vec<f64> = all.step_by(stride).copied().collect();
    readings.sort_by(f64::total_cmp);
    let range = readings.last()? - readings.first()?;
    let apart: Vec<f64> = readings
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|&d| d > 1e-9 * range)
        .collect();
    let step = apart.iter().copied().fold(f64::INFINITY, f64::min);
    let whole = |d: &f64| (d / step - (d / step).round()).abs() < WHOLE;
    (step > 0.5 * LEAST * range && step.is_finite() && apart.iter().all(whole)).then_some(step)
}

impl Template for Quantisation {
    fn name(&self) -> &'static str {
        "quantisation"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        let step = seen.step_um.map(|step| vec![step / seen.displacement_um]);
        step.into_iter().collect()
    }

    fn bounds(&self, _seen: &Seen, numbers: &[f64]) -> Vec<(f64, f64)> {
        numbers.iter().map(|&x| (x, x)).collect()
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::Quantisation(model_file::Quantisation {
            step: x * seen.displacement_um,
        }))
    }

    fn inverted(&self) -> bool {
        false
    }
}
