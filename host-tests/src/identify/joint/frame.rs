//! A run made ready for many simulations: its fine grid, its rows of the least squares.

use crate::dataset::Role;

use super::super::run::{Run, Runs};
use super::super::start::Start;

/// Fine steps in a sample where the drive is taken as smooth.
pub const SMOOTH: usize = 4;

/// How the drive moves between samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Between {
    /// The rate at a sample is that of the step that led to it.
    Lines,
    /// A smooth curve through the samples, [`SMOOTH`] steps to each.
    Smooth,
}

impl Between {
    fn steps(self) -> usize {
        match self {
            Self::Lines => 1,
            Self::Smooth => SMOOTH,
        }
    }
}

/// A run and what a fit looks at of it.
pub struct Frame<'a> {
    /// The run.
    pub run: &'a Run,
    /// Samples that are rows of the least squares, with their weights.
    pub rows: Vec<(usize, f64)>,
    /// Fine steps in a sample.
    pub steps: usize,
}

impl<'a> Frame<'a> {
    /// Frames of all runs with about `most_rows` rows in all, every record counting the same.
    pub fn all(runs: &'a Runs, between: Between, most_rows: usize) -> Vec<Self> {
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
                Self {
                    run,
                    rows,
                    steps: between.steps(),
                }
            })
            .collect()
    }

    /// `drive`, one value a sample of the run, on the fine grid: the first fine value belongs to the
    /// first sample, every [`Frame::steps`]-th to one more.
    pub fn fine(&self, drive: Vec<f64>) -> Vec<f64> {
        if self.steps == 1 {
            return drive;
        }
        let last = drive.len().saturating_sub(1);
        let at = |k: usize| drive[k.min(last)];
        let mut fine = Vec::with_capacity(last * self.steps + 1);
        fine.extend(drive.first());
        for k in 0..last {
            let [a, b, c, d] = [at(k.saturating_sub(1)), at(k), at(k + 1), at(k + 2)];
            let (into, out) = (0.5 * (c - a), 0.5 * (d - b));
            for i in 1..=self.steps {
                let t = i as f64 / self.steps as f64;
                // Cubic with the slopes of the neighbours (Catmull-Rom).
                let rise = c - b;
                let bend = (3.0 * rise - 2.0 * into - out) * t * t;
                let twist = (into + out - 2.0 * rise) * t * t * t;
                fine.push(b + into * t + bend + twist);
            }
        }
        fine
    }

    /// The drive one fine step before the first one of `fine`.
    pub fn before(&self, fine: &[f64]) -> f64 {
        match (self.run.start, fine) {
            (Start::Periodic, [.., last]) => *last,
            (_, [first, ..]) => *first,
            _ => 0.0,
        }
    }
}
