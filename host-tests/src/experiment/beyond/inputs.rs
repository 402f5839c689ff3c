//! The references: both papers' inputs, begun and ended smoothly.

use std::ops::Range;

use serde::Serialize;

use crate::error::Error;
use crate::experiment::references::{Grid, major_minor, sine, triangle};
use crate::experiment::refused;

use super::plants::Plant;

/// Over so many seconds a reference grows from rest and dies away again.
pub const EASE_S: f64 = 0.2;
/// Before this time nothing is scored, s.
pub const SETTLED_S: f64 = 1.0;
/// So long is scored, s: whole periods of every whole frequency, whole pairs of an even one.
const SCORED_S: f64 = 1.0;
/// Rest behind, s: longer than any compensator looks ahead.
const REST_S: f64 = 0.1;

/// The shape of a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A sine.
    Sine,
    /// A triangle.
    Triangle,
    /// Periods of the full and of half the amplitude in turn.
    TwoAmplitudes,
}

impl Shape {
    /// The shape in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Sine => "sine",
            Self::Triangle => "triangle",
            Self::TwoAmplitudes => "two amplitudes",
        }
    }
}

/// A reference of a plant.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Input {
    /// Its shape.
    pub shape: Shape,
    /// Its frequency in Hz.
    pub frequency_hz: f64,
}

/// Frequencies of the sines in Hz over paper J's range.
const SINES_J_HZ: [f64; 10] = [1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 50.0, 60.0, 80.0, 100.0];
/// The same over paper M's: close where its compensator fails.
const SINES_M_HZ: [f64; 20] = [
    1.0, 5.0, 10.0, 15.0, 20.0, 23.0, 24.0, 25.0, 26.0, 27.0, 30.0, 37.0, 45.0, 50.0, 60.0, 70.0,
    74.0, 80.0, 95.0, 110.0,
];
/// Frequencies of the other shapes, Hz; even, see [`SCORED_S`].
const OTHERS_HZ: [f64; 2] = [10.0, 50.0];

/// The references of a plant: sines first, in the order of their frequencies.
pub fn inputs(plant: Plant) -> Vec<Input> {
    let sines: &[f64] = match plant {
        Plant::Plays | Plant::Relays => &SINES_J_HZ,
        Plant::Bimorph => &SINES_M_HZ,
    };
    let of = |shape| {
        move |&frequency_hz: &f64| Input {
            shape,
            frequency_hz,
        }
    };
    let triangles = OTHERS_HZ.iter().map(of(Shape::Triangle));
    let pairs = OTHERS_HZ.iter().map(of(Shape::TwoAmplitudes));
    let sines = sines.iter().map(of(Shape::Sine));
    sines.chain(triangles).chain(pairs).collect()
}

/// A reference with the samples that are scored.
#[derive(Clone, Debug)]
pub struct Target {
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// The reference in um.
    pub samples: Vec<f64>,
    /// Amplitude in um.
    pub amplitude_um: f64,
    /// What is scored.
    pub scored: Range<usize>,
}

/// The reference of a plant along an input.
///
/// # Errors
/// A frequency that makes no signal.
pub fn target(plant: Plant, input: Input) -> Result<Target, Error> {
    target_settled(plant, input, SETTLED_S)
}

/// The same, scored from `settled_s` on.
///
/// # Errors
/// As [`target`].
pub fn target_settled(plant: Plant, input: Input, settled_s: f64) -> Result<Target, Error> {
    let (h, amplitude_um) = (plant.sample_time_s(), plant.amplitude_um());
    let end_s = settled_s + SCORED_S;
    let grid = Grid::for_duration(h, end_s + EASE_S + REST_S).map_err(refused)?;
    let f = input.frequency_hz;
    let whole = match input.shape {
        Shape::Sine => sine(&grid, amplitude_um, f, 0.0),
        Shape::Triangle => triangle(&grid, amplitude_um, f, 0.0),
        Shape::TwoAmplitudes => major_minor(&grid, amplitude_um, 0.5 * amplitude_um, f),
    };
    let mut samples = whole.map_err(refused)?.samples;
    for (k, value) in samples.iter_mut().enumerate() {
        let t = k as f64 * h;
        *value *= ease(t / EASE_S) * ease((end_s + EASE_S - t) / EASE_S);
    }
    let index = |t: f64| (t / h).round() as usize;
    Ok(Target {
        sample_time_s: h,
        samples,
        amplitude_um,
        scored: index(settled_s)..index(end_s),
    })
}

/// From 0 at 0 to 1 at 1, without a leap of its first two derivatives.
fn ease(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}
