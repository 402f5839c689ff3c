//! Hysteresis and effects fitted together: Gauss-Newton steps, damped in the numbers of the effects,
//! with the weights kept non-negative inside each step.
//!
//! Fitting the effects to what a finished hysteresis leaves over does not work: the hysteresis has
//! bent itself towards them.

mod blocks;
mod frame;
mod simulate;
mod solve;
mod terms;

pub use frame::Between;
pub use simulate::Core;
pub use terms::{Term, Terms};

use ndarray::Array2;

use crate::dataset::Role;
use crate::error::Error;

use super::catalogue::{Effect, Seen};
use super::run::Runs;
use super::score;
use blocks::Blocks;
use frame::Frame;
use simulate::Columns;
use solve::Normal;

/// Steps at most; a fit of this kind settles in about ten.
const STEPS: usize = 40;
/// Relative gain of a step below which the fit has settled.
const SETTLED: f64 = 1e-4;
/// Rows of the least squares at most.
const ROWS: usize = 4_000;
/// Change of a number over which its derivative is taken.
const DIFFERENCE: f64 = 1e-4;
/// Largest change of a number in a step.
const STRIDE: f64 = 1.0;
/// Least weight of the drive itself, over the mean gain: the inverse divides by it.
const LEAST_DIRECT: f64 = 0.1;

/// Hysteresis and effects, displacements in micrometres.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Thresholds, weights and beta.
    pub core: Core,
    /// The effects.
    pub terms: Terms,
    /// Root of the mean over the fit records of their mean square residual, in um.
    pub rms: f64,
}

/// The data and what fits of them share.
pub struct JointFit<'a> {
    runs: &'a Runs,
    frames: Vec<Frame<'a>>,
    seen: Seen,
}

impl<'a> JointFit<'a> {
    /// Fits to the runs.
    pub fn new(runs: &'a Runs, between: Between) -> Self {
        Self {
            runs,
            frames: Frame::all(runs, between, ROWS),
            seen: Seen::new(runs),
        }
    }

    /// What the numbers of the terms are measured by.
    pub fn seen(&self) -> &Seen {
        &self.seen
    }

    /// The runs.
    pub fn runs(&self) -> &Runs {
        self.runs
    }

    /// Even thresholds up to the widest that the records can show.
    pub fn even_thresholds(&self, plays: usize) -> Vec<f64> {
        let widest = self.seen.threshold_v;
        (1..=plays)
            .map(|i| widest * i as f64 / plays as f64)
            .collect()
    }

