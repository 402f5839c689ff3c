//! The cascade against the printed law of DIM on the bimorph, at one frequency after the other: DIM
//! identified at each of them, the cascade once for all.

use hysteron::dim::Law;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::experiment::refused;
use crate::metrics::{line, rms_error};
use crate::model_file::ModelFile;
use crate::stage;

use super::compensators::{dim_drive, dim_model};
use super::inputs::{EASE_S, Input, Shape, Target, target_settled};
use super::plants::Plant;

/// From here on the cascade is held against DIM, Hz. Below, both are at what the relays leave.
pub const FROM_HZ: f64 = 5.0;
/// Before this time nothing is scored, s: as in paper M.
const SETTLED_S: f64 = 2.0;
/// Seed of the bimorph's noise while it is compensated.
const NOISE: u64 = 100;

/// What one drive came to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Rms distance from the reference, mm.
    pub rmse_mm: f64,
    /// Amplitude of the third harmonic over that of the fundamental.
    pub third_harmonic: f64,
    /// Largest step of the drive from sample to sample while the reference begins and ends, over the
    /// largest one in between; `None` where the drive stands at the end of its range.
    pub leap: Option<f64>,
    /// Largest drive, V.
    pub largest_v: f64,
}

/// Both at one frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AtFrequency {
    /// Frequency of the reference, Hz.
    pub frequency_hz: f64,
    /// Direct inverse multiplication as printed.
    pub dim: Outcome,
    /// The cascade.
    pub cascade: Outcome,
}

impl AtFrequency {
    /// How many times the error of the cascade DIM leaves.
    pub fn ratio(&self) -> f64 {
        self.dim.rmse_mm / self.cascade.rmse_mm
    }
}

/// What it comes to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Frequencies from [`FROM_HZ`] on.
    pub frequencies: usize,
    /// At so many of them the cascade leaves less.
    pub cascade_better: usize,
    /// Median of the error of DIM over that of the cascade.
    pub median_ratio: f64,
    /// Least of it.
    pub least_ratio: f64,
    /// Frequency of the least, Hz.
    pub least_ratio_hz: f64,
    /// Largest error of the cascade over all frequencies, mm rms.
    pub worst_mm: f64,
    /// Its frequency, Hz.
    pub worst_hz: f64,
    /// Third harmonic at 25 Hz over the fundamental, DIM; 0 where 25 Hz were not among them.
    pub third_25_hz_dim: f64,
    /// The same, cascade.
    pub third_25_hz_cascade: f64,
    /// Largest [`Outcome::leap`] of the cascade.
    pub largest_leap: f64,
}

/// Drives the bimorph along 0.05 mm at each frequency, the cascade being that of `file`; `done` is
/// called once a frequency.
///
/// # Errors
/// A model or drive that is refused.
pub fn run(
    file: &ModelFile,
    frequencies_hz: &[f64],
    done: &(dyn Fn() + Sync),
) -> Result<Vec<AtFrequency>, Error> {
    frequencies_hz
        .par_iter()
        .map(|&frequency_hz| at(file, frequency_hz))
        .inspect(|_| done())
        .collect()
}

fn at(file: &ModelFile, frequency_hz: f64) -> Result<AtFrequency, Error> {
    let input = Input {
        shape: Shape::Sine,
        frequency_hz,
    };
    let target = target_settled(Plant::Bimorph, input, SETTLED_S)?;
    let model = dim_model(Plant::Bimorph, frequency_hz)?;
    let dim = dim_drive(Plant::Bimorph, &model, Law::Printed, &target.samples)?;
    let cascade = stage::drive_ahead(file, target.sample_time_s, &target.samples)?;
    Ok(AtFrequency {
        frequency_hz,
        dim: outcome(&target, &dim, frequency_hz)?,
        cascade: outcome(&target, &cascade, frequency_hz)?,
    })
}

fn outcome(target: &Target, drive: &[f64], frequency_hz: f64) -> Result<Outcome, Error> {
    let h = target.sample_time_s;
    let device = Plant::Bimorph.device(NOISE + frequency_hz as u64);
    let displacement = device.run(drive, h).map_err(refused)?;
    let scored = target.scored.clone();
    let settled = &displacement[scored.clone()];
    let amplitude = |f| line(settled, h, f).map(|line| line.amplitude);
    let first = amplitude(frequency_hz).map_err(refused)?;
    let third = amplitude(3.0 * frequency_hz).map_err(refused)?;
    let error = rms_error(&target.samples[scored.clone()], settled).map_err(refused)?;
    let steepest = |drive: &[f64]| {
        let steps = drive.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        steps.fold(0.0, f64::max)
    };
    let begun = (EASE_S / h).round() as usize;
    let at_ends = steepest(&drive[..begun]).max(steepest(&drive[scored.end..]));
    let between = steepest(&drive[scored]);
    Ok(Outcome {
        rmse_mm: 1e-3 * error,
        third_harmonic: third / first,
        leap: (between > 0.0).then_some(at_ends / between),
        largest_v: drive.iter().fold(0.0, |most, u| u.abs().max(most)),
    })
}

impl Comparison {
    /// The figures of a run; `None` without a frequency from [`FROM_HZ`] on.
    pub fn new(rows: &[AtFrequency]) -> Option<Self> {
        let mut held: Vec<&AtFrequency> = rows
            .iter()
            .filter(|at| at.frequency_hz >= FROM_HZ)
            .collect();
        held.sort_by(|a, b| a.ratio().total_cmp(&b.ratio()));
        let least = held.first()?;
        let worst = rows
            .iter()
            .max_by(|a, b| a.cascade.rmse_mm.total_cmp(&b.cascade.rmse_mm))?;
        let at_25 = rows.iter().find(|at| at.frequency_hz == 25.0);
        let third = |of: fn(&AtFrequency) -> f64| at_25.map_or(0.0, of);
        Some(Self {
            frequencies: held.len(),
            cascade_better: held.iter().filter(|at| at.ratio() > 1.0).count(),
            median_ratio: held[held.len() / 2].ratio(),
            least_ratio: least.ratio(),
            least_ratio_hz: least.frequency_hz,
            worst_mm: worst.cascade.rmse_mm,
            worst_hz: worst.frequency_hz,
            third_25_hz_dim: third(|at| at.dim.third_harmonic),
            third_25_hz_cascade: third(|at| at.cascade.third_harmonic),
            largest_leap: rows
                .iter()
                .map(|at| at.cascade.leap.unwrap_or(f64::INFINITY))
                .fold(0.0, f64::max),
        })
    }
}
