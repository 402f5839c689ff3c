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

pub use simulate::Core;
pub use terms::Terms;

use ndarray::Array2;

use crate::dataset::Role;
use crate::error::Error;

use super::catalogue::{self, Effect, Seen};
use super::fit::Fitted;
use super::plays::Plays;
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

impl Joint {
    /// The hysteresis alone, plays without weight left out.
    pub(super) fn fitted(&self) -> Fitted {
        let fitted = Fitted {
            plays: Plays {
                thresholds: self.core.thresholds.clone(),
                beta: self.core.beta,
            },
            weights: self.core.weights.clone(),
            map: None,
            rms: self.rms,
        };
        fitted.pruned()
    }
}

/// The data and what fits of them share.
pub struct JointFit<'a> {
    runs: &'a Runs,
    frames: Vec<Frame<'a>>,
    seen: Seen,
}

impl<'a> JointFit<'a> {
    /// Fits to the runs.
    pub fn new(runs: &'a Runs) -> Self {
        Self {
            runs,
            frames: Frame::all(runs, ROWS),
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
        joint.core.weights = self.weigh(&joint)?.0;
        joint.rms = self.rms(&joint.core, &joint.terms, Role::Fit)?;
        Ok(joint)
    }

    /// Adds an effect to a fitted model and fits all again, from the best of the effect's starts.
    /// `None` if none of them can be computed.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn add(&self, base: &Joint, effect: Effect, keep: usize) -> Result<Option<Joint>, Error> {
        let starts = match effect {
            Effect::MainsHum => catalogue::hum_starts(&self.seen, &self.left_over(base)?),
            _ => effect.template().starts(&self.seen),
        };
        let mut first: Vec<Joint> = Vec::new();
        let several = starts.len() > 1;
        for numbers in starts {
            let from_nothing = several && numbers.first() == Some(&0.0);
            let mut joint = Joint {
                core: base.core.clone(),
                terms: base.terms.with(effect, numbers),
                rms: f64::INFINITY,
            };
            joint.core.beta = joint.terms.beta(&self.seen);
            // Numbers that the core refuses are no start.
            let Ok((weights, rms)) = self.weigh(&joint) else {
                continue;
            };
            (joint.core.weights, joint.rms) = (weights, rms);
            if from_nothing {
                // Where it does nothing yet, all starts are alike.
                joint.rms = self.rms(&joint.core, &joint.terms, Role::Fit)?;
                self.step(&mut joint, 1e-4)?;
            }
            first.push(joint);
        }
        first.sort_by(|a, b| a.rms.total_cmp(&b.rms));
        first.truncate(keep);
        let mut best: Option<Joint> = None;
        for mut joint in first {
            joint.rms = self.rms(&joint.core, &joint.terms, Role::Fit)?;
            self.settle(&mut joint)?;
            if best.as_ref().is_none_or(|best| joint.rms < best.rms) {
                best = Some(joint);
            }
        }
        Ok(best)
    }

    /// What a model leaves over at the rows of the fit: absolute time in s and residual in um.
    fn left_over(&self, joint: &Joint) -> Result<Vec<(f64, f64)>, Error> {
        let predicted = self.along(self.fitted_frames(), &joint.core, &joint.terms)?;
        let offsets = score::offsets(self.runs, &predicted);
        let mut left = Vec::new();
        for ((frame, predicted), offset) in self.frames.iter().zip(&predicted).zip(offsets) {
            let run = frame.run;
            left.extend(frame.rows.iter().map(|&(k, _)| {
                let time = run.start_s + k as f64 * run.sample_time_s;
                (time, run.displacement[k] - predicted[k] - offset)
            }));
        }
        Ok(left)
    }

