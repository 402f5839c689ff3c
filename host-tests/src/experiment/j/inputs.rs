//! Triangles, and sines of two alternating amplitudes whose small periods are minor loops.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::references::{Grid, Reference, major_minor, triangle};
use crate::experiment::refused;
use crate::model_file::ModelFile;
use crate::plant;

use super::drives::{PerDrive, drives};
use super::plants::{Errors, lag_removed, largest_errors};
use super::{AMPLITUDE, SAMPLE_TIME_S};

/// Amplitude of the small periods in um.
const SMALL: f64 = 20.0;

/// The shape of a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// A triangle of 40 um.
    Triangle,
    /// Periods of 40 um and 20 um in turn.
    MajorMinor,
}

impl Shape {
    /// The shape in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Triangle => "triangle",
            Self::MajorMinor => "two amplitudes",
        }
    }
}

/// What is run: shape and frequency in Hz. The figures of the paper are lost, and with them its
/// frequencies.
pub const INPUTS: [(Shape, f64); 4] = [
    (Shape::Triangle, 10.0),
    (Shape::Triangle, 50.0),
    (Shape::MajorMinor, 10.0),
    (Shape::MajorMinor, 50.0),
];

/// Largest errors of one plant along one reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AlongInput {
    /// Shape of the reference.
    pub input: Shape,
    /// Its frequency in Hz.
    pub frequency_hz: f64,
    /// The plant and its errors.
    #[serde(flatten)]
    pub errors: Errors,
}

/// A reference and what the simulated stage makes of it, the lag removed.
#[derive(Clone, Debug)]
pub struct Traces {
    /// Shape of the reference.
    pub input: Shape,
    /// Its frequency in Hz.
    pub frequency_hz: f64,
    /// Time in s.
    pub time_s: Vec<f64>,
    /// The reference in um.
    pub reference: Vec<f64>,
    /// Displacement of the stage in um for each drive.
    pub displacement: PerDrive<Vec<f64>>,
}

/// One input on every plant, its first two periods left out of the figures.
///
/// # Errors
/// A model, signal or stage that is refused.
pub fn run(
    file: &ModelFile,
    (shape, frequency_hz): (Shape, f64),
) -> Result<(Vec<AlongInput>, Traces), Error> {
    let grid = |cycles| Grid::for_cycles(SAMPLE_TIME_S, frequency_hz, cycles).map_err(refused);
    let whole = grid(6.0)?;
    let settled = grid(2.0)?.samples();
    let reference = match shape {
        Shape::Triangle => triangle(&whole, AMPLITUDE, frequency_hz, 0.0),
        Shape::MajorMinor => major_minor(&whole, AMPLITUDE, SMALL, frequency_hz),
    }
    .map_err(refused)?;
    let rows = largest_errors(file, &reference, settled)?
        .into_iter()
        .map(|errors| AlongInput {
            input: shape,
            frequency_hz,
            errors,
        })
        .collect();
    Ok((rows, traces(file, shape, frequency_hz, reference)?))
}

fn traces(
    file: &ModelFile,
    input: Shape,
    frequency_hz: f64,
    reference: Reference,
) -> Result<Traces, Error> {
    let h = reference.sample_time_s;
    let stage = plant::Stage::p753();
    let displacement = drives(file, &reference)?.try_map(|u| {
        let measured = stage.run(u, h).map_err(refused)?;
        Ok::<_, Error>(lag_removed(&measured, h))
    })?;
    Ok(Traces {
        input,
        frequency_hz,
        time_s: (0..displacement.none.len()).map(|k| k as f64 * h).collect(),
        reference: reference.samples,
        displacement,
    })
}
