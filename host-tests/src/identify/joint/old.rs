//! Hysteresis and effects fitted together: Gauss-Newton steps, damped in the numbers of the effects
//! and beta, with the weights kept non-negative inside each step.
//!
//! Fitting the effects to what a finished hysteresis leaves over does not work: the hysteresis has
//! bent itself towards them.

use hysteron::chain::Effects;
use nalgebra::DVector;

use crate::dataset::Role;
use crate::error::Error;

use super::effects::{Effect, Scale, Terms};
use super::plays::Plays;
use super::reduce::{Triangle, non_negative};
use super::run::{Run, Runs};

/// Steps at most; a fit of this kind settles in about ten.
const STEPS: usize = 40;
/// Relative gain of a step below which the fit has settled.
const SETTLED: f64 = 1e-5;
/// Frequencies at which a mode is looked for.
const MODE_STARTS: usize = 24;
/// Rows that a step folds at most: of longer records an even choice of samples.
const ROWS: usize = 8_000;

/// Hysteresis and effects, displacements in micrometres.
#[derive(Clone, Debug)]
pub struct Joint {
    /// Thresholds and beta.
    pub plays: Plays,
    /// Weights a_0..a_n in um/V.
    pub weights: Vec<f64>,
    /// The effects.
    pub terms: Terms,
    /// Root of the mean over the fit records of their mean square residual, in um.
    pub rms: f64,
}

/// The data and what a fit of them shares.
pub struct JointFit<'a> {
    runs: &'a Runs,
    scale: Scale,
    with_beta: bool,
}

/// What a model makes of a run.
struct Response {
    /// Displacement in um, less the offset.
    displacement: Vec<f64>,
    /// Its derivatives by the weights.
    by_weight: Vec<Vec<f64>>,
}

impl<'a> JointFit<'a> {
    /// A fit to the runs; beta is fitted where `with_beta`.
    pub fn new(runs: &'a Runs, with_beta: bool) -> Self {
        let displacement_um = 0.5 * runs.mean_gain() * runs.drive_range;
        let fold = |start: f64, pick: fn(f64, f64) -> f64, of: fn(&Run) -> f64| {
            runs.runs.iter().map(of).fold(start, pick)
        };
        Self {
            runs,
            scale: Scale {
                sample_time_s: fold(f64::INFINITY, f64::min, |run| run.sample_time_s),
                displacement_um,
                duration_s: fold(0.0, f64::max, |run| {
                    run.drive.len() as f64 * run.sample_time_s
                }),
            },
            with_beta,
        }
    }

    /// What the numbers of the terms are measured by.
    pub fn scale(&self) -> &Scale {
        &self.scale
    }

