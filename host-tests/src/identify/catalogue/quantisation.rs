//! Quantisation: the step over half the range of the displacement, read off the readings; no fit moves
//! it.

use crate::model_file::{self, Stage};

use super::super::run::Run;
use super::{Seen, Template};

/// Readings that are looked at.
const LOOKED_AT: usize = 4_000;
/// How far the distance of two readings may be from whole steps, in steps.
const WHOLE: f64 = 0.02;
/// Share of half the range below which a step is the rounding of a file.
const LEAST: f64 = 1e-4;
/// Rms error of the rounding, over the noise, below which nobody hears it.
const HEARD: f64 = 0.5;

/// See the [module](self).
pub struct Quantisation;

/// The step in um that all readings of each run are whole multiples apart, if there is one that
/// matters beside the `noise` in um.
pub fn step(runs: &[Run], noise: f64) -> Option<f64> {
    let total: usize = runs.iter().map(|run| run.displacement.len()).sum();
    let stride = total.div_ceil(LOOKED_AT).max(1);
    let mut apart: Vec<f64> = Vec::new();
    let mut widest = 0.0f64;
    for run in runs {
        let mut readings: Vec<f64> = run.displacement.iter().step_by(stride).copied().collect();
        readings.sort_by(f64::total_cmp);
        if let [first, .., last] = readings[..] {
            widest = widest.max(last - first);
        }
        apart.extend(readings.windows(2).map(|pair| pair[1] - pair[0]));
    }
    apart.retain(|&d| d > 1e-9 * widest);
    let step = apart.iter().copied().fold(f64::INFINITY, f64::min);
    let whole = |d: &f64| (d / step - (d / step).round()).abs() < WHOLE;
    let matters = step.is_finite() && step / 12f64.sqrt() > HEARD * noise;
    (matters && step > 0.5 * LEAST * widest && apart.iter().all(whole)).then_some(step)
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

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::Quantisation(steps) = stage else {
            return None;
        };
        Some(vec![steps.step / seen.displacement_um])
    }

    fn inverted(&self) -> bool {
        false
    }
}
