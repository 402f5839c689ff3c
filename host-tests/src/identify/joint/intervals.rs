//! How well the records fix the parameters of effects: intervals of 95 % from the model's derivatives at
//! the solution and what it leaves over.
//!
//! What is left over is correlated from sample to sample, so the variance is taken from sums over blocks
//! of neighbouring rows, and not below that of as many independent ones. What the choice of effects, of
//! histories and of thresholds adds is not in it.

use nalgebra::{DMatrix, DVector};

use crate::error::Error;
use crate::model_file::Stage;

use super::super::catalogue::Effect;
use super::terms::Terms;
use super::{DIFFERENCE, Joint, JointFit};

/// Blocks of a run.
const BLOCKS: usize = 24;
/// Standard deviations on either side in an interval of 95 %.
const SIDES: f64 = 1.96;
/// Added to the squares of the columns, of length one: weights of neighbouring plays are almost alike.
const HAIR: f64 = 1e-10;

/// Lower and upper end; `None` where no number of the fit moves the parameter.
pub type Interval = Option<(f64, f64)>;

/// Covariances of the free numbers and of the gain behind them, by both estimates.
struct Spread {
    by_blocks: DMatrix<f64>,
    independent: DMatrix<f64>,
}

impl Spread {
    /// One standard deviation of what has this gradient: how far each number is then off.
    fn direction(&self, gradient: &DVector<f64>) -> Option<DVector<f64>> {
        let along = [&self.by_blocks, &self.independent].map(|covariance| {
            let off = covariance * gradient;
            (gradient.dot(&off), off)
        });
        let (variance, off) = along.into_iter().max_by(|a, b| a.0.total_cmp(&b.0))?;
        (variance > 0.0 && variance.is_finite()).then(|| off / variance.sqrt())
    }
}

/// Numbers of a stage in the order of [`JointFit::intervals`].
fn parameters(stage: &Stage) -> Vec<f64> {
    match stage {
        Stage::Asymmetry(map) => [&map.thresholds, &map.slopes]
            .into_iter()
            .flat_map(|sides| sides.positive.iter().chain(&sides.negative).copied())
            .collect(),
        _ => stage.effect_numbers().into_iter().map(|(_, x)| x).collect(),
    }
}

