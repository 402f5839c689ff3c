//! Hysteresis and effects fitted together: Gauss-Newton steps, damped in the numbers of the effects,
//! with the weights kept non-negative inside each step.
//!
//! Fitting the effects to what a finished hysteresis leaves over does not work: the hysteresis has
//! bent itself towards them.

mod blocks;
mod bouc_wen;
mod descend;
mod frame;
mod intervals;
mod pull;
mod responses;
mod screen;
mod simulate;
mod solve;
mod terms;

pub use bouc_wen::Element;
pub use descend::SETTLED;
pub use intervals::Interval;
pub use screen::Lead;
pub use simulate::Core;
pub use terms::Terms;

use hysteron::hysteresis::elements::ELEMENTS;

use crate::dataset::Role;
use crate::error::Error;

use super::catalogue::{Effect, Seen};
use super::fit::Fitted;
use super::plays::Plays;
use super::run::Runs;
use super::score;
use blocks::Blocks;
use frame::Frame;
use simulate::Columns;

/// Rows of the least squares at most, and where readings are whole steps: few of them are near an edge.
const ROWS: (usize, usize) = (4_000, 12_000);
/// Starts of an effect that are followed to their end from where the plays stand.
const FOLLOWED: usize = 2;
/// Change of a number over which its derivative is taken.
const DIFFERENCE: f64 = 1e-4;
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
            weights: self.core.weights[..=self.core.thresholds.len()].to_vec(),
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
            frames: Frame::all(
                runs,
                if runs.step_um.is_some() {
                    ROWS.1
                } else {
                    ROWS.0
                },
            ),
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

    /// Widest threshold, in volts, of a play that moves: along a session that began at zero, each that the
    /// drive ever reaches.
    pub fn widest(&self) -> f64 {
        if self.runs.is_session() {
            self.seen.threshold_v.max(self.seen.drive_v)
        } else {
            self.seen.threshold_v
        }
    }

    /// Even thresholds up to the widest that the records can show.
    pub fn even_thresholds(&self, plays: usize) -> Vec<f64> {
        let widest = self.seen.threshold_v;
        (1..=plays)
            .map(|i| widest * i as f64 / plays as f64)
            .collect()
    }

    /// Fits the weights alone, for given thresholds, elements and effects.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn weights(
        &self,
        thresholds: Vec<f64>,
        elements: Vec<Element>,
        terms: Terms,
    ) -> Result<Joint, Error> {
        let mut weights = vec![0.0; thresholds.len() + 1 + elements.len()];
        weights[0] = self.runs.mean_gain();
        let beta = terms.beta(&self.seen);
        let core = Core {
            thresholds,
            weights,
            beta,
            elements,
        };
        let rms = self.rms(&core, &terms, Role::Fit)?;
        let mut joint = Joint { core, terms, rms };
        joint.core.weights = self.weigh(&joint)?.0;
        joint.rms = self.rms(&joint.core, &joint.terms, Role::Fit)?;
        Ok(joint)
    }

    /// Adds an effect to a fitted model and fits all again, from the first of the `starts` where the plays
    /// stand, and from the best of the first `weighed` with plays that make room for it; the best of them.
    /// `None` if none can be computed.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn add(
        &self,
        base: &Joint,
        effect: Effect,
        starts: &[Vec<f64>],
        weighed: usize,
    ) -> Result<Option<Joint>, Error> {
        let begun = |numbers: &Vec<f64>| {
            let mut joint = Joint {
                core: base.core.clone(),
                terms: base.terms.with(effect, numbers.clone()),
                rms: f64::INFINITY,
            };
            joint.core.beta = joint.terms.beta(&self.seen);
            joint
        };
        // The plays have bent themselves towards the effect: with room made first another solution may be
        // near. Numbers that the core refuses are no start.
        let roomy = starts.iter().take(weighed).filter_map(|numbers| {
            let mut joint = begun(numbers);
            let (weights, rms) = self.weigh(&joint).ok()?;
            joint.core.weights = weights;
            Some((rms, joint))
        });
        let roomy = roomy.min_by(|a, b| a.0.total_cmp(&b.0));
        let roomy = roomy.map(|(_, joint)| joint);
        let mut best: Option<Joint> = None;
        for mut joint in starts.iter().take(FOLLOWED).map(begun).chain(roomy) {
            if self.settle(&mut joint, SETTLED.1).is_err() {
                continue;
            }
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

    /// Takes plays and elements without weight out and puts new ones halfway to the neighbours of the
    /// others, so that thresholds which no even spread holds are met; then fits all again.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn sharpen(&self, joint: &mut Joint, most: usize) -> Result<(), Error> {
        let core = &joint.core;
        // Along a session, plays up to half the range move in every full loop.
        let looping = if self.runs.is_session() {
            0.5 * self.runs.drive_range
        } else {
            self.seen.threshold_v
        };
        let mut thresholds: Vec<f64> = Vec::new();
        for (i, &r) in core.thresholds.iter().enumerate() {
            let weight = core.weights[i + 1];
            if weight <= 0.0 {
                continue;
            }
            // One play between two of the spread looks like both.
            if let Some(&above) = core.thresholds.get(i + 1)
                && core.weights[i + 2] > 0.0
            {
                let share = core.weights[i + 2] / (weight + core.weights[i + 2]);
                thresholds.push(r + share * (above - r));
            }
            // Where a play moves but once says little about its threshold.
            if r > looping {
                thresholds.push(r);
                continue;
            }
            let below = if i > 0 { core.thresholds[i - 1] } else { 0.0 };
            let above = core.thresholds.get(i + 1).copied();
            let above = above.unwrap_or(r + (r - below)).min(looping);
            thresholds.extend([0.5 * (below + r), r, 0.5 * (r + above)]);
        }
        thresholds.sort_by(f64::total_cmp);
        let apart = 1e-4 * self.seen.threshold_v;
        thresholds.retain(|&r| r > apart);
        thresholds.dedup_by(|a, b| (*a - *b).abs() < apart);
        if thresholds.is_empty() && !core.elements.is_empty() {
            thresholds.clone_from(&core.thresholds);
        }
        if thresholds.is_empty() || thresholds.len() > most {
            return Ok(());
        }
        let mut sharper = joint.clone();
        sharper.core.elements = closer(core);
        let unknowns = thresholds.len() + 1 + sharper.core.elements.len();
        sharper.core.thresholds = thresholds;
        sharper.core.weights = vec![0.0; unknowns];
        sharper.rms = f64::INFINITY;
        (sharper.core.weights, _) = self.weigh(&sharper)?;
        sharper.rms = self.rms(&sharper.core, &sharper.terms, Role::Fit)?;
        self.settle(&mut sharper, SETTLED.0)?;
        if core.active().elements.len() <= ELEMENTS {
            self.merge(&mut sharper)?;
        }
        if sharper.rms < joint.rms {
            *joint = sharper;
        }
        Ok(())
    }

    /// As few elements as a model has room for in place of more, fitted anew.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn merge(&self, joint: &mut Joint) -> Result<(), Error> {
        let core = joint.core.active();
        let of_elements = core.weights.iter().skip(core.thresholds.len() + 1);
        let all: Vec<_> = core
            .elements
            .iter()
            .copied()
            .zip(of_elements.copied())
            .collect();
        if all.len() <= ELEMENTS {
            let plays = joint.core.thresholds.len() + 1;
            joint.core.weights.truncate(plays);
            joint
                .core
                .weights
                .extend(all.iter().map(|(_, weight)| weight));
            joint.core.elements = core.elements;
            return Ok(());
        }
        joint.core.elements = Element::merged(all, ELEMENTS);
        joint.core.weights = vec![0.0; joint.core.thresholds.len() + 1 + ELEMENTS];
        joint.rms = f64::INFINITY;
        (joint.core.weights, _) = self.weigh(joint)?;
        joint.rms = self.rms(&joint.core, &joint.terms, Role::Fit)?;
        self.settle(joint, SETTLED.0)
    }

    fn own_offset(&self, frame: &Frame<'_>) -> bool {
        self.runs.own_offsets || frame.run.loose
    }

    /// The frames that a fit needs: those with rows, and those that one of them goes on from.
    fn fitted_frames(&self) -> &[Frame<'a>] {
        let last = self.frames.iter().rposition(|frame| !frame.rows.is_empty());
        &self.frames[..last.map_or(0, |last| last + 1)]
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
        let offsets = self.offsets(terms, &predicted);
        self.read(&mut predicted, &offsets, terms);
        let rms = score::rms(self.runs, &predicted, &offsets, role).unwrap_or(f64::INFINITY);
        Ok(if rms.is_nan() { f64::INFINITY } else { rms })
    }

    /// Displacement of every run in um, less its offset.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn predicted(&self, core: &Core, terms: &Terms) -> Result<Vec<Vec<f64>>, Error> {
        let mut predicted = self.along(&self.frames, core, terms)?;
        let offsets = self.offsets(terms, &predicted);
        self.read(&mut predicted, &offsets, terms);
        Ok(predicted)
    }

    /// Where the terms hold steps of the reading: moves the prediction towards each reading, by up to
    /// half a step. What is left is what no displacement that gives this reading would leave.
    fn read(&self, predicted: &mut [Vec<f64>], offsets: &[f64], terms: &Terms) {
        let Some(half) = terms.half_step(&self.seen) else {
            return;
        };
        let runs = self.runs.runs.iter().zip(predicted).zip(offsets);
        for ((run, predicted), offset) in runs {
            for (y, reading) in predicted.iter_mut().zip(&run.displacement) {
                *y += (reading - *y - offset).clamp(-half, half);
            }
        }
    }

    fn along(
        &self,
        frames: &[Frame<'_>],
        core: &Core,
        terms: &Terms,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let stages = terms.stages(&self.seen, 1.0);
        let core = core.active();
        let (mut plays, mut gap) = (Vec::new(), None);
        frames
            .iter()
            .map(|frame| {
                let blocks = Blocks::new(&stages, frame.run.sample_time_s)?;
                let drive = simulate::at_actuator(&blocks, frame);
                let w = simulate::hysteresis(&core, &blocks, frame, &drive, &mut plays);
                Ok(simulate::behind(
                    &blocks,
                    frame,
                    w,
                    &mut Columns::default(),
                    &mut gap,
                ))
            })
            .collect()
    }
}

/// The elements of a core that have weight, among their neighbours.
fn closer(core: &Core) -> Vec<Element> {
    let mut all: Vec<Element> = Vec::new();
    for element in core.active().elements.into_iter().flat_map(Element::closer) {
        if !all.iter().any(|other| other.is_near(&element)) {
            all.push(element);
        }
    }
    all
}
