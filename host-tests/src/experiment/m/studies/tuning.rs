//! What identification and compensation owe to the initial covariance and to the envelopes' slopes.

use hysteron::dim::Law;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::experiment::m::compensation::Run;
use crate::experiment::m::model::{Recipe, free_run};
use crate::experiment::m::record::Record;

/// Frequencies that are looked at, Hz.
pub const LOOKED_AT_HZ: [f64; 8] = [5.0, 10.0, 20.0, 25.0, 50.0, 74.0, 80.0, 110.0];
const COVARIANCES: [f64; 5] = [1e-2, 1.0, 1e2, 1e4, 1e6];
const SLOPES_S: [f64; 4] = [0.0, 1e-4, 4e-4, 1e-3];

/// What a recipe comes to at the frequencies looked at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outcome {
    /// Lowest Fitting in free run, percent; far below zero for a model that runs away.
    pub lowest_fitting_percent: f64,
    /// Rms errors under the printed law, mm; absent where the law refuses the model.
    pub rms_error_mm: Vec<Option<f64>>,
}

/// Under one initial covariance.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AtCovariance {
    /// Entries of its diagonal.
    pub covariance: f64,
    /// What it comes to.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// With one slope of both envelopes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AtEnvelope {
    /// alpha = beta, s.
    pub slope_s: f64,
    /// What it comes to.
    #[serde(flatten)]
    pub outcome: Outcome,
}

fn outcome(recipe: Recipe) -> Result<Outcome, Error> {
    let found = LOOKED_AT_HZ
        .into_par_iter()
        .map(|hz| {
            let record = Record::measure(hz)?;
            let model = recipe.model(hz, &recipe.identify(&record)?)?;
            let score = record.score(&free_run(&model, &record.drive));
            // A refusal is a result here.
            let run = Run::new(&model, Law::Printed, hz).ok();
            let error = run.map(|run| run.outcome()).transpose()?;
            Ok((score.fitting_percent, error.map(|o| o.rms_error_mm)))
        })
        .collect::<Result<Vec<_>, Error>>()?;
    Ok(Outcome {
        lowest_fitting_percent: found
            .iter()
            .fold(f64::INFINITY, |least, (fitting, _)| least.min(*fitting)),
        rms_error_mm: found.into_iter().map(|(_, error)| error).collect(),
    })
}

/// A range of initial covariances.
///
/// # Errors
/// A drive that is refused.
pub fn covariances() -> Result<Vec<AtCovariance>, Error> {
    COVARIANCES
        .into_iter()
        .map(|covariance| {
            Ok(AtCovariance {
                covariance,
                outcome: outcome(Recipe {
                    covariance,
                    ..Recipe::PROPOSED
                })?,
            })
        })
        .collect()
}

/// A range of slopes.
///
/// # Errors
/// A drive that is refused.
pub fn envelopes() -> Result<Vec<AtEnvelope>, Error> {
    SLOPES_S
        .into_iter()
        .map(|slope_s| {
            Ok(AtEnvelope {
                slope_s,
                outcome: outcome(Recipe {
                    envelope_s: slope_s,
                    ..Recipe::PROPOSED
                })?,
            })
        })
        .collect()
}