impl JointFit<'_> {
    /// Intervals of the parameters of every term of a fitted model, under the sign of its gain: in the
    /// order of [`Stage::effect_numbers`]; of an asymmetry the thresholds, positive and negative, then
    /// the slopes; of the rate term beta.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn intervals(&self, joint: &Joint) -> Result<Vec<Vec<Interval>>, Error> {
        let mut joint = joint.clone();
        joint.core = joint.core.active();
        let places = joint.terms.free(&self.seen);
        let gain: f64 = joint.core.weights.iter().sum();
        let spread = self.spread(&joint, places.len())?;
        let of = |terms: &Terms, gain: f64, index: usize| -> Vec<f64> {
            let Some(term) = terms.iter().nth(index) else {
                return Vec::new();
            };
            if term.effect == Effect::RateDependence {
                return vec![terms.beta(&self.seen)];
            }
            let stage = term
                .effect
                .template()
                .stage(&term.numbers, &self.seen, gain);
            stage.map_or_else(Vec::new, |stage| parameters(&stage.signed(self.runs.sign)))
        };
        // Each number moved a little, the gain last.
        let moved: Vec<(Terms, f64, f64)> = places
            .iter()
            .map(|&place| {
                let (terms, change) = self.nudged(&joint.terms, place);
                (terms, gain, change)
            })
            .chain([(
                joint.terms.clone(),
                gain * (1.0 + DIFFERENCE),
                gain * DIFFERENCE,
            )])
            .collect();
        let intervals = |(index, term): (usize, &super::terms::Term)| {
            let at = of(&joint.terms, gain, index);
            let there: Vec<Vec<f64>> = moved.iter().map(|m| of(&m.0, m.1, index)).collect();
            let phase = |i: usize| term.effect == Effect::MainsHum && (i == 2 || i == 4);
            (0..at.len())
                .map(|i| {
                    let near = |x: f64| if phase(i) { unwrapped(x, at[i]) } else { x };
                    let gradient = there.iter().zip(&moved).map(|(there, m)| {
                        let there = there.get(i).copied().map_or(at[i], near);
                        (there - at[i]) / m.2
                    });
                    let gradient = DVector::from_iterator(moved.len(), gradient);
                    let off = spread.as_ref()?.direction(&gradient)?;
                    let end = |sides: f64| {
                        let terms = places
                            .iter()
                            .zip(off.iter())
                            .fold(joint.terms.clone(), |terms, (&place, off)| {
                                terms.moved(place, sides * off, &self.seen)
                            });
                        let gain = gain + sides * off[places.len()];
                        of(&terms, gain, index).get(i).copied().map(near)
                    };
                    let (a, b) = (end(-SIDES)?, end(SIDES)?);
                    Some((a.min(b).min(at[i]), a.max(b).max(at[i])))
                })
                .collect()
        };
        Ok(joint.terms.iter().enumerate().map(intervals).collect())
    }

    /// Terms with one number moved a little, and by how much, within its bounds.
    fn nudged(&self, terms: &Terms, place: (usize, usize)) -> (Terms, f64) {
        let at = terms.number(place);
        let up = terms.moved(place, DIFFERENCE, &self.seen);
        let moved = if up.number(place) > at {
            up
        } else {
            terms.moved(place, -DIFFERENCE, &self.seen)
        };
        let change = moved.number(place) - at;
        (moved, change)
    }

    /// `None` where there are too few blocks for so many unknowns.
    fn spread(&self, joint: &Joint, free: usize) -> Result<Option<Spread>, Error> {
        let frames = self.fitted_frames();
        let at = self.responses(joint)?;
        let pulls = self.pulls(joint, &at);
        let mut signals = self.by_numbers(joint, &at);
        signals.extend((0..joint.core.weights.len()).map(|j| at.by_weight(frames, j)));
        let ones = frames.iter().map(|frame| vec![1.0; frame.run.drive.len()]);
        signals.push(ones.collect());
        let mut columns: Vec<DVector<f64>> =
            signals.iter().map(|s| self.at_rows(&pulls, s)).collect();
        let lengths: Vec<f64> = columns.iter().map(|column| column.norm()).collect();
        for (column, length) in columns.iter_mut().zip(&lengths) {
            *column /= length.max(f64::MIN_POSITIVE);
        }
        let columns = DMatrix::from_columns(&columns);
        let residual = self.asked(&pulls);
        let (rows, unknowns) = columns.shape();
        let mut square = columns.tr_mul(&columns);
        for i in 0..unknowns {
            square[(i, i)] += HAIR;
        }
        let Some(inverse) = square.cholesky() else {
            return Ok(None);
        };
        let left = &residual - &columns * inverse.solve(&columns.tr_mul(&residual));
        // The free numbers, and the sum of the weights.
        let wanted = DMatrix::from_fn(unknowns, free + 1, |i, j| {
            let weight = (free..free + joint.core.weights.len()).contains(&i);
            if (j < free && i == j) || (j == free && weight) {
                1.0 / lengths[i].max(f64::MIN_POSITIVE)
            } else {
                0.0
            }
        });
        let wanted = wanted.map(|x| if x < 1e100 { x } else { 0.0 });
        let influence = &columns * inverse.solve(&wanted);
        let mut by_blocks = DMatrix::zeros(free + 1, free + 1);
        let (mut from, mut blocks) = (0, 0);
        for frame in frames {
            let to = from + frame.rows.len();
            let length = frame.rows.len().div_ceil(BLOCKS).max(1);
            while from < to {
                let count = length.min(to - from);
                let sum = influence.rows(from, count).tr_mul(&left.rows(from, count));
                by_blocks += &sum * sum.transpose();
                blocks += 1;
                from += count;
            }
        }
        if rows <= unknowns || blocks <= unknowns {
            return Ok(None);
        }
        let mean_square = left.norm_squared() / (rows - unknowns) as f64;
        Ok(Some(Spread {
            by_blocks: by_blocks * (blocks as f64 / (blocks - unknowns) as f64),
            independent: influence.tr_mul(&influence) * mean_square,
        }))
    }
}

/// An angle within half a turn of another one.
fn unwrapped(angle: f64, near: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * ((angle - near) / turn).round()
}
