//! What a model makes of the runs for fitting, and how that changes with its numbers and weights.

use ndarray::Array2;

use crate::error::Error;

use super::blocks::Blocks;
use super::frame::Frame;
use super::pull::Pull;
use super::simulate::{self, Columns};
use super::solve::Normal;
use super::terms::Terms;
use super::{Core, DIFFERENCE, Joint, JointFit};

/// What a model makes of the runs for fitting, an entry a run.
pub struct Responses {
    /// Output of the hysteresis in um.
    pub w: Vec<Vec<f64>>,
    /// Displacement in um, less the offset.
    pub y: Vec<Vec<f64>>,
    /// Its derivatives by the weights.
    columns: Vec<Columns>,
}

impl Responses {
    /// Derivative of the displacement by weight `j`, a run each, at the rows of the `frames`.
    pub fn by_weight(&self, frames: &[Frame<'_>], j: usize) -> Vec<Vec<f64>> {
        let runs = frames.iter().zip(&self.columns);
        runs.map(|(frame, columns)| {
            let mut signal = vec![0.0; frame.run.drive.len()];
            for (index, &(k, _)) in frame.rows.iter().enumerate() {
                signal[k] = columns.of_row(index, k).get(j).copied().unwrap_or(0.0);
            }
            signal
        })
        .collect()
    }
}

impl JointFit<'_> {
    /// What `joint` makes of the runs, with derivatives by its weights.
    pub(super) fn responses(&self, joint: &Joint) -> Result<Responses, Error> {
        let stages = joint.terms.stages(&self.seen, 1.0);
        let (mut plays, mut gap) = (Vec::new(), None);
        let mut found = Responses {
            w: Vec::new(),
            y: Vec::new(),
            columns: Vec::new(),
        };
        for frame in self.fitted_frames() {
            let blocks = Blocks::new(&stages, frame.run.sample_time_s)?;
            let drive = simulate::at_actuator(&blocks, frame);
            let (w, mut columns) = if frame.rows.is_empty() {
                let w = simulate::hysteresis(&joint.core, &blocks, frame, &drive, &mut plays);
                (w, Columns::default())
            } else {
                simulate::hysteresis_and_columns(&joint.core, &blocks, frame, &drive, &mut plays)
            };
            found.y.push(simulate::behind(
                &blocks,
                frame,
                w.clone(),
                &mut columns,
                &mut gap,
            ));
            found.w.push(w);
            found.columns.push(columns);
        }
        Ok(found)
    }

    /// Derivatives of the displacement by every free number: number by number, a run each.
    pub(super) fn by_numbers(&self, joint: &Joint, responses: &Responses) -> Vec<Vec<Vec<f64>>> {
        let free = joint.terms.free(&self.seen);
        free.iter()
            .map(|&place| {
                let behind = joint.terms.is_behind(place).then_some(&responses.w[..]);
                let slope = self.slope(&joint.core, &joint.terms, place, behind, &responses.y);
                // A number between two that the core refuses stays where it is.
                slope.unwrap_or_else(|_| responses.y.iter().map(|y| vec![0.0; y.len()]).collect())
            })
            .collect()
    }

    /// Derivative of the displacement by the number at `place` of the `terms`, a run each: taken upwards,
    /// or downwards where the core refuses what is above.
    pub(super) fn slope(
        &self,
        core: &Core,
        terms: &Terms,
        place: (usize, usize),
        behind: Option<&[Vec<f64>]>,
        y: &[Vec<f64>],
    ) -> Result<Vec<Vec<f64>>, Error> {
        let towards = |step: f64| {
            let moved = terms.moved(place, step, &self.seen);
            let change = moved.number(place) - terms.number(place);
            if change == 0.0 {
                return Err(Error::request("a number at its bound".to_owned()));
            }
            self.differences(core, &moved, behind, y, change)
        };
        towards(DIFFERENCE).or_else(|_| towards(-DIFFERENCE))
    }

    /// What the displacement changes by with other `terms`, over `change`, a run each. Where they act
    /// behind the hysteresis only, its output `w` is given.
    pub(super) fn differences(
        &self,
        core: &Core,
        terms: &Terms,
        w: Option<&[Vec<f64>]>,
        y: &[Vec<f64>],
        change: f64,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let stages = terms.stages(&self.seen, 1.0);
        let mut core = core.active();
        core.beta = terms.beta(&self.seen);
        let (mut plays, mut gap) = (Vec::new(), None);
        let frames = self.fitted_frames().iter().zip(y).enumerate();
        frames
            .map(|(i, (frame, before))| {
                let blocks = Blocks::new(&stages, frame.run.sample_time_s)?;
                let w = w.and_then(|w| w.get(i)).cloned().unwrap_or_else(|| {
                    let drive = simulate::at_actuator(&blocks, frame);
                    simulate::hysteresis(&core, &blocks, frame, &drive, &mut plays)
                });
                let mut y = simulate::behind(&blocks, frame, w, &mut Columns::default(), &mut gap);
                for (y, before) in y.iter_mut().zip(before) {
                    *y = (*y - before) / change;
                }
                Ok(y)
            })
            .collect()
    }

    /// The least squares of a step: free numbers, then weights, then the measured displacement.
    pub(super) fn normal(
        &self,
        joint: &Joint,
        responses: &Responses,
        by_numbers: &[Vec<Vec<f64>>],
    ) -> Normal {
        let mut normal = Normal::new(by_numbers.len(), joint.core.weights.len());
        let pulls = self.pulls(joint, responses);
        for (i, (frame, pulls)) in self.fitted_frames().iter().zip(&pulls).enumerate() {
            let by_number: Vec<&[f64]> = by_numbers.iter().map(|runs| &runs[i][..]).collect();
            let rows = rows(frame, pulls, &joint.core, responses, i, &by_number);
            normal.add(&rows, self.own_offset(frame));
        }
        normal
    }
}

/// Rows `[1, derivatives by the free numbers, derivatives by the weights, target]` of run `i`, weighted.
fn rows(
    frame: &Frame<'_>,
    pulls: &[Pull],
    core: &Core,
    responses: &Responses,
    i: usize,
    by_number: &[&[f64]],
) -> Array2<f64> {
    let (free, width) = (by_number.len(), core.weights.len());
    let columns = &responses.columns[i];
    let mut rows = Array2::zeros((frame.rows.len(), 1 + free + width + 1));
    let along = rows.outer_iter_mut().zip(&frame.rows).zip(pulls);
    for (index, ((mut row, &(k, _)), &Pull { weight, by })) in along.enumerate() {
        row[0] = weight;
        for (j, d) in by_number.iter().enumerate() {
            row[1 + j] = weight * d[k];
        }
        let mut known = 0.0;
        let derivatives = columns.of_row(index, k);
        for (j, (d, a)) in derivatives.iter().zip(&core.weights).enumerate() {
            row[1 + free + j] = weight * d;
            known += a * d;
        }
        // The step is linear in the weights as a whole, not in their change.
        row[1 + free + width] = weight * (by + known);
    }
    rows
}
