//! From a model file to the model and compensator of the core, in double precision.

use hysteron::effect::asymmetry::{Asymmetry, Side};
mod effects;

use hysteron::error::{Field, ParameterError, SampleError};
use hysteron::hysteresis::Parameters;
use hysteron::hysteresis::preview::{PlantRate, PreviewSettings, window_for};

use crate::error::Error;
use crate::model_file::{self, ModelFile, TwoSided};
use crate::modified_play;

pub(crate) use effects::effects;

/// Most plays a model of the host may have.
pub const PLAYS: usize = 128;
/// Most dead zones on each side of a map.
pub const CORNERS: usize = 16;

/// A stage as the host computes it.
pub type Model = hysteron::model::Model<f64, PLAYS, CORNERS>;
/// Most reference samples a preview inverse of the host looks at.
pub const WINDOW: usize = 512;
/// Sweeps of a preview inverse of the host: one more than a target needs, for rates that jump.
const SWEEPS: usize = 2;

/// Its inverse.
pub type Compensator = hysteron::compensator::Compensator<f64, PLAYS, CORNERS>;

/// The same with a preview of the reference.
pub type PreviewCompensator =
    hysteron::compensator::PreviewCompensator<f64, PLAYS, CORNERS, WINDOW>;

/// A stage with the effects around its hysteresis.
pub type Chain = hysteron::chain::Chain<f64, PLAYS, CORNERS>;
/// Most reference samples that the preview inverse of a cascade looks at: the state of a cascade is
/// built on the stack of a thread.
pub const CASCADE_WINDOW: usize = 128;
/// Its inverse.
pub type Cascade = hysteron::cascade::Cascade<f64, PLAYS, CORNERS, CASCADE_WINDOW, true>;

/// The model for samples that are `sample_time_s` seconds apart.
///
/// # Errors
/// A parameter that the core refuses, named by its key; a modified play model, which has no stages.
pub fn model(file: &ModelFile, sample_time_s: f64) -> Result<Model, Error> {
    if file.modified_play().is_some() {
        return Err(Error::request(format!(
            "model \"{}\" is a modified play model; this needs one with a hysteresis stage",
            file.name
        )));
    }
    build(file, sample_time_s).map_err(|refused| {
        Error::request(format!(
            "model \"{}\": {refused}; correct it in the model file",
            file.name
        ))
    })
}

/// The inverse of [`model`].
///
/// # Errors
/// As [`model`], parameters of the inverse that leave the range of numbers, a rate law, a congruency
/// or elements, which only the [`cascade`] undoes.
pub fn compensator(file: &ModelFile, sample_time_s: f64) -> Result<Compensator, Error> {
    plain_core(file)?;
    model(file, sample_time_s)?
        .compensator()
        .map_err(|refused| {
            Error::request(format!("model \"{}\" has no inverse: {refused}", file.name))
        })
}

/// Refuses a model whose hysteresis is not an operator of its own.
fn plain_core(file: &ModelFile) -> Result<(), Error> {
    match file.core_effects().next() {
        Some(stage) => Err(Error::request(format!(
            "model \"{}\" has a stage {}, without which its hysteresis means something else; use \
             the cascade",
            file.name,
            stage.name()
        ))),
        None => Ok(()),
    }
}

/// The model of a file with all effects of its stages.
///
/// # Errors
/// As [`model`].
pub fn chain(file: &ModelFile, sample_time_s: f64) -> Result<Chain, Error> {
    let model = model(file, sample_time_s)?;
    let effects = effects(&file.stages, sample_time_s).map_err(|(stage, refused)| {
        Error::request(format!(
            "model \"{}\": {stage}.{refused}; correct it in the model file",
            file.name
        ))
    })?;
    Ok(Chain::new(model, effects))
}

