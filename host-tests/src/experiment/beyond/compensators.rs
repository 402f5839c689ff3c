//! The compensators, their parameters identified from records of the plant.

use hysteron::dim::{Dim, Law};
use hysteron::hysteresis::preview::PlantRate;
use serde::Serialize;

use crate::dataset::{Dataset, Role};
use crate::error::Error;
use crate::experiment::m::model::{DIVISIONS, Model, Plane, Recipe};
use crate::experiment::m::record;
use crate::experiment::refused;
use crate::identify::{Effect, Options, identify};
use crate::model_file::ModelFile;
use crate::stage;

use super::inputs::Target;
use super::plants::Plant;
use super::records;

/// Seconds of the record that DIM is identified from at each frequency.
const DIM_RECORD_S: f64 = 3.0;
/// Micrometres in the unit of the modified play model.
const UM_PER_MM: f64 = 1e3;

/// A way from the reference to the drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Compensator {
    /// The reference over the mean gain.
    None,
    /// The inverse without a rate, identified from slow records.
    RateIndependent,
    /// The inverse with the rate of the reference.
    Explicit,
    /// Direct inverse multiplication as printed, identified at the frequency of the reference.
    DimPrinted,
    /// The same, solved within the sample.
    DimExact,
    /// The inverse with the rate of the drive itself.
    Preview,
    /// All stages undone, one set of parameters.
    Cascade,
}

/// All of them.
pub const COMPENSATORS: [Compensator; 7] = [
    Compensator::None,
    Compensator::RateIndependent,
    Compensator::Explicit,
    Compensator::DimPrinted,
    Compensator::DimExact,
    Compensator::Preview,
    Compensator::Cascade,
];

impl Compensator {
    /// Its name on a page.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::RateIndependent => "rate-independent",
            Self::Explicit => "explicit",
            Self::DimPrinted => "DIM printed",
            Self::DimExact => "DIM exact",
            Self::Preview => "preview",
            Self::Cascade => "cascade",
        }
    }
}

/// What was identified on a plant, once for all references.
#[derive(Clone, Debug)]
pub struct Identified {
    plant: Plant,
    /// Mean gain in um/V and offset in um.
    line: (f64, f64),
    /// From slow records.
    rate_independent: ModelFile,
    /// From loops at several frequencies.
    rate_dependent: ModelFile,
    /// With the effects around the hysteresis.
    pub cascade: ModelFile,
}

/// The model of the cascade of a plant, from ten seconds of records.
///
/// # Errors
/// Records that cannot be measured or fitted.
pub fn cascade(plant: Plant) -> Result<ModelFile, Error> {
    let options = Options {
        effects: match plant {
            Plant::Plays => vec![Effect::AmplifierLag],
            Plant::Relays | Plant::Bimorph => vec![
                Effect::AmplifierLag,
                Effect::TransportDelay,
                Effect::OutputQuadratic,
                Effect::Resonance,
            ],
        },
        beta: Some(plant == Plant::Plays),
        ..Options::default()
    };
    Ok(identify(&records::broadband(plant)?, &options, &|_| {})?.model)
}

impl Identified {
    /// Measures a plant and identifies everything but DIM.
    ///
    /// # Errors
    /// Records that cannot be measured or fitted.
    pub fn new(plant: Plant) -> Result<Self, Error> {
        let slow = records::slow(plant)?;
        let without_rate = Options {
            beta: Some(false),
            ..Options::default()
        };
        let found = |dataset: &Dataset, options: &Options| {
            Ok::<_, Error>(identify(dataset, options, &|_| {})?.model)
        };
        let ((rate_independent, rate_dependent), cascade) = rayon::join(
            || {
                (
                    found(&slow, &without_rate),
                    records::loops(plant).and_then(|loops| found(&loops, &Options::default())),
                )
            },
            || cascade(plant),
        );
        Ok(Self {
            plant,
            line: line(&slow),
            rate_independent: rate_independent?,
            rate_dependent: rate_dependent?,
            cascade: cascade?,
        })
    }

    /// beta of the explicit and of the preview inverse, s.
    pub fn beta_s(&self) -> f64 {
        self.rate_dependent
            .hysteresis()
            .map_or(0.0, |found| found.beta_s)
    }

