//! The preview inverse on plants that see the rate of their own drive.
//!
//! The plants are written here: plain loops over play operators, with nothing of the core in them.

use std::f64::consts::TAU;

use hysteron::effect::asymmetry::{Asymmetry, Side};
use hysteron::error::{Field, ParameterError, SampleError};
use hysteron::hysteresis::preview::{PlantRate, PreviewInverse, PreviewSettings, window_for};
use hysteron::hysteresis::{Parameters, RateDependentPi};
use hysteron::model::Model;

const N: usize = 16;
const WINDOW: usize = 256;

type Preview = PreviewInverse<f64, N, WINDOW>;

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
        // It has rested where the drive starts.
        push(drive[0], 0.0);
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

/// One sweep, which is what a target makes, for the forward rate; two for the others.
fn settings(model: &RateDependentPi<f64, N>, plant_rate: PlantRate) -> PreviewSettings {
    PreviewSettings {
        window: window_for(model),
        sweeps: if plant_rate == PlantRate::Forward {
            1
        } else {
            2
        },
        plant_rate,
    }
}

fn preview(
    stage: &Stage,
    reference: &[f64],
    sample_time: f64,
    plant_rate: PlantRate,
) -> Option<Vec<f64>> {
    let model = stage.model(sample_time);
    let preview = Preview::new(&model, settings(&model, plant_rate)).ok()?;
    Some(drive_of(&preview, reference))
}

fn drive_of(preview: &Preview, reference: &[f64]) -> Vec<f64> {
    let mut state = Box::new(preview.start(reference[0]));
    let ahead = std::iter::repeat_n(*reference.last().unwrap(), preview.latency());
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
                Shape::Triangle => 40.0 * (1.0 - 4.0 * ((turns + 0.25).fract() - 0.5).abs()),
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
    let on = |frequency, rate, plant_rate| {
        worst(frequency, rate, |v| {
            preview(&stage, v, 1e-4, plant_rate).unwrap()
        })
    };
    for (frequency, limits) in [
        (
            50.0,
            [(0.001, 0.001), (0.07, 0.04), (0.22, 0.06), (0.18, 0.025)],
        ),
        (
            100.0,
            [(0.001, 0.001), (0.2, 0.12), (0.46, 0.17), (0.45, 0.1)],
        ),
    ] {
        let lines = Rate::Backward(20);
        let found = [
            on(frequency, Rate::Forward, PlantRate::Forward),
            on(frequency, Rate::Forward, PlantRate::Midpoint),
            on(frequency, lines, PlantRate::Midpoint),
            on(frequency, lines, PlantRate::Backward),
        ];
        let without = [Rate::Forward, lines]
            .map(|rate| worst(frequency, rate, |v| explicit(&stage, v, 1e-4)));
        println!("{frequency} Hz: {found:.4?}, explicit {without:.4?}");
        for (found, limit) in found.iter().zip(limits) {
            assert!(
                found.0 <= limit.0 && found.1 <= limit.1,
                "{found:?} {limit:?}"
            );
        }
        assert!(without.iter().all(|found| found.0 > 1.0), "{without:?}");
    }
}

/// What the preview inverse is compared on.
struct Suite {
    stages: Vec<Stage>,
    sample_rates: Vec<f64>,
    frequencies: Vec<f64>,
    phases: Vec<f64>,
}

/// How often it is worse than the explicit inverse.
#[derive(Debug, Default)]
struct Tally {
    compared: usize,
    refused: usize,
    largest: usize,
    rms: usize,
}

