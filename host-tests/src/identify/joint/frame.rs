//! A run made ready for many simulations: its rows of the least squares.

use crate::dataset::Role;

use super::super::run::{Run, Runs};
use super::super::start::Start;

/// A run and what a fit looks at of it.
pub struct Frame<'a> {
    /// The run.
    pub run: &'a Run,
    /// Samples that are rows of the least squares, with their weights.
    pub rows: Vec<(usize, f64)>,
}

impl<'a> Frame<'a> {
    /// Frames of all runs with about `most_rows` rows in all, every record counting the same.
    pub fn all(runs: &'a Runs, most_rows: usize) -> Vec<Self> {
        let records = runs.scored(Role::Fit).count().max(1);
        let share = (most_rows / records).max(64);
        runs.runs
            .iter()
            .map(|run| {
                let rows = run
                    .scored(Role::Fit)
                    .flat_map(|span| {
                        let stride = span.samples.len().div_ceil(share).max(1);
                        let count = span.samples.len().div_ceil(stride).max(1);
                        let weight = 1.0 / (count as f64 * records as f64).sqrt();
                        span.samples
                            .clone()
                            .step_by(stride)
                            .map(move |k| (k, weight))
                    })
                    .collect();
                Self { run, rows }
            })
            .collect()
    }

    /// The sample before the first one of a drive along the run.
    pub fn before(&self, drive: &[f64]) -> f64 {
        match (self.run.start, drive) {
            (Start::Periodic, [.., last]) => *last,
            (_, [first, ..]) => *first,
            _ => 0.0,
        }
    }
}