    /// Fits `plays` plays on an even spread of thresholds together with `effects`.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn fit(&self, plays: usize, effects: &[Effect]) -> Result<Joint, Error> {
        let widest = self.runs.widest_threshold();
        let plays = Plays {
            thresholds: (1..=plays)
                .map(|i| widest * i as f64 / plays as f64)
                .collect(),
            beta: 0.0,
        };
        let mut starts = Vec::new();
        let (low, high) = (2.0 / self.scale.duration_s, 0.2 / self.scale.sample_time_s);
        let tried = if effects.contains(&Effect::Resonance) {
            MODE_STARTS
        } else {
            1
        };
        for i in 0..tried {
            let share = i as f64 / MODE_STARTS as f64;
            let f_n_hz = low * (high / low).powf(share);
            let mut joint = Joint {
                plays: plays.clone(),
                weights: vec![0.0; plays.thresholds.len() + 1],
                terms: Terms::new(effects, f_n_hz),
                rms: f64::INFINITY,
            };
            if let Some(first) = joint.weights.first_mut() {
                *first = self.runs.mean_gain();
            }
            joint.rms = self.rms(&joint)?;
            // Weights alone, and the terms at their start.
            self.step(&mut joint, f64::INFINITY)?;
            starts.push(joint);
        }
        starts.sort_by(|a, b| a.rms.total_cmp(&b.rms));
        starts.truncate(2);
        let mut best: Option<Joint> = None;
        for mut joint in starts {
            self.settle(&mut joint)?;
            if best.as_ref().is_none_or(|best| joint.rms < best.rms) {
                best = Some(joint);
            }
        }
        best.ok_or_else(|| Error::request("there is nothing to fit".to_owned()))
    }

    fn settle(&self, joint: &mut Joint) -> Result<(), Error> {
        let mut damping = 1e-2;
        for _ in 0..STEPS {
            let before = joint.rms;
            if self.step(joint, damping)? {
                damping = (damping * 0.2).max(1e-9);
                if joint.rms > (1.0 - SETTLED) * before {
                    break;
                }
            } else {
                damping *= 10.0;
                if damping > 1e6 {
                    break;
                }
            }
        }
        Ok(())
    }

    /// One step; `false` if it led uphill and was not taken. Infinite damping holds the terms.
    fn step(&self, joint: &mut Joint, damping: f64) -> Result<bool, Error> {
        let weights = joint.weights.len();
        let free = if damping.is_finite() {
            joint.terms.numbers.len() + usize::from(self.with_beta)
        } else {
            0
        };
        let offsets = if self.runs.own_offsets {
            self.runs.runs.len()
        } else {
            1
        };
        // Columns: weights, terms and offsets (each split into two signs), what is to be met.
        let columns = weights + free + offsets;
        let mut triangle = Triangle::new(columns + 1);
        let scored: usize = self
            .runs
            .scored(Role::Fit)
            .map(|(_, _, span)| span.samples.len())
            .sum();
        let stride = scored.div_ceil(ROWS).max(1);
        for (i, run) in self.runs.runs.iter().enumerate() {
            let response = self.response(joint, run)?;
            let by_number = (0..free)
                .map(|j| {
                    let moved = self.moved(joint, j, 1e-4);
                    let other = self.displacement(&moved, run)?;
                    let pairs = other.iter().zip(&response.displacement);
                    Ok(pairs.map(|(a, b)| (a - b) / 1e-4).collect())
                })
                .collect::<Result<Vec<Vec<f64>>, Error>>()?;
            for span in run.scored(Role::Fit) {
                let weight = 1.0 / (span.samples.len().div_ceil(stride).max(1) as f64).sqrt();
                for k in span.samples.clone().step_by(stride) {
                    // The step is linear in the weights as a whole, not in their change.
                    let old = |j: usize| joint.weights[j] * response.by_weight[j][k];
                    let known: f64 = (0..weights).map(old).sum();
                    let target = run.displacement[k] - response.displacement[k] + known;
                    let row = (0..weights)
                        .map(|j| response.by_weight[j][k])
                        .chain((0..free).map(|j| by_number[j][k]))
                        .chain((0..offsets).map(|j| f64::from(offsets == 1 || j == i)))
                        .chain([target]);
                    triangle.push(weight, row);
                }
            }
        }
        let r = triangle.finish();
        let damped = damping.sqrt() * self.scale.displacement_um;
        let rows = columns + 1 + free;
        let mut a = nalgebra::DMatrix::zeros(rows, weights + 2 * (free + offsets));
        for row in 0..=columns {
            for j in 0..columns {
                let value = r[(row, j)];
                if j < weights {
                    a[(row, j)] = value;
                } else {
                    a[(row, 2 * j - weights)] = value;
                    a[(row, 2 * j - weights + 1)] = -value;
                }
            }
        }
        for j in 0..free {
            let row = columns + 1 + j;
            a[(row, weights + 2 * j)] = damped;
            a[(row, weights + 2 * j + 1)] = -damped;
        }
        let mut b = DVector::zeros(rows);
        b.rows_mut(0, columns + 1).copy_from(&r.column(columns));
        let x = non_negative(&a, &b);
        let mut next = joint.clone();
        next.weights = x[..weights].to_vec();
        let floor = 0.1 * self.runs.mean_gain();
        if let Some(first) = next.weights.first_mut() {
            *first = first.max(floor);
        }
        for j in 0..free {
            let change = x[weights + 2 * j] - x[weights + 2 * j + 1];
            next = self.moved(&next, j, change.clamp(-1.0, 1.0));
        }
        next.terms.limit(&self.scale);
        next.plays.beta = next.plays.beta.max(0.0);
        next.rms = self.rms(&next)?;
        let better = next.rms < joint.rms;
        if better {
            *joint = next;
        }
        Ok(better)
    }

    /// The model with one of its free numbers changed; beta comes last.
    fn moved(&self, joint: &Joint, number: usize, change: f64) -> Joint {
        let mut moved = joint.clone();
        match moved.terms.numbers.get_mut(number) {
            Some(value) => *value += change,
            None => {
                // Measured by the width that it gives the widest envelope.
                let unit = self.runs.widest_threshold() / self.runs.highest_rate();
                moved.plays.beta += change * unit;
            }
        }
        moved
    }

    /// Root of the mean over the fit records of their mean square residual, in um.
    pub fn rms(&self, joint: &Joint) -> Result<f64, Error> {
        let predicted = self
            .runs
            .runs
            .iter()
            .map(|run| self.displacement(joint, run))
            .collect::<Result<Vec<_>, _>>()?;
        let offsets = super::score::offsets(self.runs, &predicted);
        Ok(super::score::rms(self.runs, &predicted, &offsets, Role::Fit).unwrap_or(f64::INFINITY))
    }

    fn displacement(&self, joint: &Joint, run: &Run) -> Result<Vec<f64>, Error> {
        let effects = self.effects(joint, run)?;
        let plays = plays_along(joint, &effects, run);
        let w = weighted(joint, &plays);
        let bent = w.iter().map(|&w| bend(&effects, w).0).collect();
        let mut y = linear(&effects, bent);
        if let Some(map) = &effects.output_quadratic {
            y.iter_mut().for_each(|y| *y = map.step(*y));
        }
        Ok(y)
    }

    fn response(&self, joint: &Joint, run: &Run) -> Result<Response, Error> {
        let effects = self.effects(joint, run)?;
        let plays = plays_along(joint, &effects, run);
        let w = weighted(joint, &plays);
        let (bent, slopes): (Vec<f64>, Vec<f64>) = w.iter().map(|&w| bend(&effects, w)).unzip();
        let mut by_weight: Vec<Vec<f64>> = plays
            .iter()
            .map(|z| {
                let column = z.iter().zip(&slopes).map(|(z, slope)| z * slope).collect();
                linear(&effects, column)
            })
            .collect();
        let mut displacement = linear(&effects, bent);
        if let Some(map) = &effects.output_quadratic {
            for column in &mut by_weight {
                let at = column.iter_mut().zip(&displacement);
                at.for_each(|(d, &y)| *d *= map.slope(y));
            }
            displacement.iter_mut().for_each(|y| *y = map.step(*y));
        }
        Ok(Response {
            displacement,
            by_weight,
        })
    }

    fn effects(&self, joint: &Joint, run: &Run) -> Result<Effects<f64>, Error> {
        joint
            .terms
            .build(&self.scale, run.sample_time_s)
            .map_err(|refused| Error::request(format!("an effect of the fit: {refused}")))
    }
}

