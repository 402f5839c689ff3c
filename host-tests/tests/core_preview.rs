//! The preview inverse on plants that see the rate of their own drive.
//!
//! The plants are written here: plain loops over play operators, with nothing of the core in them.

use std::f64::consts::TAU;

use hysteron::error::{Field, ParameterError};
use hysteron::hysteresis::preview::{PreviewInverse, PreviewSettings, window_for};
use hysteron::hysteresis::{Parameters, RateDependentPi};

const N: usize = 16;
const WINDOW: usize = 256;

type Preview<const STAGES: usize> = PreviewInverse<f64, N, WINDOW, STAGES>;

/// What the plant's thresholds widen with.
#[derive(Clone, Copy, Debug)]
enum Rate {
    /// The step to come.
    Forward,
    /// The step that led to the sample, the drive joined by lines and stepped so many times finer.
    Backward(u32),
}

#[derive(Clone, Debug)]
struct Stage {
    weights: Vec<f64>,
    thresholds: Vec<f64>,
    beta: f64,
}

impl Stage {
    /// The published stage, corrected (paper J).
    fn p753() -> Self {
        Self {
            weights: vec![0.7236, 0.2906, 0.0416, 0.1512],
            thresholds: vec![9.715, 19.43, 29.145],
            beta: 8.572e-4,
        }
    }

    /// `n` plays over a range of 40 that make up a share of the gain 1.2.
    fn of(n: usize, beta: f64) -> Self {
        let mut weights = vec![0.7];
        weights.extend((0..n).map(|i| 0.5 * (1.0 + (i % 3) as f64) / (2.0 * n as f64)));
        Self {
            weights,
            thresholds: (1..=n).map(|i| 36.0 * i as f64 / (n + 1) as f64).collect(),
            beta,
        }
    }

    fn model(&self, sample_time: f64) -> RateDependentPi<f64, N> {
        Parameters {
            weights: &self.weights,
            thresholds: &self.thresholds,
            beta: self.beta,
        }
        .build(sample_time)
        .unwrap()
    }

    fn displacement(&self, drive: &[f64], sample_time: f64, rate: Rate) -> Vec<f64> {
        let mut plays = vec![0.0f64; self.thresholds.len()];
        let mut push = |u: f64, rate: f64| {
            for (z, r) in plays.iter_mut().zip(&self.thresholds) {
                let r = r + self.beta * rate;
                *z = z.min(u + r).max(u - r);
            }
            let weighted: f64 = plays
                .iter()
                .zip(&self.weights[1..])
                .map(|(z, a)| z * a)
                .sum();
            self.weights[0] * u + weighted
        };
        let step = |k: usize| (drive[k + 1] - drive[k]).abs() / sample_time;
        (0..drive.len())
            .map(|k| match rate {
                Rate::Forward if k + 1 < drive.len() => push(drive[k], step(k)),
                Rate::Forward => push(drive[k], 0.0),
                Rate::Backward(_) if k == 0 => push(drive[0], 0.0),
                Rate::Backward(fine) => {
                    let mut v = 0.0;
                    for i in 1..=fine {
                        let share = f64::from(i) / f64::from(fine);
                        v = push(
                            drive[k - 1] + (drive[k] - drive[k - 1]) * share,
                            step(k - 1),
                        );
                    }
                    v
                }
            })
            .collect()
    }
}

fn explicit(stage: &Stage, reference: &[f64], sample_time: f64) -> Vec<f64> {
    let inverse = stage.model(sample_time).inverse().unwrap();
    let mut state = inverse.start(reference[0]);
    reference
        .iter()
        .map(|&v| inverse.step(&mut state, v))
        .collect()
}

fn preview<const STAGES: usize>(
    stage: &Stage,
    reference: &[f64],
    sample_time: f64,
    correction: f64,
) -> Vec<f64> {
    let model = stage.model(sample_time);
    let preview = Preview::<STAGES>::new(
        &model,
        PreviewSettings {
            window: window_for(&model).min(WINDOW),
            sweeps: 3,
            correction,
        },
    )
    .unwrap();
    let mut state = Box::new(preview.start(reference[0]));
    let last = *reference.last().unwrap();
    let ahead = std::iter::repeat_n(last, preview.latency());
    reference
        .iter()
        .copied()
        .chain(ahead)
        .map(|v| preview.step(&mut state, v))
        .skip(preview.latency())
        .collect()
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    Sine,
    Triangle,
    TwoAmplitude,
    TwoTone,
    Multisine,
    Raster,
    ExampleF,
}

