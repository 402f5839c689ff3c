//! What a model with effects makes of a run, and its derivatives by the weights.
//!
//! The same blocks as in [`hysteron::chain::Chain`], walked through by whole signals: what comes before
//! the plays once, what comes behind them for the displacement and for each derivative. A test holds
//! the result against the chain of the core.

use std::iter;

use hysteron::play::{Envelope, play};

use super::super::start::Start;
use super::blocks::Blocks;
use super::bouc_wen::{Element, Moving};
use super::frame::Frame;

/// The hysteresis: thresholds in volts, weights in um/V.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Core {
    /// `alpha_1..alpha_n` in volts, increasing.
    pub thresholds: Vec<f64>,
    /// `a_0..a_n` in um/V, then the weights of the elements.
    pub weights: Vec<f64>,
    /// Rate coefficient in seconds.
    pub beta: f64,
    /// What is no play.
    pub elements: Vec<Element>,
}

/// Rows of derivatives by the weights: of every sample, or where nothing behind the hysteresis
/// remembers, only of those samples that are rows of the least squares.
#[derive(Clone, Default)]
pub struct Columns {
    entries: Vec<f64>,
    /// Entries of a row.
    width: usize,
    /// The samples that have a row, if not all.
    samples: Option<Vec<usize>>,
}

/// The drive as it reaches the actuator.
pub fn at_actuator(blocks: &Blocks, frame: &Frame<'_>) -> Vec<f64> {
    let effects = &blocks.effects;
    let mut drive = frame.run.drive.clone();
    if let Some(saturation) = &effects.saturation {
        drive.iter_mut().for_each(|u| *u = saturation.step(*u));
    }
    if let Some(slew) = &effects.slew_limit {
        through(&mut drive, |u| slew.start(u), |s, u| slew.step(s, u));
    }
    if let Some(lag) = &effects.amplifier_lag {
        through(&mut drive, |u| lag.start(u), |s, u| lag.step(s, u));
    }
    if let Some(delay) = &effects.transport_delay {
        through(&mut drive, |u| delay.start(u), |s, u| delay.step(s, u));
    }
    drive
}

/// Plays that are moved together.
const LANES: usize = 8;

/// The plays of a core, filled up to whole lanes with plays that never move, and its elements.
struct Bank {
    lanes: Vec<Lane>,
    plays: usize,
    elements: Moving,
}

#[derive(Clone, Copy)]
struct Lane {
    thresholds: [f64; LANES],
    weights: [f64; LANES],
    outputs: [f64; LANES],
}

impl Bank {
    fn new(core: &Core, first_v: f64) -> Self {
        let idle = Lane {
            thresholds: [f64::INFINITY; LANES],
            weights: [0.0; LANES],
            outputs: [0.0; LANES],
        };
        let plays = core.thresholds.len();
        let mut lanes = vec![idle; plays.div_ceil(LANES)];
        let weights = core.weights.iter().skip(1);
        for (i, (&r, &a)) in core.thresholds.iter().zip(weights).enumerate() {
            lanes[i / LANES].thresholds[i % LANES] = r;
            lanes[i / LANES].weights[i % LANES] = a;
        }
        let weights = core.weights.get(plays + 1..).unwrap_or_default();
        Self {
            lanes,
            plays,
            elements: Moving::new(&core.elements, weights, first_v),
        }
    }

    /// Goes on from where a bank was left.
    fn set(&mut self, mut state: impl Iterator<Item = f64>) {
        self.set_plays(state.by_ref().take(self.plays));
        self.elements.set(state);
    }

    fn set_plays(&mut self, outputs: impl Iterator<Item = f64>) {
        for (i, z) in outputs.enumerate() {
            self.lanes[i / LANES].outputs[i % LANES] = z;
        }
    }

    fn state(&self) -> impl Iterator<Item = f64> {
        self.plays().chain(self.elements.state())
    }

    fn plays(&self) -> impl Iterator<Item = f64> {
        let all = self.lanes.iter().flat_map(|lane| lane.outputs);
        all.take(self.plays)
    }

    fn outputs(&self) -> impl Iterator<Item = f64> {
        self.plays().chain(self.elements.outputs())
    }

