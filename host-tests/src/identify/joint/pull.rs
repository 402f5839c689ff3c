//! What each row of the least squares asks of the prediction.
//!
//! A reading that was rounded to whole steps tells between which two edges the displacement lies. Rows
//! then ask what the likelihood of that does, for normal noise before the rounding: they pull towards
//! the step that was read, hardly at all from well inside of it, and by the distance from beyond. The
//! noise is taken the larger, the worse the model, so that far from the solution all rows count alike.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::super::score;
use super::responses::Responses;
use super::{Joint, JointFit, Terms};

/// Noise before the rounding that a pull knows of, at least, over half a step.
const SHARPEST: f64 = 0.125;
/// The same over what the model leaves over.
const BLUNTER: f64 = 3.0;
/// Such noise at most, over half a step: all rows count alike then.
const BLUNTEST: f64 = 10.0;
/// Weight below which a row is left out.
const FAINT: f64 = 1e-4;
/// Corrections of an offset.
const CORRECTED: usize = 2;
/// Samples of a run that are looked at for it, the others taken to be like those before them.
const LOOKED_AT: usize = 500;
/// Standard deviations beyond an edge from where on it alone counts.
const BEYOND: f64 = 6.0;
/// Those within both edges from where on nothing does.
const WITHIN: f64 = -4.5;

/// A row: weight, and by how many micrometres the prediction should move.
pub struct Pull {
    /// Root of the weight in the sum of squares.
    pub weight: f64,
    /// In um.
    pub by: f64,
}

/// Readings in whole steps.
#[derive(Clone, Copy, Debug)]
struct Steps {
    half_um: f64,
    noise_um: f64,
}

impl Steps {
    /// For a prediction that the reading is `error` above: slope and curvature of the logarithm of the
    /// likelihood times the squared noise, as the distance to move in um and its weight, 0 to 1.
    fn pull(self, error: f64) -> (f64, f64) {
        let Self { half_um, noise_um } = self;
        // Mirrored, so that the step lies above.
        let (low, high) = (
            (error.abs() - half_um) / noise_um,
            (error.abs() + half_um) / noise_um,
        );
        if low < WITHIN {
            return (0.0, 0.0);
        }
        let (mean, variance) = if low > BEYOND {
            (low + 1.0 / low, 1.0 / (low * low))
        } else {
            let share = tail(low) - tail(high);
            let (at_low, at_high) = (density(low), density(high));
            let mean = (at_low - at_high) / share;
            let bent = (low * at_low - high * at_high) / share;
            (mean, 1.0 + bent - mean * mean)
        };
        let weight = (1.0 - variance).clamp(0.0, 1.0);
        ((mean * noise_um).copysign(error), weight)
    }
}

/// Standard normal density.
fn density(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (2.0 * PI).sqrt()
}

/// Share of a standard normal beyond `x`.
fn tail(x: f64) -> f64 {
    0.5 * libm::erfc(x * FRAC_1_SQRT_2)
}

impl JointFit<'_> {
    /// What the rows of every frame ask of a model.
    pub(super) fn pulls(&self, joint: &Joint, at: &Responses) -> Vec<Vec<Pull>> {
        let steps = joint.terms.half_step(&self.seen).map(|half_um| {
            let least = self.runs.noise_before_steps_um.max(SHARPEST * half_um);
            Steps {
                half_um,
                noise_um: least.max((BLUNTER * joint.rms).min(BLUNTEST * half_um)),
            }
        });
        // Without steps the offset is an unknown like any other.
        let offsets = match steps {
            Some(_) => self.offsets(&joint.terms, &at.y),
            None => vec![0.0; at.y.len()],
        };
        let frames = self.fitted_frames().iter().zip(&at.y).zip(offsets);
        frames
            .map(|((frame, y), offset)| {
                let error = |k: usize| frame.run.displacement[k] - y[k] - offset;
                let pull = |&(k, weight): &(usize, f64)| match steps {
                    None => Pull {
                        weight,
                        by: error(k),
                    },
                    Some(steps) => {
                        let (slope, counts) = steps.pull(error(k));
                        if counts < FAINT {
                            return Pull {
                                weight: 0.0,
                                by: 0.0,
                            };
                        }
                        Pull {
                            weight: weight * counts.sqrt(),
                            by: slope / counts,
                        }
                    }
                };
                frame.rows.iter().map(pull).collect()
            })
            .collect()
    }

    /// The offset of each run in um: where readings are whole steps, the likeliest.
    pub(super) fn offsets(&self, terms: &Terms, predicted: &[Vec<f64>]) -> Vec<f64> {
        let mut offsets = score::offsets(self.runs, predicted);
        let Some(half_um) = terms.half_step(&self.seen) else {
            return offsets;
        };
        let steps = Steps {
            half_um,
            noise_um: self.runs.noise_before_steps_um.max(SHARPEST * half_um),
        };
        for _ in 0..CORRECTED {
            let runs = self.runs.runs.iter().zip(predicted).zip(&offsets);
            let (slopes, weights): (Vec<Vec<f64>>, Vec<Vec<f64>>) = runs
                .map(|((run, predicted), offset)| {
                    let stride = predicted.len().div_ceil(LOOKED_AT).max(1);
                    let samples = run.displacement.iter().zip(predicted).enumerate();
                    let mut seen = (0.0, 0.0);
                    // The means are taken as those of residuals are: these would have such residuals.
                    let stand_ins = samples.map(|(k, (y, predicted))| {
                        if k % stride == 0 {
                            seen = steps.pull(y - predicted - offset);
                        }
                        (y - seen.0, y - seen.1)
                    });
                    stand_ins.unzip()
                })
                .unzip();
            let slopes = score::offsets(self.runs, &slopes);
            let weights = score::offsets(self.runs, &weights);
            for ((offset, slope), weight) in offsets.iter_mut().zip(slopes).zip(weights) {
                *offset += slope / weight.max(FAINT);
            }
        }
        offsets
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the integral, and what is known of the ends.
    #[test]
    fn pull_is_that_of_the_likelihood() {
        let steps = Steps {
            half_um: 1.0,
            noise_um: 0.3,
        };
        let likelihood = |error: f64| {
            const PARTS: usize = 20_000;
            let width = 2.0 / PARTS as f64;
            (0..PARTS)
                .map(|i| error - 1.0 + (i as f64 + 0.5) * width)
                .map(|n| (-0.5 * (n / 0.3_f64).powi(2)).exp() * width)
                .sum::<f64>()
        };
        for error in [-2.0, -1.1, -0.9, -0.2, 0.0, 0.6, 1.0, 1.7] {
            let d = 1e-4;
            let [before, at, after] = [error - d, error, error + d].map(|e| likelihood(e).ln());
            let (slope, weight) = steps.pull(error);
            // A prediction higher up makes the error smaller.
            let wanted = -(after - before) / (2.0 * d) * 0.09;
            assert!((slope - wanted).abs() < 1e-5, "{error}: {slope} {wanted}");
            let wanted = -(after - 2.0 * at + before) / (d * d) * 0.09;
            assert!((weight - wanted).abs() < 1e-3, "{error}: {weight} {wanted}");
        }
        let (slope, weight) = steps.pull(9.0);
        assert!(
            (slope - 8.0).abs() < 0.02 && weight > 0.99,
            "{slope} {weight}"
        );
        assert!(steps.pull(0.0).0.abs() < 1e-12);
    }
}
