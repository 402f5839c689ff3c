//! Records of the simulated bimorph in the symbols of the paper: drive in parts of 5 V, displacement
//! in mm.

use std::f64::consts::TAU;

use serde::Serialize;

use crate::error::Error;
use crate::experiment::refused;
use crate::metrics::rms_error;
use crate::plant::bimorph::Bimorph;

/// Time between samples in s.
pub const SAMPLE_TIME_S: f64 = Bimorph::SAMPLE_TIME_S;
/// Samples in a second, which holds whole periods of every whole frequency.
pub const SECOND: usize = 5_000;
/// Seconds of a record; the last one is what is scored.
const SECONDS: usize = 3;

/// Drive and displacement of one run from the virgin state.
#[derive(Clone, Debug)]
pub struct Record {
    /// Frequency of drive or reference in Hz.
    pub frequency_hz: f64,
    /// Drive, 1 for 5 V.
    pub drive: Vec<f64>,
    /// Displacement in mm.
    pub displacement_mm: Vec<f64>,
}

/// How well a simulated output meets a measured one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Score {
    /// (M 40), mm.
    pub rmse_mm: f64,
    /// (M 41), percent; the denominator taken over the measured output, not over the model's.
    pub fitting_percent: f64,
}

/// `amplitude sin(2 pi f t)` over the time of a record.
pub fn sine(amplitude: f64, frequency_hz: f64) -> Vec<f64> {
    (0..SECONDS * SECOND)
        .map(|k| amplitude * (TAU * frequency_hz * k as f64 * SAMPLE_TIME_S).sin())
        .collect()
}

/// The last second of a signal.
pub fn settled(signal: &[f64]) -> &[f64] {
    &signal[signal.len() - SECOND..]
}

impl Record {
    /// Drives the bimorph with full amplitude (M 38).
    ///
    /// # Errors
    /// A drive that the bimorph refuses.
    pub fn measure(frequency_hz: f64) -> Result<Self, Error> {
        Self::drive(frequency_hz, sine(1.0, frequency_hz), 0)
    }

    /// Drives the bimorph; `run` chooses the sensor's noise, which differs from frequency to
    /// frequency too.
    ///
    /// # Errors
    /// A drive that the bimorph refuses.
    pub fn drive(frequency_hz: f64, drive: Vec<f64>, run: u64) -> Result<Self, Error> {
        let mut bimorph = Bimorph::pzba();
        bimorph.sensor.seed = (run << 32) | frequency_hz as u64;
        let volts: Vec<f64> = drive.iter().map(|u| Bimorph::FULL_DRIVE_V * u).collect();
        let displacement_um = bimorph.run(&volts, SAMPLE_TIME_S).map_err(refused)?;
        Ok(Self {
            frequency_hz,
            drive,
            displacement_mm: displacement_um.iter().map(|um| 1e-3 * um).collect(),
        })
    }

    /// Scores a simulated output, mm, over the last second. A model that ran away scores infinite.
    pub fn score(&self, output_mm: &[f64]) -> Score {
        let measured = settled(&self.displacement_mm);
        let mean = measured.iter().sum::<f64>() / SECOND as f64;
        let level = vec![mean; SECOND];
        let spread = rms_error(measured, &level).unwrap_or(f64::NAN);
        let rmse_mm = rms_error(measured, settled(output_mm)).unwrap_or(f64::INFINITY);
        Score {
            rmse_mm,
            fitting_percent: 100.0 * (1.0 - rmse_mm / spread),
        }
    }
}