    #[inline]
    fn step(&mut self, drive_v: f64, envelope: Envelope<f64>) {
        self.elements.step(drive_v, envelope);
        for lane in &mut self.lanes {
            for (z, r) in lane.outputs.iter_mut().zip(lane.thresholds) {
                *z = play(*z, envelope, r);
            }
        }
    }

    /// Sum of all with their weights.
    #[inline]
    fn sum(&self) -> f64 {
        let mut sums = [0.0; LANES];
        for lane in &self.lanes {
            for (sum, (a, z)) in sums.iter_mut().zip(lane.weights.iter().zip(&lane.outputs)) {
                *sum += a * z;
            }
        }
        sums.iter().sum::<f64>() + self.elements.sum()
    }
}

/// Walks the plays along a drive and hands out drive and plays at every sample. `plays` are
/// those at the end of the run before, and become those at the end of this one.
fn walk(
    core: &Core,
    blocks: &Blocks,
    frame: &Frame<'_>,
    drive: &[f64],
    plays: &mut Vec<f64>,
    mut each: impl FnMut(f64, &Bank),
) {
    let Some(&first) = drive.first() else {
        return;
    };
    let start = frame.run.start;
    let mut bank = Bank::new(core, first);
    if start == Start::Carried && !plays.is_empty() {
        bank.set(plays.iter().copied());
    } else {
        bank.set_plays(core.thresholds.iter().map(|&r| start.play(first, r).0));
    }
    let per_step = 1.0 / frame.run.sample_time_s;
    let law = |rate: f64| match &blocks.effects.rate_law {
        _ if core.beta == 0.0 => 0.0,
        Some(power) => core.beta * power.step(rate),
        None => core.beta * rate,
    };
    let mut before = frame.before(drive);
    let rounds = if start == Start::Periodic { 2 } else { 1 };
    for round in 1..=rounds {
        for &u in drive {
            let half_width = law((u - before).abs() * per_step);
            before = u;
            bank.step(
                u,
                Envelope {
                    lo: u - half_width,
                    hi: u + half_width,
                },
            );
            if round == rounds {
                each(u, &bank);
            }
        }
    }
    plays.clear();
    plays.extend(bank.state());
}

/// Output of the hysteresis in um.
pub fn hysteresis(
    core: &Core,
    blocks: &Blocks,
    frame: &Frame<'_>,
    drive: &[f64],
    plays: &mut Vec<f64>,
) -> Vec<f64> {
    let direct = core.direct();
    let mut w = Vec::with_capacity(frame.run.drive.len());
    walk(core, blocks, frame, drive, plays, |u, bank| {
        w.push(match &blocks.effects.congruency {
            Some(law) => law.step(direct * u, bank.sum()),
            None => direct * u + bank.sum(),
        });
    });
    w
}

/// As [`hysteresis`], with its derivatives by the weights.
pub fn hysteresis_and_columns(
    core: &Core,
    blocks: &Blocks,
    frame: &Frame<'_>,
    drive: &[f64],
    plays: &mut Vec<f64>,
) -> (Vec<f64>, Columns) {
    let direct = core.direct();
    let width = core.weights.len();
    let samples = (!blocks.remember_behind())
        .then(|| frame.rows.iter().map(|&(k, _)| k).collect::<Vec<usize>>());
    let rows = samples.as_ref().map_or(drive.len(), Vec::len);
    let mut wanted = samples.iter().flatten().copied().peekable();
    let mut w = Vec::with_capacity(drive.len());
    let mut entries = Vec::with_capacity(rows * width);
    walk(core, blocks, frame, drive, plays, |u, bank| {
        let (direct, plays) = (direct * u, bank.sum());
        let (mut by_direct, mut by_plays) = (1.0, 1.0);
        w.push(match &blocks.effects.congruency {
            Some(law) => {
                let at = law.step(direct, plays);
                // The law is smooth; its slopes are needed to a few digits only.
                let step = 1e-6 * (1.0 + direct.abs().max(plays.abs()));
                by_direct = (law.step(direct + step, plays) - at) / step;
                by_plays = (law.step(direct, plays + step) - at) / step;
                at
            }
            None => direct + plays,
        });
        if samples.is_none() || wanted.next_if_eq(&(w.len() - 1)).is_some() {
            entries.push(u * by_direct);
            entries.extend(bank.outputs().map(|z| z * by_plays));
        }
    });
    let columns = Columns {
        entries,
        width,
        samples,
    };
    (w, columns)
}