fn tally(suite: &Suite, rate: Rate, plant_rate: PlantRate) -> Tally {
    let mut tally = Tally::default();
    for (at, stage) in suite.stages.iter().enumerate() {
        for &sample_rate in &suite.sample_rates {
            let sample_time = 1.0 / sample_rate;
            for (shape, &frequency) in SHAPES
                .iter()
                .flat_map(|&shape| suite.frequencies.iter().map(move |f| (shape, f)))
            {
                // Seven harmonics need samples, and slow references take their time.
                if frequency > sample_rate / 100.0 || frequency < sample_rate / 1e4 {
                    continue;
                }
                for &phase in &suite.phases {
                    let reference = reference(shape, frequency, sample_time, phase);
                    let Some(with) = preview(stage, &reference, sample_time, plant_rate) else {
                        tally.refused += 1;
                        continue;
                    };
                    let error = |drive: &[f64]| {
                        let out = stage.displacement(drive, sample_time, rate);
                        errors(&reference, &out, sample_time)
                    };
                    let with = error(&with);
                    let without = error(&explicit(stage, &reference, sample_time));
                    let worse = (with.0 > without.0 + 1e-6, with.1 > without.1 + 1e-6);
                    tally.compared += 1;
                    tally.largest += usize::from(worse.0);
                    tally.rms += usize::from(worse.1);
                    if worse.0 || worse.1 {
                        println!(
                            "stage {at}, {sample_rate} Hz, {shape:?} {frequency} Hz, phase \
                             {phase}, {rate:?}: preview {with:.4?}, explicit {without:.4?}"
                        );
                    }
                }
            }
        }
    }
    println!("{plant_rate:?}: {tally:?}");
    tally
}

fn stages() -> Vec<Stage> {
    let others = [
        (1, 8e-4),
        (3, 0.0),
        (3, 1e-4),
        (5, 3e-3),
        (10, 7e-4),
        (16, 1.5e-3),
    ];
    let others = others.map(|(n, beta)| Stage::of(n, beta));
    std::iter::once(Stage::p753()).chain(others).collect()
}

/// A part of [`never_worse_than_the_explicit_inverse`] that takes seconds.
#[test]
fn not_worse_than_the_explicit_inverse() {
    let suite = Suite {
        stages: stages(),
        sample_rates: vec![5e3, 2e4],
        frequencies: vec![40.0, 200.0],
        phases: vec![0.0, 0.37],
    };
    let exact = tally(&suite, Rate::Forward, PlantRate::Forward);
    assert_eq!((exact.refused, exact.largest, exact.rms), (0, 0, 0));
    let lines = tally(&suite, Rate::Backward(20), PlantRate::Backward);
    assert_eq!((lines.refused, lines.rms), (0, 0));
    assert!(lines.largest * 20 <= lines.compared, "{lines:?}");
}

/// The whole suite; some minutes: `cargo test --release --test core_preview -- --ignored --nocapture`.
///
/// On a plant that sees the step that led to a sample, single samples at which that step changes at
/// once may be worse, and with plays that widen by 60 and more steps of the drive whole records.
#[test]
#[ignore = "takes minutes"]
fn never_worse_than_the_explicit_inverse() {
    let suite = Suite {
        stages: stages(),
        sample_rates: vec![5e3, 1e4, 2e4, 5e4],
        frequencies: vec![1.0, 10.0, 40.0, 100.0, 200.0],
        phases: (0..10).map(|phase| f64::from(phase) / 10.0).collect(),
    };
    let exact = tally(&suite, Rate::Forward, PlantRate::Forward);
    assert_eq!((exact.largest, exact.rms), (0, 0));
    let lines = tally(&suite, Rate::Backward(20), PlantRate::Backward);
    assert!(lines.largest * 40 <= lines.compared, "{lines:?}");
    assert!(lines.rms * 1000 <= lines.compared, "{lines:?}");
}

#[test]
fn without_a_rate_term_it_is_the_explicit_inverse() {
    let stage = Stage::of(7, 0.0);
    let reference = reference(Shape::TwoTone, 13.0, 1e-4, 0.3);
    for plant_rate in [PlantRate::Forward, PlantRate::Midpoint, PlantRate::Backward] {
        let with = preview(&stage, &reference, 1e-4, plant_rate).unwrap();
        for (a, b) in with.iter().zip(explicit(&stage, &reference, 1e-4)) {
            assert!((a - b).abs() < 1e-11, "{plant_rate:?}: {a} {b}");
        }
    }
}