const SHAPES: [Shape; 7] = [
    Shape::Sine,
    Shape::Triangle,
    Shape::TwoAmplitude,
    Shape::TwoTone,
    Shape::Multisine,
    Shape::Raster,
    Shape::ExampleF,
];

/// Four periods, the samples shifted by a `phase` of the sample time.
fn reference(shape: Shape, frequency: f64, sample_time: f64, phase: f64) -> Vec<f64> {
    let samples = (4.0 / frequency / sample_time) as usize;
    (0..samples)
        .map(|k| {
            let turns = (k as f64 + phase) * sample_time * frequency;
            let part = turns.fract();
            let sine = |harmonic: f64| (TAU * harmonic * turns).sin();
            match shape {
                Shape::Sine => 40.0 * sine(1.0),
                Shape::Triangle => 40.0 * (4.0 * (0.25 - (part - 0.5).abs()).abs() - 1.0).abs(),
                Shape::TwoAmplitude => (if turns % 2.0 < 1.0 { 40.0 } else { 20.0 }) * sine(1.0),
                Shape::TwoTone => 20.0 * sine(1.0) + 18.0 * sine(5.461_538),
                Shape::Multisine => {
                    let tone = |q: i32| {
                        let start = f64::from(q * q) * std::f64::consts::PI / 8.0;
                        (TAU * f64::from(q) * turns + start).sin()
                    };
                    8.0 * (1..8).map(tone).sum::<f64>()
                }
                Shape::Raster if part < 0.9 => 40.0 * (2.0 * part / 0.9 - 1.0),
                Shape::Raster => 40.0 * (1.0 - 20.0 * (part - 0.9)),
                Shape::ExampleF => 22.0 * sine(1.0) + 25.0 * sine(3.0),
            }
        })
        .collect()
}

/// Largest and rms error without the first period and the last 5 ms.
fn errors(reference: &[f64], displacement: &[f64], sample_time: f64) -> (f64, f64) {
    let tail = (0.005 / sample_time).round() as usize;
    let kept = reference.len() / 4..reference.len() - tail;
    let count = kept.len() as f64;
    let (mut largest, mut squares) = (0.0f64, 0.0);
    for k in kept {
        let error = (displacement[k] - reference[k]).abs();
        largest = largest.max(error);
        squares += error * error;
    }
    (largest, (squares / count).sqrt())
}

/// Worst largest and rms error over ten sampling phases.
fn worst(frequency: f64, rate: Rate, drive: impl Fn(&[f64]) -> Vec<f64>) -> (f64, f64) {
    let stage = Stage::p753();
    (0..10).fold((0.0f64, 0.0f64), |worst, phase| {
        let reference = reference(Shape::Sine, frequency, 1e-4, f64::from(phase) / 10.0);
        let displacement = stage.displacement(&drive(&reference), 1e-4, rate);
        let (largest, rms) = errors(&reference, &displacement, 1e-4);
        (worst.0.max(largest), worst.1.max(rms))
    })
}

#[test]
fn the_published_stage_with_the_rate_of_its_own_drive() {
    let stage = Stage::p753();
    for (frequency, forward_limit, backward_limit) in [(50.0, 1e-4, 0.2), (100.0, 1e-4, 0.5)] {
        let forward = worst(frequency, Rate::Forward, |v| {
            preview::<1>(&stage, v, 1e-4, 0.0)
        });
        let without = worst(frequency, Rate::Forward, |v| explicit(&stage, v, 1e-4));
        println!("{frequency} Hz, step to come: explicit {without:.4?}, preview {forward:.6?}");
        assert!(forward.0 < forward_limit, "{forward:?}");
        for fine in [1, 20] {
            let rate = Rate::Backward(fine);
            let line = worst(frequency, rate, |v| preview::<2>(&stage, v, 1e-4, 1.0));
            let third = worst(frequency, rate, |v| {
                preview::<2>(&stage, v, 1e-4, 1.0 / 3.0)
            });
            let without = worst(frequency, rate, |v| explicit(&stage, v, 1e-4));
            println!(
                "{frequency} Hz, {fine} times finer: explicit {without:.4?}, preview {line:.4?}, a third corrected {third:.4?}"
            );
            assert!(line.0 < backward_limit && line.1 < 0.1, "{line:?}");
        }
    }
}