/// The inverse of [`chain`], with a preview inverse where there is a linear rate term.
///
/// # Errors
/// As [`chain`], and parameters of the inverse that leave the range of numbers.
pub fn cascade(file: &ModelFile, sample_time_s: f64) -> Result<Cascade, Error> {
    let chain = chain(file, sample_time_s)?;
    let hysteresis = chain.model().hysteresis();
    let window = window_for(hysteresis);
    let ahead = hysteresis.beta() > 0.0 && file.core_effects().next().is_none();
    if ahead && window > CASCADE_WINDOW {
        return Err(Error::request(format!(
            "model \"{}\": the cascade would have to look {window} samples ahead and can {CASCADE_WINDOW}; \
             sample the reference more slowly or use another inverse",
            file.name
        )));
    }
    let preview = ahead.then_some(PreviewSettings {
        window,
        sweeps: SWEEPS,
        plant_rate: PlantRate::Midpoint,
    });
    Cascade::new(&chain, preview).map_err(|refused| {
        Error::request(format!("model \"{}\" has no inverse: {refused}", file.name))
    })
}

/// The drive in volts of the [`cascade`] of a model file for a reference in micrometres, aligned with
/// it: the reference rests at its last sample for as long as the cascade looks ahead.
///
/// # Errors
/// As [`cascade`]; a reference that is not finite.
pub fn drive_ahead(
    file: &ModelFile,
    sample_time_s: f64,
    reference: &[f64],
) -> Result<Vec<f64>, Error> {
    let cascade = cascade(file, sample_time_s)?;
    let refused = |refused: SampleError| Error::request(format!("the reference: {refused}"));
    let Some(&first) = reference.first() else {
        return Ok(Vec::new());
    };
    let mut state = Box::new(cascade.start(first).map_err(refused)?);
    in_line(reference, cascade.latency(), |v| {
        cascade.step(&mut state, v)
    })
    .map_err(refused)
}

/// The drive in volts for a reference in micrometres through a model file of any kind, from rest.
///
/// # Errors
/// As [`compensator`] and [`modified_play::compensator`]; a reference that is not finite.
pub fn drive(file: &ModelFile, sample_time_s: f64, reference: &[f64]) -> Result<Vec<f64>, Error> {
    let refused = |refused: SampleError| Error::request(format!("the reference: {refused}"));
    if file.modified_play().is_some() {
        let dim = modified_play::compensator(file, sample_time_s)?;
        let mut state = dim.start();
        let drive = reference.iter().map(|&y| dim.step(&mut state, y));
        return drive.collect::<Result<_, _>>().map_err(refused);
    }
    compensate(&compensator(file, sample_time_s)?, reference).map_err(refused)
}

/// The displacement in micrometres for a finite drive in volts by a model file of any kind, from rest.
///
/// # Errors
/// As [`model`] and [`modified_play::model`].
pub fn displacement(
    file: &ModelFile,
    sample_time_s: f64,
    drive: &[f64],
) -> Result<Vec<f64>, Error> {
    if file.modified_play().is_some() {
        let model = modified_play::model(file, sample_time_s)?;
        let mut state = model.start();
        return Ok(drive.iter().map(|&u| model.step(&mut state, u)).collect());
    }
    let chain = chain(file, sample_time_s)?;
    let Some(&first) = drive.first() else {
        return Ok(Vec::new());
    };
    let mut state = chain.start(first);
    Ok(drive.iter().map(|&u| chain.step(&mut state, u)).collect())
}

/// The preview inverse of [`model`], its window as long as the model needs.
///
/// # Errors
/// As [`compensator`]; a model that needs more than [`WINDOW`] samples or has no preview inverse.
pub fn preview_compensator(
    file: &ModelFile,
    sample_time_s: f64,
    plant_rate: PlantRate,
) -> Result<PreviewCompensator, Error> {
    plain_core(file)?;
    let model = model(file, sample_time_s)?;
    let window = window_for(model.hysteresis());
    if window > WINDOW {
        return Err(Error::request(format!(
            "model \"{}\": a preview inverse would have to look {window} samples ahead and can {WINDOW}; \
             sample the reference more slowly or use the explicit inverse",
            file.name
        )));
    }
    let settings = PreviewSettings {
        window,
        sweeps: SWEEPS,
        plant_rate,
    };
    model.preview_compensator(settings).map_err(|refused| {
        Error::request(format!(
            "model \"{}\" has no preview inverse: {refused}",
            file.name
        ))
    })
}

