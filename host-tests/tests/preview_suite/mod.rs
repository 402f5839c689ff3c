//! Plants, references and drives for the preview inverse.
//!
//! The plants are plain loops over play operators, with nothing of the core in them.

use std::f64::consts::TAU;

use hysteron::hysteresis::preview::{PlantRate, PreviewInverse, PreviewSettings, window_for};
use hysteron::hysteresis::{Parameters, RateDependentPi};

pub const N: usize = 16;
pub const WINDOW: usize = 256;

pub type Preview = PreviewInverse<f64, N, WINDOW>;

/// What the plant's thresholds widen with.
#[derive(Clone, Copy, Debug)]
pub enum Rate {
    /// The step to come.
    Forward,
    /// The step that led to the sample, the drive joined by lines and stepped so many times finer.
    Backward(u32),
}

#[derive(Clone, Debug)]
pub struct Stage {
    pub weights: Vec<f64>,
    pub thresholds: Vec<f64>,
    pub beta: f64,
}

impl Stage {
    /// The published stage, corrected (paper J).
    pub fn p753() -> Self {
        Self {
            weights: vec![0.7236, 0.2906, 0.0416, 0.1512],
            thresholds: vec![9.715, 19.43, 29.145],
            beta: 8.572e-4,
        }
    }

    /// `n` plays over a range of 40 that make up a share of the gain 1.2.
    pub fn of(n: usize, beta: f64) -> Self {
        let mut weights = vec![0.7];
        weights.extend((0..n).map(|i| 0.5 * (1.0 + (i % 3) as f64) / (2.0 * n as f64)));
        Self {
            weights,
            thresholds: (1..=n).map(|i| 36.0 * i as f64 / (n + 1) as f64).collect(),
            beta,
        }
    }

    pub fn model(&self, sample_time: f64) -> RateDependentPi<f64, N> {
        Parameters {
            weights: &self.weights,
            thresholds: &self.thresholds,
            beta: self.beta,
        }
        .build(sample_time)
        .unwrap()
    }

    pub fn displacement(&self, drive: &[f64], sample_time: f64, rate: Rate) -> Vec<f64> {
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

pub fn explicit(stage: &Stage, reference: &[f64], sample_time: f64) -> Vec<f64> {
    let inverse = stage.model(sample_time).inverse().unwrap();
    let mut state = inverse.start(reference[0]);
    reference
        .iter()
        .map(|&v| inverse.step(&mut state, v))
        .collect()
}

/// One sweep, which is what a target makes, for the forward rate; two for the others.
pub fn settings(model: &RateDependentPi<f64, N>, plant_rate: PlantRate) -> PreviewSettings {
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

pub fn preview(
    stage: &Stage,
    reference: &[f64],
    sample_time: f64,
    plant_rate: PlantRate,
) -> Option<Vec<f64>> {
    let model = stage.model(sample_time);
    let preview = Preview::new(&model, settings(&model, plant_rate)).ok()?;
    Some(drive_of(&preview, reference))
}

pub fn drive_of(preview: &Preview, reference: &[f64]) -> Vec<f64> {
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
pub enum Shape {
    Sine,
    Triangle,
    TwoAmplitude,
    TwoTone,
    Multisine,
    Raster,
    ExampleF,
}

pub const SHAPES: [Shape; 7] = [
    Shape::Sine,
    Shape::Triangle,
    Shape::TwoAmplitude,
    Shape::TwoTone,
    Shape::Multisine,
    Shape::Raster,
    Shape::ExampleF,
];

/// Four periods, the samples shifted by a `phase` of the sample time.
pub fn reference(shape: Shape, frequency: f64, sample_time: f64, phase: f64) -> Vec<f64> {
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
pub fn errors(reference: &[f64], displacement: &[f64], sample_time: f64) -> (f64, f64) {
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
