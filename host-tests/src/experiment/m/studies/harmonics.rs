//! Harmonics: of the response at 25 Hz, of the harmonic terms, and what these are good for.

use hysteron::dim::{Dim, Law};
use hysteron::hysteresis::modified_play::Harmonics;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::experiment::m::compensation::{REFERENCE_MM, Run};
use crate::experiment::m::model::{COEFFICIENTS, Recipe, free_run};
use crate::experiment::m::record::{Record, SAMPLE_TIME_S, Score, settled, sine};
use crate::experiment::refused;
use crate::metrics::line;

/// Where the third harmonic meets the resonance, Hz.
const FREQUENCY_HZ: f64 = 25.0;
/// Where the two forms of the terms are compared, Hz.
const COMPARED_HZ: [f64; 8] = [10.0, 15.0, 20.0, 25.0, 35.0, 50.0, 74.0, 95.0];
/// Harmonics that are looked at.
const HARMONICS: usize = 7;

/// One line of the response to a 25 Hz reference of 0.05 mm.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AtHarmonic {
    /// Number of the harmonic, 1 for 25 Hz.
    pub harmonic: usize,
    /// Amplitude under a sine drive that would give 0.05 mm, mm.
    pub before_mm: f64,
    /// Under the printed law, mm.
    pub printed_mm: f64,
    /// Under the law solved within the sample, mm; absent where the model has no inverse.
    pub exact_mm: Option<f64>,
    /// In the drive of the printed law, 1 for 5 V.
    pub drive: f64,
}

/// Amplitudes of the harmonics of one harmonic term under a sine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Content {
    /// Which form.
    pub form: &'static str,
    /// Which coefficient the term goes with.
    pub coefficient: &'static str,
    /// Amplitude of harmonic 0 to 6; harmonic 0 is the mean.
    pub amplitudes: [f64; HARMONICS],
}

/// The model with either form of the harmonic terms.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// Frequency in Hz.
    pub frequency_hz: f64,
    /// Free run, recursive identification.
    pub printed: Score,
    /// The same.
    pub corrected: Score,
    /// Rms error of the compensated bimorph, printed law, mm.
    pub printed_rms_error_mm: f64,
    /// The same.
    pub corrected_rms_error_mm: f64,
}

fn amplitude(signal: &[f64], harmonic: usize) -> Result<f64, Error> {
    let hz = harmonic as f64 * FREQUENCY_HZ;
    let found = line(settled(signal), SAMPLE_TIME_S, hz).map_err(refused)?;
    Ok(found.amplitude)
}

/// Lines 1 to 6 of the response before and after compensation.
///
/// # Errors
/// A drive or model that is refused.
pub fn response() -> Result<Vec<AtHarmonic>, Error> {
    let record = Record::measure(FREQUENCY_HZ)?;
    let coefficients = Recipe::PROPOSED.identify(&record)?;
    let model = Recipe::PROPOSED.model(FREQUENCY_HZ, &coefficients)?;
    let full = amplitude(&record.displacement_mm, 1)?;
    let plain = sine(REFERENCE_MM / full, FREQUENCY_HZ);
    let before = Record::drive(FREQUENCY_HZ, plain, 2)?;
    let printed = Run::new(&model, Law::Printed, FREQUENCY_HZ)?;
    let exact = match Dim::exact(model) {
        Ok(_) => Some(Run::new(&model, Law::Exact, FREQUENCY_HZ)?),
        Err(_) => None,
    };
    (1..HARMONICS)
        .map(|harmonic| {
            let of_exact = exact
                .as_ref()
                .map(|run| amplitude(&run.record.displacement_mm, harmonic));
            Ok(AtHarmonic {
                harmonic,
                before_mm: amplitude(&before.displacement_mm, harmonic)?,
                printed_mm: amplitude(&printed.record.displacement_mm, harmonic)?,
                exact_mm: of_exact.transpose()?,
                drive: amplitude(&printed.record.drive, harmonic)?,
            })
        })
        .collect()
}

/// Harmonics that the terms hold under a sine of their own frequency.
///
/// # Errors
/// None with the fixed signals.
pub fn contents() -> Result<Vec<Content>, Error> {
    const NAMES: [&str; 6] = ["A_11", "A_12", "A_31", "A_32", "A_51", "A_52"];
    // No sensor noise reaches these terms; the displacement is not looked at.
    let record = Record::measure(FREQUENCY_HZ)?;
    let mut contents = Vec::new();
    for (form, harmonics) in [
        ("printed", Harmonics::Printed),
        ("corrected", Harmonics::Corrected),
    ] {
        let recipe = Recipe {
            harmonics,
            ..Recipe::PROPOSED
        };
        let rows = recipe.rows(&record)?;
        for (i, coefficient) in NAMES.into_iter().enumerate() {
            let place = COEFFICIENTS - NAMES.len() + i;
            let signal: Vec<f64> = rows.iter().map(|row| row[place]).collect();
            let mut amplitudes = [0.0; HARMONICS];
            let steady = settled(&signal);
            amplitudes[0] = (steady.iter().sum::<f64>() / steady.len() as f64).abs();
            for (harmonic, amplitude_of) in amplitudes.iter_mut().enumerate().skip(1) {
                *amplitude_of = amplitude(&signal, harmonic)?;
            }
            contents.push(Content {
                form,
                coefficient,
                amplitudes,
            });
        }
    }
    Ok(contents)
}

/// Both forms in identification and compensation.
///
/// # Errors
/// A drive or model that is refused.
pub fn compare() -> Result<Vec<Compared>, Error> {
    COMPARED_HZ
        .into_par_iter()
        .map(|frequency_hz| {
            let record = Record::measure(frequency_hz)?;
            let with = |harmonics| {
                let recipe = Recipe {
                    harmonics,
                    ..Recipe::PROPOSED
                };
                let model = recipe.model(frequency_hz, &recipe.identify(&record)?)?;
                let score = record.score(&free_run(&model, &record.drive));
                let run = Run::new(&model, Law::Printed, frequency_hz)?;
                Ok::<_, Error>((score, run.outcome()?.rms_error_mm))
            };
            let (printed, printed_rms_error_mm) = with(Harmonics::Printed)?;
            let (corrected, corrected_rms_error_mm) = with(Harmonics::Corrected)?;
            Ok(Compared {
                frequency_hz,
                printed,
                corrected,
                printed_rms_error_mm,
                corrected_rms_error_mm,
            })
        })
        .collect()
}
