//! From a model file with a `modified-play` stage to the core's model and DIM compensator, in double
//! precision.

use hysteron::dim::{Dim, Law};
use hysteron::error::{Field, ParameterError};
use hysteron::hysteresis::modified_play::{BasisParameters, LinearPlane, ModifiedPlay, Terms};

use crate::error::Error;
use crate::model_file::ModelFile;

/// Most divisions of the plane.
pub const DIVISIONS: usize = 16;
/// How far the sample time of the data may be from that of the model, over it.
pub const SAMPLE_TIME_TOLERANCE: f64 = 1e-4;

/// The collapsed plane as the host computes it.
pub type Plane = LinearPlane<f64, DIVISIONS>;
/// The model.
pub type Model = ModifiedPlay<f64, DIVISIONS, Plane>;
/// Its compensator.
pub type Compensator = Dim<f64, DIVISIONS, Plane>;

/// The model for samples that are `sample_time_s` seconds apart.
///
/// # Errors
/// A file of another kind, a sample time that is not the model's, or a parameter that the core refuses,
/// named by its key.
pub fn model(file: &ModelFile, sample_time_s: f64) -> Result<Model, Error> {
    if let Some(stage) = file.modified_play() {
        let apart = (stage.sample_time_s - sample_time_s).abs();
        if apart > SAMPLE_TIME_TOLERANCE * sample_time_s {
            return Err(Error::request(format!(
                "model \"{}\" holds for samples {} s apart, not {sample_time_s} s; resample the data or \
                 identify the model anew",
                file.name, stage.sample_time_s
            )));
        }
    }
    build(file).map_err(|refused| {
        Error::request(format!(
            "model \"{}\": {refused}; correct it in the model file",
            file.name
        ))
    })
}

/// The compensator of [`model`], by the law that the file names.
///
/// # Errors
/// As [`model`], and a model that this law cannot invert.
pub fn compensator(file: &ModelFile, sample_time_s: f64) -> Result<Compensator, Error> {
    let model = model(file, sample_time_s)?;
    let dim = match file.modified_play().map(|stage| stage.law.into()) {
        Some(Law::Exact) => Dim::exact(model),
        _ => Dim::printed(model),
    };
    dim.map_err(|refused| {
        Error::request(format!("model \"{}\" has no inverse: {refused}", file.name))
    })
}

fn build(file: &ModelFile) -> Result<Model, ParameterError> {
    let stage = file
        .modified_play()
        .ok_or(ParameterError::Length(Field::Slopes))?;
    let basis = BasisParameters {
        u_max: stage.u_max_v,
        divisions: stage.slopes_um_per_v.len(),
        alpha: stage.alpha_s,
        beta: stage.beta_s,
        harmonics: stage.harmonics.into(),
        frequency: stage.frequency_hz,
    }
    .build(stage.sample_time_s)?;
    let plane = LinearPlane::new(basis.grid(), &stage.slopes_um_per_v, stage.offset_um)?;
    let terms = Terms {
        interleaving: stage.interleaving_per_v,
        feedback: stage.feedback,
        sine: stage.sine,
        cosine: stage.cosine,
    };
    ModifiedPlay::new(&basis, plane, terms)
}
