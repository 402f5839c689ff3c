//! Direct inverse multiplication on the simulated bimorph, with the models identified at the
//! frequency of the reference.

use hysteron::dim::{Dim, Law};
use serde::Serialize;

use crate::error::Error;
use crate::experiment::refused;
use crate::metrics::rms_error;

use super::model::{DIVISIONS, Model, Plane};
use super::record::{Record, settled, sine};

/// Amplitude of the reference (M 42), mm.
pub const REFERENCE_MM: f64 = 0.05;

/// What compensation of one frequency came to, over the last second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Rms of the distance from the reference, on the bimorph, mm (M's figure 17).
    pub rms_error_mm: f64,
    /// The same on the identified model itself, mm (M's figure 16).
    pub model_rms_error_mm: f64,
    /// Share of the samples in which the drive stood at the end of its range.
    pub saturated: f64,
}

/// Both laws for one model; the exact one is there only where the model has an inverse.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PerLaw {
    /// The printed law.
    pub printed: Outcome,
    /// The law solved within the sample.
    pub exact: Option<Outcome>,
    /// Why there is no exact law.
    pub refused: Option<String>,
}

/// Signals of one compensation.
#[derive(Clone, Debug)]
pub struct Run {
    /// Drive and what the bimorph made of it.
    pub record: Record,
    /// The reference, mm.
    pub reference_mm: Vec<f64>,
    /// The model's own output, mm.
    pub model_mm: Vec<f64>,
}

impl Run {
    /// Drives the bimorph along the reference by the given law.
    ///
    /// # Errors
    /// A model that the law cannot invert.
    pub fn new(model: &Model, law: Law, frequency_hz: f64) -> Result<Self, Error> {
        let dim = match law {
            Law::Printed => Dim::printed(*model),
            Law::Exact => Dim::exact(*model),
        };
        Self::with(&dim.map_err(refused)?, frequency_hz)
    }

    fn with(dim: &Dim<f64, DIVISIONS, Plane>, frequency_hz: f64) -> Result<Self, Error> {
        let reference_mm = sine(REFERENCE_MM, frequency_hz);
        let mut state = dim.start();
        let mut model_mm = Vec::with_capacity(reference_mm.len());
        let mut drive = Vec::with_capacity(reference_mm.len());
        for &reference in &reference_mm {
            drive.push(dim.step(&mut state, reference).map_err(refused)?);
            model_mm.push(state.model().outputs()[0]);
        }
        Ok(Self {
            record: Record::drive(frequency_hz, drive, 1)?,
            reference_mm,
            model_mm,
        })
    }

    /// The figures of the run.
    ///
    /// # Errors
    /// An output that is not finite.
    pub fn outcome(&self) -> Result<Outcome, Error> {
        let error = |output: &[f64]| {
            rms_error(settled(&self.reference_mm), settled(output)).map_err(refused)
        };
        let drive = settled(&self.record.drive);
        let saturated = drive.iter().filter(|u| u.abs() >= 1.0).count();
        Ok(Outcome {
            rms_error_mm: error(&self.record.displacement_mm)?,
            model_rms_error_mm: error(&self.model_mm)?,
            saturated: saturated as f64 / drive.len() as f64,
        })
    }
}

/// Both laws at one frequency.
///
/// # Errors
/// A model that not even the printed law can invert.
pub fn both_laws(model: &Model, frequency_hz: f64) -> Result<PerLaw, Error> {
    let printed = Run::new(model, Law::Printed, frequency_hz)?.outcome()?;
    let (exact, refused) = match Dim::exact(*model) {
        Ok(dim) => (Some(Run::with(&dim, frequency_hz)?.outcome()?), None),
        Err(reason) => (None, Some(reason.to_string())),
    };
    Ok(PerLaw {
        printed,
        exact,
        refused,
    })
}
