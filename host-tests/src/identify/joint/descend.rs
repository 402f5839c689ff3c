//! Steps downhill: Gauss-Newton, damped in the numbers of the effects, weights non-negative.

use crate::dataset::Role;
use crate::error::Error;

use super::super::score;
use super::responses::Responses;
use super::solve::Normal;
use super::{Joint, JointFit, LEAST_DIRECT, Terms};

/// Steps at most; a fit of this kind settles in about ten.
const STEPS: usize = 40;
/// Relative gain of a step below which a fit has settled, and one that is only to be compared.
pub const SETTLED: (f64, f64) = (1e-4, 1e-3);
/// Largest change of a number in a step.
const STRIDE: f64 = 1.0;
/// How often plays that had no weight may come in again.
const WIDENED: usize = 3;
/// Relative gain below which they do not.
const WIDER: f64 = 1e-3;
/// Damping of the first step, and beyond which none leads downhill.
const DAMPING: (f64, f64) = (1e-2, 1e3);

impl JointFit<'_> {
    /// Steps until one gains less than the share `settled` of what is left over: among the plays that
    /// have weight, as long as the others would get none.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn settle(&self, joint: &mut Joint, settled: f64) -> Result<(), Error> {
        for round in 1.. {
            let all = joint.core.clone();
            joint.core = joint.core.active();
            self.descend(joint, settled)?;
            joint.core = joint.core.among(&all);
            if round == WIDENED {
                break;
            }
            let (weights, rms) = self.weigh(joint)?;
            // The rows see almost, but not quite, what all samples see.
            let (_, here) = self.weigh(&Joint {
                core: joint.core.active(),
                ..joint.clone()
            })?;
            if rms > (1.0 - WIDER) * here {
                break;
            }
            joint.core.weights = weights;
        }
        Ok(())
    }

    fn descend(&self, joint: &mut Joint, settled: f64) -> Result<(), Error> {
        let mut at = self.responses(joint)?;
        joint.rms = self.left(&joint.terms, &at);
        let mut damping = DAMPING.0;
        let mut steps = 0..STEPS;
        'steps: while steps.next().is_some() {
            let normal = self.normal(joint, &at, &self.by_numbers(joint, &at));
            let mut uphill = false;
            loop {
                if let Some((next, there)) = self.moved(joint, &normal, damping)? {
                    let gain = 1.0 - next.rms / joint.rms;
                    (*joint, at) = (next, there);
                    // Where less damping led uphill just now, it would most likely again.
                    if !uphill {
                        damping = (damping * 0.1).max(1e-9);
                    }
                    if gain < settled {
                        break 'steps;
                    }
                    break;
                }
                uphill = true;
                damping *= 10.0;
                if damping > DAMPING.1 || steps.next().is_none() {
                    break 'steps;
                }
            }
        }
        Ok(())
    }

    /// The model after a step, with its responses; `None` if it leads uphill.
    fn moved(
        &self,
        joint: &Joint,
        normal: &Normal,
        damping: f64,
    ) -> Result<Option<(Joint, Responses)>, Error> {
        let size = self.seen.displacement_um;
        let floor = LEAST_DIRECT * self.runs.mean_gain();
        let solution = normal.solve(damping * size * size * 1e-2, floor);
        let mut next = joint.clone();
        next.core.weights = solution.weights;
        let free = joint.terms.free(&self.seen);
        for (&place, change) in free.iter().zip(solution.free) {
            let change = change.clamp(-STRIDE, STRIDE);
            next.terms = next.terms.moved(place, change, &self.seen);
        }
        next.core.beta = next.terms.beta(&self.seen);
        // Numbers that the core refuses lead uphill.
        let Ok(there) = self.responses(&next) else {
            return Ok(None);
        };
        next.rms = self.left(&next.terms, &there);
        Ok((next.rms < joint.rms).then_some((next, there)))
    }

    /// Weights for the effects as they are, and the rms they leave over on the rows.
    pub(super) fn weigh(&self, joint: &Joint) -> Result<(Vec<f64>, f64), Error> {
        let responses = self.responses(joint)?;
        let normal = self.normal(joint, &responses, &[]);
        let solution = normal.solve(0.0, LEAST_DIRECT * self.runs.mean_gain());
        Ok((solution.weights, solution.rms))
    }

    /// What responses leave over of the fit records: root of the mean over them of their mean square.
    pub(super) fn left(&self, terms: &Terms, responses: &Responses) -> f64 {
        let offsets = self.offsets(terms, &responses.y);
        let rms = match terms.half_step(&self.seen) {
            Some(_) => {
                let mut read = responses.y.clone();
                self.read(&mut read, &offsets, terms);
                score::rms(self.runs, &read, &offsets, Role::Fit)
            }
            None => score::rms(self.runs, &responses.y, &offsets, Role::Fit),
        };
        rms.filter(|rms| !rms.is_nan()).unwrap_or(f64::INFINITY)
    }
}