/// (P 4): what lies beyond the window is forgotten within it.
#[test]
fn a_longer_window_changes_nothing() {
    let model = Stage::p753().model(1e-4);
    let settings = settings(&model, PlantRate::Forward);
    let window = 4 * settings.window;
    let [short, long] = [settings, PreviewSettings { window, ..settings }]
        .map(|settings| Preview::new(&model, settings).unwrap());
    let reference = reference(Shape::Multisine, 20.0, 1e-4, 0.1);
    let [short, long] = [short, long].map(|preview| drive_of(&preview, &reference));
    for (a, b) in short.iter().zip(&long).skip(10) {
        assert!((a - b).abs() < 0.01, "{a} {b}");
    }
}

#[test]
fn the_compensator_inverts_the_whole_stage() {
    let side = |slopes, thresholds| Side { slopes, thresholds };
    let map = Asymmetry::<f64, 4>::new(
        side(&[1.0, 0.1, -0.05], &[10.0, 25.0]),
        side(&[0.9, 0.2], &[15.0]),
    )
    .unwrap();
    let operator = Stage::p753().model(1e-4);
    let model = Model::new(operator, Some(map), -0.8, 3.0).unwrap();
    let settings = settings(&operator, PlantRate::Forward);
    let compensator = model.preview_compensator::<WINDOW>(settings).unwrap();
    let reference: Vec<f64> = reference(Shape::Sine, 50.0, 1e-4, 0.2)
        .iter()
        .map(|v| 3.0 + 0.6 * v)
        .collect();
    let mut state = Box::new(compensator.start(reference[0]).unwrap());
    let before = compensator.step(&mut state, f64::NAN);
    assert_eq!(before, Err(SampleError::NotFinite));
    let latency = compensator.latency();
    let drive: Vec<f64> = reference
        .iter()
        .map(|&v| compensator.step(&mut state, v).unwrap())
        .skip(latency)
        .collect();
    let mut stage = model.start(drive[0]);
    for (pair, wanted) in drive.windows(2).zip(&reference) {
        let came = model.step_with_rate(&mut stage, pair[0], (pair[1] - pair[0]) / 1e-4);
        assert!((came - wanted).abs() < 0.01, "{came} {wanted}");
    }
}

#[test]
fn single_precision_is_enough() {
    let stage = Stage::p753();
    let weights = [0.7236f32, 0.2906, 0.0416, 0.1512];
    let single = Parameters {
        weights: &weights,
        thresholds: &[9.715, 19.43, 29.145],
        beta: 8.572e-4,
    };
    let single = single.build::<3>(1e-4).unwrap();
    let double = stage.model(1e-4);
    let reference = reference(Shape::TwoTone, 13.0, 1e-4, 0.3);
    for plant_rate in [PlantRate::Forward, PlantRate::Backward] {
        let settings = settings(&double, plant_rate);
        let single = PreviewInverse::<f32, 3, 32>::new(&single, settings).unwrap();
        let mut state = single.start(reference[0] as f32);
        let drives = reference.iter().map(|&v| single.step(&mut state, v as f32));
        let truth = drive_of(&Preview::new(&double, settings).unwrap(), &reference);
        for (a, b) in drives.skip(single.latency()).zip(truth) {
            assert!((f64::from(a) - b).abs() < 0.02, "{plant_rate:?}: {a} {b}");
        }
    }
}

#[test]
fn refuses_what_has_no_preview_inverse() {
    let settings = PreviewSettings {
        window: 16,
        sweeps: 1,
        plant_rate: PlantRate::Forward,
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
        let refused = Preview::new(&model, wrong);
        assert_eq!(refused.unwrap_err(), ParameterError::Length(Field::Preview));
    }
    // A_1 = a_0 / 2: well-posed while beta < h / 2 (P 4).
    let falling = |beta| Stage {
        weights: vec![1.0, -0.5],
        thresholds: vec![5.0],
        beta,
    };
    assert!(Preview::new(&falling(0.49e-4).model(1e-4), settings).is_ok());
    assert_eq!(
        Preview::new(&falling(0.51e-4).model(1e-4), settings).unwrap_err(),
        ParameterError::RateTooStrong(1)
    );
}