/// As [`compensate`], with a preview: drives in line with the reference, which rests before its first
/// and after its last sample.
///
/// # Errors
/// A reference that is not finite.
pub fn compensate_ahead(
    compensator: &PreviewCompensator,
    reference: &[f64],
) -> Result<Vec<f64>, SampleError> {
    let Some(&first) = reference.first() else {
        return Ok(Vec::new());
    };
    // Too large for the stack of a thread.
    let mut state = Box::new(compensator.start(first)?);
    in_line(reference, compensator.latency(), |v| {
        compensator.step(&mut state, v)
    })
}

/// Drives in line with a reference that rests at its last sample for as long as `step` looks ahead.
fn in_line(
    reference: &[f64],
    latency: usize,
    step: impl FnMut(f64) -> Result<f64, SampleError>,
) -> Result<Vec<f64>, SampleError> {
    let rest = reference
        .last()
        .map(|&last| std::iter::repeat_n(last, latency));
    let ahead = reference.iter().copied().chain(rest.into_iter().flatten());
    let mut drive = ahead.map(step).collect::<Result<Vec<f64>, _>>()?;
    drive.drain(..latency.min(drive.len()));
    Ok(drive)
}

/// The drive in volts for a reference in micrometres, from plays at zero.
///
/// # Errors
/// A reference that is not finite.
pub fn compensate(compensator: &Compensator, reference: &[f64]) -> Result<Vec<f64>, SampleError> {
    let Some(&first) = reference.first() else {
        return Ok(Vec::new());
    };
    let mut state = compensator.start(first)?;
    reference
        .iter()
        .map(|&v| compensator.step(&mut state, v))
        .collect()
}

/// The displacement in micrometres for a finite drive in volts, from plays at zero.
pub fn simulate(model: &Model, drive: &[f64]) -> Vec<f64> {
    let Some(&first) = drive.first() else {
        return Vec::new();
    };
    let mut state = model.start(first);
    drive.iter().map(|&u| model.step(&mut state, u)).collect()
}

/// As [`simulate`], with the rate of the step to come; the drive rests after its last sample.
pub fn simulate_forward(model: &Model, drive: &[f64]) -> Vec<f64> {
    let (Some(&first), Some(&last)) = (drive.first(), drive.last()) else {
        return Vec::new();
    };
    let mut state = model.start(first);
    // To the admissible state next to zero, whatever the first step is.
    model.step_with_rate(&mut state, first, 0.0);
    let next = drive.iter().skip(1).chain([&last]);
    drive
        .iter()
        .zip(next)
        .map(|(&u, next)| {
            let rate = (next - u) / model.hysteresis().sample_time();
            model.step_with_rate(&mut state, u, rate)
        })
        .collect()
}

/// The drive joined by straight lines and sampled `factor` times finer; the first and the last sample
/// stay. A factor of zero is taken as one.
pub fn refine(drive: &[f64], factor: usize) -> Vec<f64> {
    let factor = factor.max(1);
    let lines = drive.windows(2).flat_map(|pair| {
        (1..=factor).map(|i| {
            let share = i as f64 / factor as f64;
            pair[0] + (pair[1] - pair[0]) * share
        })
    });
    drive.first().copied().into_iter().chain(lines).collect()
}

fn build(file: &ModelFile, sample_time_s: f64) -> Result<Model, ParameterError> {
    let Some(hysteresis) = file.hysteresis() else {
        return Err(ParameterError::Length(Field::Weights));
    };
    let operator = Parameters {
        weights: &hysteresis.weights,
        thresholds: &hysteresis.thresholds_v,
        beta: hysteresis.beta_s,
    }
    .build(sample_time_s)?;
    let map = file.asymmetry().map(asymmetry);
    let (gain, offset) = file.output();
    Model::new(operator, map.transpose()?, gain, offset)
}

/// The map of a file's stage.
pub(crate) fn asymmetry(
    map: &model_file::Asymmetry,
) -> Result<Asymmetry<f64, CORNERS>, ParameterError> {
    let side = |of: fn(&TwoSided) -> &Vec<f64>| Side {
        slopes: of(&map.slopes),
        thresholds: of(&map.thresholds),
    };
    Asymmetry::new(side(|s| &s.positive), side(|s| &s.negative))
}
