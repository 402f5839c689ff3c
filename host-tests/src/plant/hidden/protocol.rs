//! What is recorded: drives in units of half the drive's range around its middle.

use std::f64::consts::TAU;
use std::str::FromStr;

use crate::dataset::Role;
use crate::error::{Error, quoted};

use super::draw::{Draw, Stream};
use super::setup::Setup;

/// A set of records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Protocol {
    /// Records able to show every effect.
    #[default]
    Full,
    /// Sines of several frequencies and amplitudes, and rest.
    Sines,
    /// Slow loops, minor loops, stairs, a ramp, and rest.
    Slow,
    /// Drives of filtered noise, and rest.
    Random,
}

impl Protocol {
    /// The name on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Sines => "sines",
            Self::Slow => "slow",
            Self::Random => "random",
        }
    }
}

impl FromStr for Protocol {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        [Self::Full, Self::Sines, Self::Slow, Self::Random]
            .into_iter()
            .find(|protocol| protocol.name() == text)
            .ok_or_else(|| {
                Error::request(format!(
                    "{} is no protocol; name full, sines, slow or random",
                    quoted(text)
                ))
            })
    }
}

/// A planned record.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    pub(super) name: String,
    pub(super) role: Role,
    pub(super) start_s: f64,
    pub(super) sample_time_s: f64,
    /// Drive in V.
    pub(super) drive_v: Vec<f64>,
}

/// A drive with its name.
#[derive(Clone, Copy, Debug)]
enum Move {
    Rest,
    /// Two cycles of the first amplitude, then one each of the others.
    Loops([f64; 4]),
    /// Two small cycles of this amplitude at each of five biases.
    Minor(f64),
    /// Frequency as a share of the top one, amplitude.
    Sine(f64, f64),
    /// Peak.
    Multisine(f64),
    /// Levels on the way up, largest level.
    Stairs(usize, f64),
    /// Cycles of falling amplitude.
    Ladder(f64),
    Ramp(f64),
    Triangle(f64),
    /// Bandwidth as a share of the top frequency, peak.
    Noise(f64, f64),
}

use Move::*;

impl Move {
    fn name(self) -> &'static str {
        match self {
            Rest => "rest",
            Loops(_) => "loops",
            Minor(_) => "minor-loops",
            Sine(..) => "sine",
            Multisine(_) => "multisine",
            Stairs(..) => "stairs",
            Ladder(_) => "ladder",
            Ramp(_) => "ramp",
            Triangle(_) => "triangle",
            Noise(..) => "noise",
        }
    }

    /// Samples a second, a divisor of the highest rate, and the drive.
    fn samples(self, setup: &Setup, draw: &mut Draw) -> (f64, Vec<f64>) {
        let divided = |hz: f64| setup.sample_rate_hz / (setup.sample_rate_hz / hz).floor().max(1.0);
        let (slow_hz, top_hz) = (setup.slow_hz, setup.top_hz);
        match self {
            Rest => (divided(1000.0), vec![draw.uniform(-0.2, 0.2); 400]),
            Loops([first, rest @ ..]) => {
                let rate = divided(400.0 * slow_hz);
                let cycles = [&[first, first], rest.as_slice()].concat();
                (rate, sines(rate, &cycles, slow_hz))
            }
            Minor(amplitude) => {
                let rate = divided(400.0 * slow_hz);
                let biases = [-0.6, -0.3, 0.0, 0.3, 0.6];
                (rate, minor(rate, amplitude, &biases, 2.0 * slow_hz))
            }
            Sine(share, amplitude) => {
                let hz = share * top_hz;
                let rate = divided(250.0 * hz);
                let cycles = (600.0 * hz / rate).ceil().max(3.0) as usize;
                (rate, sines(rate, &vec![amplitude; cycles], hz))
            }
            Multisine(peak) => {
                let rate = divided(20.0 * top_hz);
                (rate, multisine(rate, top_hz, peak, draw))
            }
            Stairs(levels, most) => (divided(180.0), stairs(levels, most)),
            Ladder(most) => {
                let rate = divided(125.0 * 4.0 * slow_hz);
                let amplitudes: Vec<f64> = (0..12)
                    .map(|i| most * (1.0 - f64::from(i) / 12.0))
                    .collect();
                (rate, sines(rate, &amplitudes, 4.0 * slow_hz))
            }
            Ramp(most) => {
                let up = |k: i32| most * (f64::from(k) / 500.0 - 1.0);
                (divided(100.0), (0..=1000).map(up).collect())
            }
            Triangle(amplitude) => {
                let wave = |k: i32| {
                    let at = f64::from(k) / 250.0;
                    amplitude * (1.0 - (at - 4.0 * (at / 4.0 + 0.25).floor() - 1.0).abs())
                };
                (divided(2000.0 * slow_hz), (0..=2000).map(wave).collect())
            }
            Noise(share, peak) => {
                let rate = divided(25.0 * share * top_hz);
                (rate, noise(rate, share * top_hz, peak, draw))
            }
        }
    }
}

