//! Everything at one frequency.

use hysteron::dim::Law;
use serde::Serialize;

use crate::error::Error;

use super::compensation::{PerLaw, Run, both_laws};
use super::fitting::{Comparison, identify};
use super::model::free_run;
use super::record::{Record, settled};

/// Frequencies whose signals are kept for the figures.
pub const SHOWN_HZ: [u32; 11] = [10, 15, 25, 35, 50, 72, 73, 74, 75, 80, 95];

/// Figures of one frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AtFrequency {
    /// Frequency in Hz of drive and reference.
    pub frequency_hz: f64,
    /// Largest displacement at full drive, mm; over 1 the gain of the paper's figure 4.
    pub largest_mm: f64,
    /// The three models.
    pub models: Comparison,
    /// Compensation with the proposed model.
    pub proposed: PerLaw,
    /// Compensation with the model without g.
    pub truncated: PerLaw,
}

/// A steady second of one frequency.
#[derive(Clone, Debug)]
pub struct Traces {
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Full drive, 1 for 5 V.
    pub drive: Vec<f64>,
    /// Displacement under it, mm.
    pub displacement_mm: Vec<f64>,
    /// What the proposed model makes of that drive, identified for the free run, mm.
    pub free_run_mm: Vec<f64>,
    /// The same, identified recursively, mm.
    pub recursive_mm: Vec<f64>,
    /// Reference of the compensation, mm.
    pub reference_mm: Vec<f64>,
    /// Drive of the printed law with the proposed model.
    pub compensating: Vec<f64>,
    /// Displacement under that, mm.
    pub compensated_mm: Vec<f64>,
}

/// Measures, identifies, compensates.
///
/// # Errors
/// A model or drive that is refused.
pub fn at(frequency_hz: u32) -> Result<(AtFrequency, Option<Traces>), Error> {
    let shown = SHOWN_HZ.contains(&frequency_hz);
    let frequency_hz = f64::from(frequency_hz);
    let record = Record::measure(frequency_hz)?;
    let identified = identify(&record)?;
    let [full, short] = &identified.recursive;
    let steady = |signal: &[f64]| settled(signal).to_vec();
    let displacement_mm = steady(&record.displacement_mm);
    let found = AtFrequency {
        frequency_hz,
        largest_mm: displacement_mm
            .iter()
            .fold(0.0, |largest, y| largest.max(y.abs())),
        models: identified.comparison,
        proposed: both_laws(full, frequency_hz)?,
        truncated: both_laws(short, frequency_hz)?,
    };
    if !shown {
        return Ok((found, None));
    }
    let run = Run::new(full, Law::Printed, frequency_hz)?;
    let traces = Traces {
        frequency_hz,
        drive: steady(&record.drive),
        displacement_mm,
        free_run_mm: steady(&free_run(&identified.free_run, &record.drive)),
        recursive_mm: steady(&free_run(full, &record.drive)),
        reference_mm: steady(&run.reference_mm),
        compensating: steady(&run.record.drive),
        compensated_mm: steady(&run.record.displacement_mm),
    };
    Ok((found, Some(traces)))
}