    /// Fits the weights alone, for given thresholds and effects.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn weights(&self, thresholds: Vec<f64>, terms: Terms) -> Result<Joint, Error> {
        let mut weights = vec![0.0; thresholds.len() + 1];
        weights[0] = self.runs.mean_gain();
        let beta = terms.beta(&self.seen);
        let core = Core {
            thresholds,
            weights,
            beta,
        };
        let rms = self.rms(&core, &terms, Role::Fit)?;
        let mut joint = Joint { core, terms, rms };
        self.step(&mut joint, f64::INFINITY)?;
        Ok(joint)
    }

    /// Adds an effect to a fitted model and fits all again, from the best of the effect's starts.
    /// `None` if none of them can be computed.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn add(&self, base: &Joint, effect: Effect, keep: usize) -> Result<Option<Joint>, Error> {
        let starts = effect.template().starts(&self.seen);
        let mut first: Vec<Joint> = Vec::new();
        for numbers in starts {
            let mut joint = Joint {
                core: base.core.clone(),
                terms: base.terms.with(effect, numbers),
                rms: f64::INFINITY,
            };
            joint.core.beta = joint.terms.beta(&self.seen);
            let Ok(rms) = self.rms(&joint.core, &joint.terms, Role::Fit) else {
                continue;
            };
            joint.rms = rms;
            self.step(&mut joint, f64::INFINITY)?;
            first.push(joint);
        }
        first.sort_by(|a, b| a.rms.total_cmp(&b.rms));
        first.truncate(keep);
        let mut best: Option<Joint> = None;
        for mut joint in first {
            self.settle(&mut joint)?;
            if best.as_ref().is_none_or(|best| joint.rms < best.rms) {
                best = Some(joint);
            }
        }
        Ok(best)
    }

    /// Steps until they no longer help.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn settle(&self, joint: &mut Joint) -> Result<(), Error> {
        let mut damping = 1e-2;
        for _ in 0..STEPS {
            let before = joint.rms;
            if self.step(joint, damping)? {
                damping = (damping * 0.1).max(1e-9);
                if joint.rms > (1.0 - SETTLED) * before {
                    break;
                }
            } else {
                damping *= 10.0;
                if damping > 1e3 {
                    break;
                }
            }
        }
        Ok(())
    }

    /// One step; `false` if it led uphill and was not taken. Infinite damping holds the effects.
    fn step(&self, joint: &mut Joint, damping: f64) -> Result<bool, Error> {
        let free = if damping.is_finite() {
            joint.terms.free(&self.seen)
        } else {
            Vec::new()
        };
        let weights = joint.core.weights.len();
        let by_number = free
            .iter()
            .map(|&place| self.derivative(joint, place))
            .collect::<Result<Vec<_>, _>>()?;
        let mut normal = Normal::new(free.len(), weights, self.runs.own_offsets);
        let mut plays = Vec::new();
        for (i, frame) in self.frames.iter().enumerate() {
            let by_number: Vec<&[f64]> = by_number.iter().map(|runs| &runs[i][..]).collect();
            normal.add(&self.rows(joint, frame, &by_number, &mut plays)?);
        }
        let size = self.seen.displacement_um;
        let damping = if free.is_empty() { 0.0 } else { damping };
        let floor = LEAST_DIRECT * self.runs.mean_gain();
        let solution = normal.solve(damping * size * size * 1e-2, floor);
        let mut next = joint.clone();
        next.core.weights = solution.weights;
        for (&place, change) in free.iter().zip(solution.free) {
            let change = change.clamp(-STRIDE, STRIDE);
            next.terms = next.terms.moved(place, change, &self.seen);
        }
        next.core.beta = next.terms.beta(&self.seen);
        // Numbers that the core refuses lead uphill.
        let Ok(rms) = self.rms(&next.core, &next.terms, Role::Fit) else {
            return Ok(false);
        };
        next.rms = rms;
        let better = next.rms < joint.rms;
        if better {
            *joint = next;
        }
        Ok(better)
    }

    /// Derivative of every run's displacement by a free number.
    fn derivative(&self, joint: &Joint, place: (usize, usize)) -> Result<Vec<Vec<f64>>, Error> {
        let at = joint.terms.number(place);
        let moved = |change: f64| joint.terms.moved(place, change, &self.seen);
        let displacement = |terms: &Terms| {
            let mut core = joint.core.clone();
            core.beta = terms.beta(&self.seen);
            self.predicted(&core, terms)
        };
        // On one side alone where it stands at a bound.
        let (up, down) = (moved(DIFFERENCE), moved(-DIFFERENCE));
        let change = up.number(place) - down.number(place);
        let _ = at;
        let (above, below) = (displacement(&up)?, displacement(&down)?);
        Ok(above
            .iter()
            .zip(&below)
            .map(|(a, b)| a.iter().zip(b).map(|(a, b)| (a - b) / change).collect())
            .collect())
    }

    /// Rows `[1, derivatives by the free numbers, derivatives by the weights, target]`, weighted.
    fn rows(
        &self,
        joint: &Joint,
        frame: &Frame<'_>,
        by_number: &[&[f64]],
        plays: &mut Vec<f64>,
    ) -> Result<Array2<f64>, Error> {
        let core = &joint.core;
        let h = frame.run.sample_time_s;
        let blocks = Blocks::new(&joint.terms.stages(&self.seen, 1.0), h)?;
        let fine = simulate::at_actuator(&blocks, frame);
        let (w, mut columns) = simulate::hysteresis_and_columns(core, &blocks, frame, &fine, plays);
        let y = simulate::behind(&blocks, frame, w, &mut columns);
        let (free, width) = (by_number.len(), columns.width);
        let mut rows = Array2::zeros((frame.rows.len(), 1 + free + width + 1));
        for (mut row, &(k, weight)) in rows.outer_iter_mut().zip(&frame.rows) {
            row[0] = weight;
            for (j, d) in by_number.iter().enumerate() {
                row[1 + j] = weight * d[k];
            }
            let mut known = 0.0;
            for (j, (d, a)) in columns.row(k).iter().zip(&core.weights).enumerate() {
                row[1 + free + j] = weight * d;
                known += a * d;
            }
            // The step is linear in the weights as a whole, not in their change.
            row[1 + free + width] = weight * (frame.run.displacement[k] - y[k] + known);
        }
        Ok(rows)
    }

    /// Root of the mean over the records of a role of their mean square residual, in um; infinite if
    /// there is none.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn rms(&self, core: &Core, terms: &Terms, role: Role) -> Result<f64, Error> {
        let predicted = self.predicted(core, terms)?;
        let offsets = score::offsets(self.runs, &predicted);
        let rms = score::rms(self.runs, &predicted, &offsets, role).unwrap_or(f64::INFINITY);
        Ok(if rms.is_nan() { f64::INFINITY } else { rms })
    }

    /// Displacement of every run in um, less its offset.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn predicted(&self, core: &Core, terms: &Terms) -> Result<Vec<Vec<f64>>, Error> {
        let mut plays = Vec::new();
        self.frames
            .iter()
            .map(|frame| {
                let blocks = Blocks::new(&terms.stages(&self.seen, 1.0), frame.run.sample_time_s)?;
                let fine = simulate::at_actuator(&blocks, frame);
                let w = simulate::hysteresis(core, &blocks, frame, &fine, &mut plays);
                Ok(simulate::behind(&blocks, frame, w, &mut Columns::default()))
            })
            .collect()
    }
}