    /// Takes plays without weight out and puts new ones halfway to the neighbours of the others, so
    /// that thresholds which no even spread holds are met; then fits all again.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn sharpen(&self, joint: &mut Joint, most: usize) -> Result<(), Error> {
        let core = &joint.core;
        let mut thresholds: Vec<f64> = Vec::new();
        for (i, &r) in core.thresholds.iter().enumerate() {
            if core.weights[i + 1] <= 0.0 {
                continue;
            }
            let below = if i > 0 { core.thresholds[i - 1] } else { 0.0 };
            let above = core.thresholds.get(i + 1).copied();
            let above = above.unwrap_or(r + (r - below)).min(self.seen.threshold_v);
            thresholds.extend([0.5 * (below + r), r, 0.5 * (r + above)]);
        }
        thresholds.sort_by(f64::total_cmp);
        let apart = 1e-4 * self.seen.threshold_v;
        thresholds.retain(|&r| r > apart);
        thresholds.dedup_by(|a, b| (*a - *b).abs() < apart);
        if thresholds.is_empty() || thresholds.len() > most {
            return Ok(());
        }
        let mut sharper = joint.clone();
        sharper.core.thresholds = thresholds;
        sharper.core.weights = vec![0.0; sharper.core.thresholds.len() + 1];
        (sharper.core.weights, _) = self.weigh(&sharper)?;
        sharper.rms = self.rms(&sharper.core, &sharper.terms, Role::Fit)?;
        self.settle(&mut sharper)?;
        if sharper.rms < joint.rms {
            *joint = sharper;
        }
        Ok(())
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

    /// Weights for the effects as they are, and the rms they leave over on the rows.
    fn weigh(&self, joint: &Joint) -> Result<(Vec<f64>, f64), Error> {
        let mut normal = Normal::new(0, joint.core.weights.len());
        for run in self.responses(joint)? {
            normal.add(&run.rows(&joint.core, &[]), self.own_offset(&run));
        }
        let solution = normal.solve(0.0, LEAST_DIRECT * self.runs.mean_gain());
        Ok((solution.weights, solution.rms))
    }

    /// One step; `false` if it led uphill and was not taken.
    fn step(&self, joint: &mut Joint, damping: f64) -> Result<bool, Error> {
        let free = joint.terms.free(&self.seen);
        let weights = joint.core.weights.len();
        let responses = self.responses(joint)?;
        let by_number = free
            .iter()
            .map(|&place| self.derivative(joint, place, &responses))
            .collect::<Result<Vec<_>, _>>()?;
        let mut normal = Normal::new(free.len(), weights);
        for (i, run) in responses.iter().enumerate() {
            let by_number: Vec<&[f64]> = by_number.iter().map(|runs| &runs[i][..]).collect();
            normal.add(&run.rows(&joint.core, &by_number), self.own_offset(run));
        }
        let size = self.seen.displacement_um;
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

    fn own_offset(&self, response: &Response<'_>) -> bool {
        self.runs.own_offsets || response.frame.run.loose
    }

    /// The frames that a fit needs: those with rows, and those that one of them goes on from.
    fn fitted_frames(&self) -> &[Frame<'a>] {
        let last = self.frames.iter().rposition(|frame| !frame.rows.is_empty());
        &self.frames[..last.map_or(0, |last| last + 1)]
    }

    /// What the model makes of the runs for fitting, with derivatives by the weights.
    fn responses(&self, joint: &Joint) -> Result<Vec<Response<'_>>, Error> {
        let mut plays = Vec::new();
        self.fitted_frames()
            .iter()
            .map(|frame| {
                let h = frame.run.sample_time_s;
                let blocks = Blocks::new(&joint.terms.stages(&self.seen, 1.0), h)?;
                let drive = simulate::at_actuator(&blocks, frame);
                if frame.rows.is_empty() {
                    let core = &joint.core;
                    let w = simulate::hysteresis(core, &blocks, frame, &drive, &mut plays);
                    return Ok(Response::empty(frame, w));
                }
                let (w, mut columns) = simulate::hysteresis_and_columns(
                    &joint.core,
                    &blocks,
                    frame,
                    &drive,
                    &mut plays,
                );
                let y = simulate::behind(&blocks, frame, w.clone(), &mut columns);
                Ok(Response {
                    frame,
                    w,
                    y,
                    columns,
                })
            })
            .collect()
    }