/// A cycle of each amplitude.
fn sines(rate: f64, amplitudes: &[f64], hz: f64) -> Vec<f64> {
    let count = (amplitudes.len() as f64 * rate / hz).round() as usize;
    (0..=count)
        .map(|k| {
            let cycles = k as f64 * hz / rate;
            let amplitude = amplitudes[(cycles as usize).min(amplitudes.len() - 1)];
            amplitude * (TAU * cycles).sin()
        })
        .collect()
}

/// From bias to bias along half a cosine, with two cycles of a sine at each.
fn minor(rate: f64, amplitude: f64, biases: &[f64], hz: f64) -> Vec<f64> {
    let period = rate / hz;
    let mut drive = Vec::new();
    let mut from = -0.85;
    for &bias in biases {
        let way = (period / 2.0) as usize;
        drive.extend((0..way).map(|k| {
            let share = 0.5 - 0.5 * (0.5 * TAU * k as f64 / way as f64).cos();
            from + (bias - from) * share
        }));
        let loops = (2.0 * period) as usize;
        drive.extend((0..loops).map(|k| bias + amplitude * (TAU * k as f64 / period).sin()));
        from = bias;
    }
    drive
}

/// Two periods of 2048 samples. Even lines are left empty and so is one of three odd ones.
fn multisine(rate: f64, top_hz: f64, peak: f64, draw: &mut Draw) -> Vec<f64> {
    const PERIOD: usize = 2048;
    let base_hz = rate / PERIOD as f64;
    let lines = (top_hz / base_hz) as usize;
    let odd: Vec<usize> = (1..=lines).step_by(2).collect();
    let mut period = vec![0.0; PERIOD];
    for three in odd.chunks(3) {
        let empty = draw.whole(0, 2);
        for (_, &line) in three.iter().enumerate().filter(|&(i, _)| i != empty) {
            let phase = draw.uniform(0.0, 1.0);
            for (k, sum) in period.iter_mut().enumerate() {
                let at = ((line * k) % PERIOD) as f64 / PERIOD as f64;
                *sum += (TAU * (at + phase)).sin() / (line as f64).sqrt();
            }
        }
    }
    to_peak(&mut period, peak);
    period.repeat(2)
}

/// Up and down with a hold on each level and eight samples between levels.
fn stairs(levels: usize, most: f64) -> Vec<f64> {
    let hold = 1500 / (2 * levels);
    let height = |i: usize| most * (2.0 * i as f64 / levels as f64 - 1.0);
    let mut drive = vec![height(0); hold];
    let mut from = height(0);
    for to in (1..=levels).chain((0..levels).rev()).map(height) {
        drive.extend((1..=8).map(|k| from + (to - from) * f64::from(k) / 8.0));
        drive.extend(std::iter::repeat_n(to, hold));
        from = to;
    }
    drive
}

/// Normal noise behind two first-order lags.
fn noise(rate: f64, hz: f64, peak: f64, draw: &mut Draw) -> Vec<f64> {
    let share = -(-TAU * hz / 2.0 / rate).exp_m1();
    let (mut first, mut second) = (0.0, 0.0);
    let mut drive: Vec<f64> = (0..2500)
        .map(|_| {
            first += share * (draw.normal() - first);
            second += share * (first - second);
            second
        })
        .collect();
    to_peak(&mut drive, peak);
    drive
}

fn to_peak(signal: &mut [f64], peak: f64) {
    let most = signal.iter().fold(f64::MIN_POSITIVE, |a, b| b.abs().max(a));
    signal.iter_mut().for_each(|x| *x *= peak / most);
}