impl Core {
    fn direct(&self) -> f64 {
        self.weights.first().copied().unwrap_or_default()
    }

    /// How many of the weights are those of the drive and the plays.
    fn split(&self) -> usize {
        self.thresholds.len() + 1
    }

    /// Without the plays and elements that have no weight.
    pub fn active(&self) -> Self {
        let weights = |from: usize| self.weights.iter().skip(from).copied();
        let (thresholds, of_plays): (Vec<f64>, Vec<f64>) = self
            .thresholds
            .iter()
            .zip(weights(1))
            .filter(|&(_, a)| a != 0.0)
            .unzip();
        let (elements, of_elements): (Vec<Element>, Vec<f64>) = self
            .elements
            .iter()
            .zip(weights(self.split()))
            .filter(|&(_, a)| a != 0.0)
            .unzip();
        let direct = iter::once(self.direct());
        Self {
            thresholds,
            weights: direct.chain(of_plays).chain(of_elements).collect(),
            beta: self.beta,
            elements,
        }
    }

    /// The same among the plays and elements of another one; those that it does not have get no weight.
    pub fn among(&self, all: &Self) -> Self {
        let weight = |place: Option<usize>, from: usize| {
            let found = place.and_then(|i| self.weights.get(from + i));
            found.copied().unwrap_or(0.0)
        };
        let plays = all
            .thresholds
            .iter()
            .map(|r| weight(self.thresholds.iter().position(|mine| mine == r), 1));
        let elements = all.elements.iter().map(|e| {
            let place = self.elements.iter().position(|mine| mine == e);
            weight(place, self.split())
        });
        Self {
            thresholds: all.thresholds.clone(),
            weights: iter::once(self.direct())
                .chain(plays)
                .chain(elements)
                .collect(),
            beta: self.beta,
            elements: all.elements.clone(),
        }
    }
}

impl Columns {
    /// Derivatives at the sample `k`, which is that of row `index` of the least squares.
    pub fn of_row(&self, index: usize, k: usize) -> &[f64] {
        self.entry(if self.samples.is_some() { index } else { k })
    }

    fn entry(&self, index: usize) -> &[f64] {
        self.entries
            .get(index * self.width..(index + 1) * self.width)
            .unwrap_or_default()
    }

    /// Through a block that each column has a state of.
    fn through<S>(&mut self, start: impl Fn(f64) -> S, step: impl Fn(&mut S, f64) -> f64) {
        let mut states: Vec<S> = self.entry(0).iter().map(|&d| start(d)).collect();
        for row in self.entries.chunks_exact_mut(self.width.max(1)) {
            for (d, state) in row.iter_mut().zip(&mut states) {
                *d = step(state, *d);
            }
        }
    }

    /// Multiplies each row by the slope at its sample.
    fn scale(&mut self, slope: impl Fn(usize) -> f64) {
        let rows = self.entries.chunks_exact_mut(self.width.max(1));
        for (index, row) in rows.enumerate() {
            let sample = self
                .samples
                .as_ref()
                .map_or(Some(index), |samples| samples.get(index).copied());
            let slope = sample.map_or(0.0, &slope);
            row.iter_mut().for_each(|d| *d *= slope);
        }
    }
}

/// A signal through a block.
fn through<S>(signal: &mut [f64], start: impl Fn(f64) -> S, step: impl Fn(&mut S, f64) -> f64) {
    if let Some(&first) = signal.first() {
        let mut state = start(first);
        signal.iter_mut().for_each(|x| *x = step(&mut state, *x));
    }
}