    /// Derivative of the displacement by a free number, a run each.
    fn derivative(
        &self,
        joint: &Joint,
        place: (usize, usize),
        responses: &[Response<'_>],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let at = joint.terms.number(place);
        let up = joint.terms.moved(place, DIFFERENCE, &self.seen);
        let moved = if up.number(place) > at {
            up
        } else {
            joint.terms.moved(place, -DIFFERENCE, &self.seen)
        };
        let change = moved.number(place) - at;
        let stages = moved.stages(&self.seen, 1.0);
        let mut core = joint.core.clone();
        core.beta = moved.beta(&self.seen);
        let behind = joint.terms.is_behind(place);
        let mut plays = Vec::new();
        responses
            .iter()
            .map(|run| {
                let blocks = Blocks::new(&stages, run.frame.run.sample_time_s)?;
                let w = if behind {
                    run.w.clone()
                } else {
                    let drive = simulate::at_actuator(&blocks, run.frame);
                    simulate::hysteresis(&core, &blocks, run.frame, &drive, &mut plays)
                };
                let y = simulate::behind(&blocks, run.frame, w, &mut Columns::default());
                Ok(y.iter()
                    .zip(&run.y)
                    .map(|(a, b)| (a - b) / change)
                    .collect())
            })
            .collect()
    }

    /// Root of the mean over the records of a role of their mean square residual, in um; infinite if
    /// there is none.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn rms(&self, core: &Core, terms: &Terms, role: Role) -> Result<f64, Error> {
        let frames = match role {
            Role::Fit => self.fitted_frames(),
            _ => &self.frames,
        };
        let mut predicted = self.along(frames, core, terms)?;
        let offsets = score::offsets(self.runs, &predicted);
        // Steps of the reading have no slope: a fit looks through them.
        if role != Role::Fit {
            self.read(&mut predicted, &offsets, terms)?;
        }
        let rms = score::rms(self.runs, &predicted, &offsets, role).unwrap_or(f64::INFINITY);
        Ok(if rms.is_nan() { f64::INFINITY } else { rms })
    }

    /// Displacement of every run in um, less its offset.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn predicted(&self, core: &Core, terms: &Terms) -> Result<Vec<Vec<f64>>, Error> {
        let mut predicted = self.along(&self.frames, core, terms)?;
        let offsets = score::offsets(self.runs, &predicted);
        self.read(&mut predicted, &offsets, terms)?;
        Ok(predicted)
    }

    /// Rounds to the steps of the reading, where the terms hold any.
    fn read(
        &self,
        predicted: &mut [Vec<f64>],
        offsets: &[f64],
        terms: &Terms,
    ) -> Result<(), Error> {
        if !terms.has(Effect::Quantisation) {
            return Ok(());
        }
        let stages = terms.stages(&self.seen, 1.0);
        let blocks = Blocks::new(&stages, self.seen.sample_time_s)?;
        if let Some(steps) = &blocks.effects.quantisation {
            for (run, offset) in predicted.iter_mut().zip(offsets) {
                run.iter_mut()
                    .for_each(|y| *y = steps.step(*y + offset) - offset);
            }
        }
        Ok(())
    }

    fn along(
        &self,
        frames: &[Frame<'_>],
        core: &Core,
        terms: &Terms,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let stages = terms.stages(&self.seen, 1.0);
        let mut plays = Vec::new();
        frames
            .iter()
            .map(|frame| {
                let blocks = Blocks::new(&stages, frame.run.sample_time_s)?;
                let drive = simulate::at_actuator(&blocks, frame);
                let w = simulate::hysteresis(core, &blocks, frame, &drive, &mut plays);
                Ok(simulate::behind(&blocks, frame, w, &mut Columns::default()))
            })
            .collect()
    }
}

/// What a model makes of a run.
struct Response<'a> {
    frame: &'a Frame<'a>,
    /// Output of the hysteresis in um.
    w: Vec<f64>,
    /// Displacement in um, less the offset.
    y: Vec<f64>,
    /// Its derivatives by the weights.
    columns: Columns,
}

impl<'a> Response<'a> {
    fn empty(frame: &'a Frame<'a>, w: Vec<f64>) -> Self {
        Self {
            frame,
            y: w.clone(),
            w,
            columns: Columns::default(),
        }
    }

    /// Rows `[1, derivatives by the free numbers, derivatives by the weights, target]`, weighted.
    fn rows(&self, core: &Core, by_number: &[&[f64]]) -> Array2<f64> {
        let (free, width) = (by_number.len(), core.weights.len());
        let mut rows = Array2::zeros((self.frame.rows.len(), 1 + free + width + 1));
        for (mut row, &(k, weight)) in rows.outer_iter_mut().zip(&self.frame.rows) {
            row[0] = weight;
            for (j, d) in by_number.iter().enumerate() {
                row[1 + j] = weight * d[k];
            }
            let mut known = 0.0;
            for (j, (d, a)) in self.columns.row(k).iter().zip(&core.weights).enumerate() {
                row[1 + free + j] = weight * d;
                known += a * d;
            }
            // The step is linear in the weights as a whole, not in their change.
            let measured = self.frame.run.displacement[k];
            row[1 + free + width] = weight * (measured - self.y[k] + known);
        }
        rows
    }
}
