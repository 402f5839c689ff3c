//! Every compensator on every plant along every reference, and again on plants that are 10 % off.

use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::metrics::{max_abs_error, rms, rms_error};

use super::compensators::{COMPENSATORS, Compensator, Identified, dim_model};
use super::inputs::{Input, Target, inputs, target};
use super::plants::{Device, Plant};

/// So many wrong plants are drawn; odd, so that the median is one of them.
pub const WRONG_PLANTS: u64 = 5;
/// Seed of the sensor's noise while a plant is compensated.
const NOISE: u64 = 1_000;

/// How far a plant stays from the reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Rms, um.
    pub rms_um: f64,
    /// Largest, um.
    pub largest_um: f64,
    /// Rms over that of the reference, %.
    pub rms_percent: f64,
    /// Largest over the amplitude of the reference, %.
    pub largest_percent: f64,
}

/// What became of a compensator.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "status", rename_all = "snake_case")]
pub enum Outcome {
    /// It ran.
    Followed {
        /// Its errors.
        #[serde(flatten)]
        errors: Errors,
    },
    /// It ran, and left more than a plant that stands still.
    Lost {
        /// Its errors.
        #[serde(flatten)]
        errors: Errors,
        /// What happened.
        reason: String,
    },
    /// There is no such compensator, or the plant refused its drive.
    Refused {
        /// Why.
        reason: String,
    },
}

impl Outcome {
    /// The errors, if it ran.
    pub fn errors(&self) -> Option<&Errors> {
        match self {
            Self::Followed { errors } | Self::Lost { errors, .. } => Some(errors),
            Self::Refused { .. } => None,
        }
    }

    /// The rms error in um, if it ran; NaN, which is drawn as a gap, if not.
    pub fn rms_um(&self) -> f64 {
        self.errors().map_or(f64::NAN, |errors| errors.rms_um)
    }

    fn new(errors: Result<Errors, String>, drive: &[f64], full_v: f64) -> Self {
        match errors {
            Err(reason) => Self::Refused { reason },
            Ok(errors) if errors.rms_percent > 100.0 => {
                let at_end = drive.iter().filter(|u| u.abs() >= full_v).count();
                let share = 100.0 * at_end as f64 / drive.len().max(1) as f64;
                let reason = if share > 1.0 {
                    format!("the drive is beyond {full_v} V for {share:.0} % of the time")
                } else {
                    "what it adds is larger than the reference".to_owned()
                };
                Self::Lost { errors, reason }
            }
            Ok(errors) => Self::Followed { errors },
        }
    }
}

/// One compensator on one plant along one reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Entry {
    /// The compensator.
    pub compensator: Compensator,
    /// On the plant that it was identified on.
    pub identified: Outcome,
    /// On plants whose parameters are all 10 % off: the median of the draws.
    pub wrong: Outcome,
}

/// All compensators on one plant along one reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// The plant.
    pub plant: Plant,
    /// The reference.
    #[serde(flatten)]
    pub input: Input,
    /// One a compensator.
    pub entries: Vec<Entry>,
}

impl Row {
    /// The entry of a compensator.
    pub fn entry(&self, compensator: Compensator) -> Option<&Entry> {
        let mut entries = self.entries.iter();
        entries.find(|entry| entry.compensator == compensator)
    }

    /// Compensator and rms error in um of the entry with the least one, by `of` its outcomes.
    pub fn best(&self, of: fn(&Entry) -> &Outcome) -> Option<(Compensator, f64)> {
        self.entries
            .iter()
            .filter_map(|entry| Some((entry.compensator, of(entry).errors()?.rms_um)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    }
}

/// Every reference of a plant for which `wanted` says so; `done` is called once a reference.
///
/// # Errors
/// A reference or plant that cannot be made.
pub fn run(
    plant: Plant,
    identified: &Identified,
    wanted: &(dyn Fn(&Input) -> bool + Sync),
    done: &(dyn Fn() + Sync),
) -> Result<Vec<Row>, Error> {
    let inputs: Vec<Input> = inputs(plant).into_iter().filter(wanted).collect();
    inputs
        .into_par_iter()
        .map(|input| row(plant, identified, input))
        .inspect(|_| done())
        .collect()
}

fn row(plant: Plant, identified: &Identified, input: Input) -> Result<Row, Error> {
    let target = target(plant, input)?;
    let dim = dim_model(plant, input.frequency_hz)?;
    let nominal = plant.device(NOISE);
    let wrong: Vec<Device> = (1..=WRONG_PLANTS).map(|seed| plant.wrong(seed)).collect();
    // One after the other: their states are large, and a thread that waits for one would begin the next
    // on the same stack.
    let entries = COMPENSATORS
        .into_iter()
        .map(|compensator| {
            let drive = identified.drive(compensator, Some(&dim), &target);
            let drive = match drive {
                Ok(drive) => drive,
                Err(reason) => {
                    let refused = Outcome::Refused {
                        reason: reason.to_string(),
                    };
                    return Entry {
                        compensator,
                        identified: refused.clone(),
                        wrong: refused,
                    };
                }
            };
            let full_v = plant.full_drive_v();
            let outcome = |errors| Outcome::new(errors, &drive, full_v);
            let draws: Result<Vec<Errors>, String> = wrong
                .iter()
                .map(|device| errors(device, &drive, &target))
                .collect();
            Entry {
                compensator,
                identified: outcome(errors(&nominal, &drive, &target)),
                wrong: outcome(draws.map(|draws| median(&draws))),
            }
        })
        .collect();
    Ok(Row {
        plant,
        input,
        entries,
    })
}

/// What a plant leaves along a target.
///
/// # Errors
/// A drive that the plant refuses, in words.
fn errors(device: &Device, drive: &[f64], target: &Target) -> Result<Errors, String> {
    let displacement = device
        .run(drive, target.sample_time_s)
        .map_err(|reason| reason.to_string())?;
    score(&displacement, target)
}

/// The errors of a displacement along a target.
///
/// # Errors
/// A displacement that is not finite, in words.
pub fn score(displacement: &[f64], target: &Target) -> Result<Errors, String> {
    let wanted = &target.samples[target.scored.clone()];
    let found = &displacement[target.scored.clone()];
    let words = |reason: crate::metrics::MetricError| reason.to_string();
    let rms_um = rms_error(wanted, found).map_err(words)?;
    let largest_um = max_abs_error(wanted, found).map_err(words)?;
    Ok(Errors {
        rms_um,
        largest_um,
        rms_percent: 100.0 * rms_um / rms(wanted).map_err(words)?,
        largest_percent: 100.0 * largest_um / target.amplitude_um,
    })
}

/// The median of several draws, each figure by itself.
pub fn median(draws: &[Errors]) -> Errors {
    let of = |figure: fn(&Errors) -> f64| {
        let mut figures: Vec<f64> = draws.iter().map(figure).collect();
        figures.sort_by(f64::total_cmp);
        figures.get(figures.len() / 2).copied().unwrap_or(f64::NAN)
    };
    Errors {
        rms_um: of(|errors| errors.rms_um),
        largest_um: of(|errors| errors.largest_um),
        rms_percent: of(|errors| errors.rms_percent),
        largest_percent: of(|errors| errors.largest_percent),
    }
}
