//! Largest errors along sines of 0.05 to 100 Hz.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::references::{Grid, Reference, sine};
use crate::experiment::refused;
use crate::model_file::ModelFile;

use super::drives::PerDrive;
use super::plants::{Errors, Plant, largest_errors};
use super::{AMPLITUDE, SAMPLE_TIME_S};

/// Frequencies in Hz.
pub const FREQUENCIES_HZ: [f64; 12] = [
    0.05, 0.1, 0.5, 1.0, 5.0, 10.0, 20.0, 40.0, 50.0, 60.0, 80.0, 100.0,
];

/// Samples a period below 1 Hz, where 10 kHz would only be slow.
const SLOW_SAMPLES: f64 = 2_000.0;

/// Largest errors of one plant at one frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AtFrequency {
    /// Frequency in Hz of the reference.
    pub frequency_hz: f64,
    /// The plant and its errors.
    #[serde(flatten)]
    pub errors: Errors,
}

/// Lowest and highest of a plant's largest errors over all frequencies, in um.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Band {
    /// The plant.
    pub plant: Plant,
    /// The lowest, for each drive by itself.
    pub least: PerDrive<f64>,
    /// The highest, for each drive by itself.
    pub most: PerDrive<f64>,
}

/// Two periods of the sine that the stage is to follow and where the second one starts.
///
/// # Errors
/// A frequency that makes no signal.
pub fn reference(frequency_hz: f64) -> Result<(Reference, usize), Error> {
    let sample_time_s = if frequency_hz < 1.0 {
        1.0 / (SLOW_SAMPLES * frequency_hz)
    } else {
        SAMPLE_TIME_S
    };
    let grid = |cycles| Grid::for_cycles(sample_time_s, frequency_hz, cycles).map_err(refused);
    let reference = sine(&grid(2.0)?, AMPLITUDE, frequency_hz, 0.0).map_err(refused)?;
    Ok((reference, grid(1.0)?.samples()))
}

/// Every plant at one frequency.
///
/// # Errors
/// A model, signal or stage that is refused.
pub fn at(file: &ModelFile, frequency_hz: f64) -> Result<Vec<AtFrequency>, Error> {
    let (reference, settled) = reference(frequency_hz)?;
    let errors = largest_errors(file, &reference, settled)?;
    Ok(errors
        .into_iter()
        .map(|errors| AtFrequency {
            frequency_hz,
            errors,
        })
        .collect())
}

/// The rows of one plant, in the order of the frequencies.
pub fn of_plant(rows: &[AtFrequency], plant: Plant) -> impl Iterator<Item = &AtFrequency> {
    rows.iter().filter(move |row| row.errors.plant == plant)
}

/// The band of each plant, in the order in which the plants first appear.
pub fn bands(rows: &[AtFrequency]) -> Vec<Band> {
    let mut bands: Vec<Band> = Vec::new();
    for row in rows {
        let plant = row.errors.plant;
        if bands.iter().any(|band| band.plant == plant) {
            continue;
        }
        let all: Vec<_> = of_plant(rows, plant)
            .map(|row| row.errors.largest_um)
            .collect();
        bands.push(Band {
            plant,
            least: PerDrive::over(&all, |sorted| sorted[0]),
            most: PerDrive::over(&all, |sorted| sorted[sorted.len() - 1]),
        });
    }
    bands
}