/// Displacement in um, less the offset, from the output `w` of the hysteresis in um; `columns`, the
/// derivatives of `w`, become those of the displacement. `gap` is what was behind the backlash at the end
/// of the run before, and becomes that at the end of this one.
pub fn behind(
    blocks: &Blocks,
    frame: &Frame<'_>,
    mut w: Vec<f64>,
    columns: &mut Columns,
    gap: &mut Option<f64>,
) -> Vec<f64> {
    let effects = &blocks.effects;
    bend(blocks, &mut w, columns);
    if let Some(backlash) = &effects.backlash {
        let before = w.clone();
        let first = w.first().copied().unwrap_or_default();
        let mut state = backlash.start(match frame.run.start {
            Start::Zero => 0.0,
            Start::Carried => gap.unwrap_or(first),
            _ => first,
        });
        w.iter_mut()
            .for_each(|w| *w = backlash.step(&mut state, *w));
        *gap = w.last().copied();
        // The derivative stands where the output does.
        let moves: Vec<bool> = (0..w.len())
            .map(|k| k == 0 || (w[k] != w[k - 1] && before[k] != before[k - 1]))
            .collect();
        let mut held = columns.entry(0).to_vec();
        for (row, moves) in columns
            .entries
            .chunks_exact_mut(columns.width.max(1))
            .zip(moves)
        {
            if moves {
                held.copy_from_slice(row);
            } else {
                row.copy_from_slice(&held);
            }
        }
    }
    for mode in effects.resonances.iter().flatten() {
        through(&mut w, |x| mode.start(x), |s, x| mode.step(s, x));
        columns.through(|x| mode.start(x), |s, x| mode.step(s, x));
    }
    if let Some(creep) = &effects.creep {
        through(&mut w, |x| creep.start(x), |s, x| creep.step(s, x));
        columns.through(|x| creep.start(x), |s, x| creep.step(s, x));
    }
    if let Some(map) = &effects.output_quadratic {
        columns.scale(|k| w.get(k).map_or(0.0, |&w| map.slope(w)));
        w.iter_mut().for_each(|w| *w = map.step(*w));
    }
    if let Some(interleaving) = &effects.interleaving {
        let drive = &frame.run.drive;
        let along = |signal: &mut dyn Iterator<Item = &mut f64>| {
            let mut state = None;
            for (x, &u) in signal.zip(drive) {
                let state = state.get_or_insert_with(|| interleaving.start(*x, u));
                *x = interleaving.step(state, *x, u);
            }
        };
        along(&mut w.iter_mut());
        for j in 0..columns.width {
            along(&mut columns.entries.iter_mut().skip(j).step_by(columns.width));
        }
    }
    if let Some(lag) = &effects.sensor_lag {
        through(&mut w, |x| lag.start(x), |s, x| lag.step(s, x));
        columns.through(|x| lag.start(x), |s, x| lag.step(s, x));
    }
    let time = |k: usize| frame.run.start_s + k as f64 * frame.run.sample_time_s;
    if let Some(drift) = &effects.drift {
        w.iter_mut()
            .enumerate()
            .for_each(|(k, y)| *y += drift.at(time(k)));
    }
    if let Some(hum) = &effects.mains_hum {
        w.iter_mut()
            .enumerate()
            .for_each(|(k, y)| *y += hum.at(time(k)));
    }
    w
}

/// The maps without memory.
fn bend(blocks: &Blocks, w: &mut [f64], columns: &mut Columns) {
    let effects = &blocks.effects;
    if blocks.asymmetry.is_none() && effects.quadratic.is_none() && effects.cubic.is_none() {
        return;
    }
    let mut slopes = Vec::with_capacity(w.len());
    for w in w.iter_mut() {
        let mut slope = 1.0;
        if let Some(map) = &blocks.asymmetry {
            let step = 1e-6 * (1.0 + w.abs());
            slope *= (map.step(*w + step) - map.step(*w)) / step;
            *w = map.step(*w);
        }
        if let Some(map) = &effects.quadratic {
            slope *= map.slope(*w);
            *w = map.step(*w);
        }
        if let Some(map) = &effects.cubic {
            slope *= map.slope(*w);
            *w = map.step(*w);
        }
        slopes.push(slope);
    }
    columns.scale(|k| slopes.get(k).copied().unwrap_or(0.0));
}