#[test]
fn never_worse_than_the_explicit_inverse() {
    let (mut compared, mut worse) = (0, 0);
    for (n, beta) in [
        (1, 8e-4),
        (3, 0.0),
        (3, 1e-4),
        (5, 3e-3),
        (10, 7e-4),
        (16, 1.5e-3),
    ] {
        let stage = Stage::of(n, beta);
        for sample_rate in [5e3, 1e4, 2e4, 5e4] {
            let sample_time = 1.0 / sample_rate;
            for shape in SHAPES {
                for frequency in [10.0, 40.0, 100.0, 200.0] {
                    // Seven periods of harmonics need samples, too.
                    if frequency > sample_rate / 100.0 || frequency < sample_rate / 2e3 {
                        continue;
                    }
                    for phase in [0.0, 0.37, 0.8] {
                        let reference = reference(shape, frequency, sample_time, phase);
                        let explicit = explicit(&stage, &reference, sample_time);
                        let forward = preview::<1>(&stage, &reference, sample_time, 0.0);
                        let backward = preview::<2>(&stage, &reference, sample_time, 1.0);
                        for (rate, drive) in [
                            (Rate::Forward, &forward),
                            (Rate::Backward(1), &backward),
                            (Rate::Backward(20), &backward),
                        ] {
                            let error = |drive: &[f64]| {
                                let out = stage.displacement(drive, sample_time, rate);
                                errors(&reference, &out, sample_time)
                            };
                            let (with, without) = (error(drive), error(&explicit));
                            compared += 1;
                            if with.0 > without.0 + 1e-6 || with.1 > without.1 + 1e-6 {
                                println!(
                                    "n = {n}, beta = {beta}, {sample_rate} Hz, {shape:?} \
                                     {frequency} Hz, phase {phase}, {rate:?}: preview {with:.5?}, \
                                     explicit {without:.5?}"
                                );
                                worse += 1;
                            }
                        }
                    }
                }
            }
        }
    }
    println!("{compared} comparisons");
    assert_eq!(worse, 0);
}

#[test]
fn without_a_rate_term_it_is_the_explicit_inverse() {
    let stage = Stage::of(7, 0.0);
    let reference = reference(Shape::TwoTone, 13.0, 1e-4, 0.3);
    let with = preview::<1>(&stage, &reference, 1e-4, 0.0);
    for (a, b) in with.iter().zip(explicit(&stage, &reference, 1e-4)) {
        assert!((a - b).abs() < 1e-12);
    }
}

#[test]
fn refuses_what_has_no_preview_inverse() {
    let settings = PreviewSettings {
        window: 16,
        sweeps: 1,
        correction: 0.0,
    };
    let model = Stage::p753().model(1e-4);
    for wrong in [
        PreviewSettings {
            window: 1,
            ..settings
        },
        PreviewSettings {
            window: WINDOW + 1,
            ..settings
        },
        PreviewSettings {
            sweeps: 0,
            ..settings
        },
    ] {
        let refused = Preview::<1>::new(&model, wrong);
        assert_eq!(refused.unwrap_err(), ParameterError::Length(Field::Preview));
    }
    for correction in [-0.1, 1.1, f64::NAN] {
        assert!(
            Preview::<1>::new(
                &model,
                PreviewSettings {
                    correction,
                    ..settings
                }
            )
            .is_err()
        );
    }
    // A_1 = 0.5 a_0: well-posed while beta < h (P 4).
    let falling = |beta| Stage {
        weights: vec![1.0, -0.5],
        thresholds: vec![5.0],
        beta,
    };
    assert!(Preview::<1>::new(&falling(0.99e-4).model(1e-4), settings).is_ok());
    assert_eq!(
        Preview::<1>::new(&falling(1.01e-4).model(1e-4), settings).unwrap_err(),
        ParameterError::RateTooStrong(1)
    );
}