/// The drive as it reaches the actuator, and the plays that follow it, the drive first.
fn plays_along(joint: &Joint, effects: &Effects<f64>, run: &Run) -> Vec<Vec<f64>> {
    let mut at_actuator = run.clone();
    if let Some(lag) = &effects.amplifier_lag {
        let mut state = lag.start(run.drive[0]);
        for u in &mut at_actuator.drive {
            *u = lag.step(&mut state, *u);
        }
    }
    if let Some(delay) = &effects.transport_delay {
        let mut state = delay.start(run.drive[0]);
        for u in &mut at_actuator.drive {
            *u = delay.step(&mut state, *u);
        }
    }
    let run = &at_actuator;
    let mut columns = vec![run.drive.clone()];
    for &r in &joint.plays.thresholds {
        let mut z = run.start.play(run.drive[0], r).0;
        let follow = |z: &mut f64, k: usize| {
            let half_width = joint.plays.beta * run.rate(k) + r;
            let u = run.drive[k];
            *z = z.min(u + half_width).max(u - half_width);
            *z
        };
        if run.start == super::start::Start::Periodic {
            for k in 0..run.drive.len() {
                follow(&mut z, k);
            }
        }
        columns.push((0..run.drive.len()).map(|k| follow(&mut z, k)).collect());
    }
    columns
}

fn weighted(joint: &Joint, plays: &[Vec<f64>]) -> Vec<f64> {
    let samples = plays.first().map_or(0, Vec::len);
    let mut w = vec![0.0; samples];
    for (a, z) in joint.weights.iter().zip(plays) {
        w.iter_mut().zip(z).for_each(|(w, z)| *w += a * z);
    }
    w
}

/// The maps without memory, and their slope.
fn bend(effects: &Effects<f64>, w: f64) -> (f64, f64) {
    let (mut value, mut slope) = (w, 1.0);
    if let Some(map) = &effects.quadratic {
        slope *= map.slope(value);
        value = map.step(value);
    }
    if let Some(map) = &effects.cubic {
        slope *= map.slope(value);
        value = map.step(value);
    }
    (value, slope)
}

/// Modes and creep, from rest.
fn linear(effects: &Effects<f64>, mut signal: Vec<f64>) -> Vec<f64> {
    let Some(&first) = signal.first() else {
        return signal;
    };
    for mode in effects.resonances.iter().flatten() {
        let mut state = mode.start(first);
        for x in &mut signal {
            *x = mode.step(&mut state, *x);
        }
    }
    if let Some(creep) = &effects.creep {
        let mut state = creep.start(first);
        for x in &mut signal {
            *x = creep.step(&mut state, *x);
        }
    }
    signal
}