    /// The drive in V along a reference; `dim` is the modified play model at its frequency, which the
    /// two laws of DIM need.
    ///
    /// # Errors
    /// A model that has no such inverse, or is not there.
    pub fn drive(
        &self,
        compensator: Compensator,
        dim: Option<&Model>,
        target: &Target,
    ) -> Result<Vec<f64>, Error> {
        let dim = || dim.ok_or_else(|| refused("no model at this frequency"));
        let (h, reference) = (target.sample_time_s, &target.samples);
        match compensator {
            Compensator::None => {
                let (gain, offset) = self.line;
                Ok(reference.iter().map(|v| (v - offset) / gain).collect())
            }
            Compensator::RateIndependent => stage::drive(&self.rate_independent, h, reference),
            Compensator::Explicit => stage::drive(&self.rate_dependent, h, reference),
            Compensator::Preview => {
                let preview =
                    stage::preview_compensator(&self.rate_dependent, h, PlantRate::Midpoint)?;
                stage::compensate_ahead(&preview, reference).map_err(refused)
            }
            Compensator::Cascade => stage::drive_ahead(&self.cascade, h, reference),
            Compensator::DimPrinted => dim_drive(self.plant, dim()?, Law::Printed, reference),
            Compensator::DimExact => dim_drive(self.plant, dim()?, Law::Exact, reference),
        }
    }
}

/// Gain and offset of the line through the fit records with the least squares.
fn line(dataset: &Dataset) -> (f64, f64) {
    let samples = || {
        let records = dataset.with_role(Role::Fit);
        records.flat_map(|record| record.drive_v.iter().zip(&record.displacement_um))
    };
    let count = samples().count().max(1) as f64;
    let mean_u = samples().map(|(u, _)| u).sum::<f64>() / count;
    let mean_y = samples().map(|(_, y)| y).sum::<f64>() / count;
    let (mut both, mut square) = (0.0, 0.0);
    for (u, y) in samples() {
        both += (u - mean_u) * (y - mean_y);
        square += (u - mean_u) * (u - mean_u);
    }
    let gain = both / square;
    (gain, mean_y - gain * mean_u)
}

/// The modified play model of a plant at one frequency, identified as in paper M: recursively, under a
/// sine of full drive.
///
/// # Errors
/// A drive or a model that is refused.
pub fn dim_model(plant: Plant, frequency_hz: f64) -> Result<Model, Error> {
    let h = plant.sample_time_s();
    let samples = (DIM_RECORD_S / h).round() as usize;
    let drive: Vec<f64> = (0..samples)
        .map(|k| (std::f64::consts::TAU * frequency_hz * k as f64 * h).sin())
        .collect();
    let volts: Vec<f64> = drive.iter().map(|u| plant.full_drive_v() * u).collect();
    let displacement = plant
        .device(frequency_hz as u64)
        .run(&volts, h)
        .map_err(refused)?;
    let record = record::Record {
        frequency_hz,
        drive,
        displacement_mm: displacement.iter().map(|um| um / UM_PER_MM).collect(),
    };
    let recipe = Recipe {
        sample_time_s: h,
        ..Recipe::PROPOSED
    };
    recipe.model(frequency_hz, &recipe.identify(&record)?)
}

/// The drive in V of direct inverse multiplication.
///
/// # Errors
/// A model that the law cannot invert.
pub fn dim_drive(
    plant: Plant,
    model: &Model,
    law: Law,
    reference_um: &[f64],
) -> Result<Vec<f64>, Error> {
    let dim = match law {
        Law::Printed => Dim::<f64, DIVISIONS, Plane>::printed(*model),
        Law::Exact => Dim::exact(*model),
    }
    .map_err(|reason| Error::request(format!("no inverse: {reason}")))?;
    let mut state = dim.start();
    let drive = reference_um
        .iter()
        .map(|v| dim.step(&mut state, v / UM_PER_MM));
    let parts = drive.collect::<Result<Vec<_>, _>>().map_err(refused)?;
    Ok(parts.iter().map(|u| plant.full_drive_v() * u).collect())
}
