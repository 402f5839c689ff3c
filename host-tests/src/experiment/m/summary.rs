//! What all frequencies together come to.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::refused;
use crate::metrics::line;

use super::fitting::{Comparison, Scores};
use super::record::{SAMPLE_TIME_S, Score};
use super::studies::Studies;
use super::sweep::{AtFrequency, Traces};

/// At how many frequencies each model had the smallest RMSE; equal ones count for the first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// With g.
    pub proposed: usize,
    /// Without g.
    pub truncated: usize,
    /// The rival.
    pub bouc_wen: usize,
}

/// Facts about the bimorph beside which the paper's stand.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Facts {
    /// Frequency in Hz of the largest displacement.
    pub resonance_hz: f64,
    /// Third over first harmonic at 25 Hz.
    pub third_at_25_hz: f64,
    /// Third over first harmonic at 35 Hz.
    pub third_at_35_hz: f64,
    /// Fifth over third harmonic at 15 Hz.
    pub fifth_at_15_hz: f64,
}

/// The summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// The bimorph.
    pub facts: Facts,
    /// Free run, identified for it.
    pub best_in_free_run: Counts,
    /// One step, identified for it.
    pub best_in_one_step: Counts,
    /// Median over the frequencies of the rival's RMSE over the proposed model's, free run.
    pub bouc_wen_over_proposed: f64,
    /// The same for the model without g.
    pub truncated_over_proposed: f64,
    /// Lowest Fitting of the proposed model in free run, percent: identified for it, and recursively.
    pub lowest_fitting_percent: [f64; 2],
    /// Frequencies in Hz at which the exact law refused the proposed model.
    pub exact_refused_hz: Vec<f64>,
    /// Frequencies in Hz at which compensation by the printed law left more than a third of the
    /// reference's rms.
    pub degraded_hz: Vec<f64>,
    /// The 75 Hz line over the 25 Hz line: before and after compensation at 25 Hz.
    pub third_over_first_25_hz: [f64; 2],
}

/// A third of the reference's rms, mm.
pub const DEGRADED_MM: f64 = super::REFERENCE_MM * std::f64::consts::FRAC_1_SQRT_2 / 3.0;

type Of = fn(&Scores) -> Score;

fn counts(frequencies: &[AtFrequency], of: Of) -> Counts {
    let mut counts = Counts::default();
    for at in frequencies {
        let Comparison {
            proposed,
            truncated,
            bouc_wen,
        } = &at.models;
        let [full, short, rival] = [proposed, truncated, bouc_wen].map(|s| of(s).rmse_mm);
        if full <= short && full <= rival {
            counts.proposed += 1;
        } else if short <= rival {
            counts.truncated += 1;
        } else {
            counts.bouc_wen += 1;
        }
    }
    counts
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn facts(frequencies: &[AtFrequency], traces: &[Traces]) -> Result<Facts, Error> {
    let ratio = |frequency_hz: f64, above: f64, below: f64| {
        let traces = traces.iter().find(|t| t.frequency_hz == frequency_hz);
        let signal = traces.map_or(&[][..], |t| &t.displacement_mm);
        let at = |harmonic: f64| line(signal, SAMPLE_TIME_S, harmonic * frequency_hz);
        let (above, below) = (at(above).map_err(refused)?, at(below).map_err(refused)?);
        Ok::<_, Error>(above.amplitude / below.amplitude)
    };
    let peak = frequencies
        .iter()
        .max_by(|a, b| a.largest_mm.total_cmp(&b.largest_mm));
    Ok(Facts {
        resonance_hz: peak.map_or(f64::NAN, |at| at.frequency_hz),
        third_at_25_hz: ratio(25.0, 3.0, 1.0)?,
        third_at_35_hz: ratio(35.0, 3.0, 1.0)?,
        fifth_at_15_hz: ratio(15.0, 5.0, 3.0)?,
    })
}

impl Summary {
    /// Sums up.
    ///
    /// # Errors
    /// Signals without the frequencies that the facts are about.
    pub fn new(
        frequencies: &[AtFrequency],
        traces: &[Traces],
        studies: &Studies,
    ) -> Result<Self, Error> {
        let over = |of: fn(&Comparison) -> &Scores| {
            median(frequencies.iter().map(|at| {
                let proposed = at.models.proposed.free_run.rmse_mm;
                of(&at.models).free_run.rmse_mm / proposed
            }))
        };
        let lowest = |of: fn(&Scores) -> Option<Score>| {
            frequencies
                .iter()
                .filter_map(|at| of(&at.models.proposed))
                .fold(f64::INFINITY, |least, score| {
                    least.min(score.fitting_percent)
                })
        };
        let which = |keep: fn(&AtFrequency) -> bool| {
            let kept = frequencies.iter().filter(|at| keep(at));
            kept.map(|at| at.frequency_hz).collect()
        };
        let response = |harmonic: usize| {
            let found = studies.response_25_hz.iter();
            let found = found.filter(|at| at.harmonic == harmonic);
            found.map(|at| [at.before_mm, at.printed_mm]).next()
        };
        let third = response(3).zip(response(1));
        Ok(Self {
            facts: facts(frequencies, traces)?,
            best_in_free_run: counts(frequencies, |scores| scores.free_run),
            best_in_one_step: counts(frequencies, |scores| scores.one_step),
            bouc_wen_over_proposed: over(|models| &models.bouc_wen),
            truncated_over_proposed: over(|models| &models.truncated),
            lowest_fitting_percent: [
                lowest(|scores| Some(scores.free_run)),
                lowest(|scores| scores.recursive_free_run),
            ],
            exact_refused_hz: which(|at| at.proposed.exact.is_none()),
            degraded_hz: which(|at| at.proposed.printed.rms_error_mm > DEGRADED_MM),
            third_over_first_25_hz: third.map_or([f64::NAN; 2], |(third, first)| {
                [third[0] / first[0], third[1] / first[1]]
            }),
        })
    }
}