fn moves(protocol: Protocol) -> Vec<(Role, Move)> {
    let of = |role: Role, moves: &[Move]| -> Vec<(Role, Move)> {
        moves.iter().map(|&one| (role, one)).collect()
    };
    let (fit, select, report): (&[Move], &[Move], &[Move]) = match protocol {
        Protocol::Full => (
            &[
                Rest,
                Loops([0.85, 0.85, 0.5, 0.25]),
                Minor(0.2),
                Sine(0.01, 0.8),
                Sine(0.03, 0.8),
                Sine(0.1, 0.8),
                Sine(0.3, 0.7),
                Sine(1.0, 0.5),
                Multisine(0.6),
                Stairs(5, 0.8),
                Sine(0.1, 1.0),
                Ladder(0.8),
                Ramp(0.5),
                Rest,
            ],
            &[
                Loops([0.7, 0.7, 0.4, 0.2]),
                Minor(0.15),
                Sine(0.02, 0.6),
                Sine(0.2, 0.6),
                Sine(0.7, 0.6),
                Multisine(0.5),
                Stairs(4, 0.6),
                Sine(0.15, 1.0),
                Rest,
            ],
            &[
                Triangle(0.75),
                Minor(0.25),
                Sine(0.05, 0.7),
                Sine(0.5, 0.6),
                Sine(0.07, 1.0),
                Multisine(0.55),
                Stairs(6, 0.7),
                Ladder(0.6),
                Rest,
            ],
        ),
        Protocol::Sines => (
            &[
                Rest,
                Sine(0.01, 0.9),
                Sine(0.01, 0.4),
                Sine(0.03, 0.8),
                Sine(0.03, 0.3),
                Sine(0.1, 0.9),
                Sine(0.1, 0.5),
                Sine(0.3, 0.7),
                Sine(0.3, 0.2),
                Sine(0.6, 0.6),
                Sine(1.0, 0.5),
                Rest,
            ],
            &[
                Sine(0.02, 0.7),
                Sine(0.07, 0.6),
                Sine(0.4, 0.6),
                Sine(0.8, 0.4),
                Rest,
            ],
            &[
                Sine(0.015, 0.6),
                Sine(0.05, 0.8),
                Sine(0.2, 0.5),
                Sine(0.7, 0.5),
                Rest,
            ],
        ),
        Protocol::Slow => (
            &[
                Rest,
                Loops([0.9, 0.9, 0.6, 0.3]),
                Minor(0.2),
                Stairs(6, 0.8),
                Ramp(0.7),
                Ladder(0.9),
                Rest,
            ],
            &[
                Loops([0.75, 0.75, 0.45, 0.2]),
                Minor(0.15),
                Stairs(4, 0.6),
                Rest,
            ],
            &[Triangle(0.8), Minor(0.25), Stairs(5, 0.7), Rest],
        ),
        Protocol::Random => (
            &[
                Rest,
                Noise(0.02, 0.9),
                Noise(0.1, 0.9),
                Noise(0.3, 0.7),
                Noise(1.0, 0.6),
                Noise(0.1, 0.4),
                Rest,
            ],
            &[Noise(0.05, 0.8), Noise(0.5, 0.7), Rest],
            &[Noise(0.03, 0.8), Noise(0.7, 0.6), Rest],
        ),
    };
    [
        of(Role::Fit, fit),
        of(Role::Select, select),
        of(Role::Report, report),
    ]
    .concat()
}

/// The records of a session, one after the other with pauses between them.
pub(super) fn plan(protocol: Protocol, setup: &Setup, seed: u64) -> Vec<Plan> {
    let mut draw = Draw::new(seed, Stream::Protocol, 0);
    let mut start_s = 0.0;
    moves(protocol)
        .into_iter()
        .enumerate()
        .map(|(index, (role, kind))| {
            let (rate, unit) = kind.samples(setup, &mut draw);
            let sample_time_s = 1.0 / rate;
            let drive_v = unit
                .iter()
                .map(|x| setup.middle_v() + setup.half_v() * x)
                .collect::<Vec<_>>();
            let planned = Plan {
                name: format!("{:02}-{}", index + 1, kind.name()),
                role,
                start_s,
                sample_time_s,
                drive_v,
            };
            let pause_s = draw.uniform(0.3, 2.0);
            let end_s = start_s + unit.len() as f64 * sample_time_s + pause_s;
            start_s = (end_s * 1e3).round() / 1e3;
            planned
        })
        .collect()
}
