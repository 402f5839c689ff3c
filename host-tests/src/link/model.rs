//! A model file as the target takes it: the same stages in single precision.

use hysteron::record::{DEAD_ZONES, ModelRecord, PLAYS, Stage, Zones};
use hysteron::settings::Settings;

use super::refusal;
use crate::error::Error;
use crate::model_file::{self, ModelFile};

/// The record for a target with these settings, judged as the target will judge it.
///
/// # Errors
/// More plays or dead zones than the target has room for, or a compensator that does not exist in
/// single precision.
pub fn record(file: &ModelFile, settings: &Settings) -> Result<ModelRecord, Error> {
    let mut record = ModelRecord::default();
    for stage in &file.stages {
        let stage = convert(stage)
            .map_err(|problem| Error::request(format!("model \"{}\" {problem}", file.name)))?;
        record
            .stages
            .push(stage)
            .map_err(|_| Error::request(format!("model \"{}\" has too many stages", file.name)))?;
    }
    record
        .compensator(1.0 / settings.sample_rate_hz)
        .map_err(|error| Error::request(refusal::model(error)))?;
    Ok(record)
}

fn convert(stage: &model_file::Stage) -> Result<Stage, String> {
    Ok(match stage {
        model_file::Stage::Hysteresis(hysteresis) => {
            let plays = hysteresis.thresholds_v.len();
            let room = || {
                format!(
                    "has {plays} plays and the target room for {PLAYS}; identify it with --plays \
                     {PLAYS}"
                )
            };
            Stage::Hysteresis {
                thresholds_v: numbers(&hysteresis.thresholds_v).ok_or_else(room)?,
                weights: numbers(&hysteresis.weights).ok_or_else(room)?,
                beta_s: hysteresis.beta_s as f32,
            }
        }
        model_file::Stage::Asymmetry(asymmetry) => {
            let side = |thresholds: &[f64], slopes: &[f64]| {
                Some(Zones {
                    thresholds: numbers(thresholds)?,
                    slopes: numbers(slopes)?,
                })
            };
            let room = || {
                format!(
                    "has more dead zones on a side than the target has room for ({DEAD_ZONES}); \
                     identify it with --asymmetry none"
                )
            };
            let (thresholds, slopes) = (&asymmetry.thresholds, &asymmetry.slopes);
            Stage::Asymmetry {
                positive: side(&thresholds.positive, &slopes.positive).ok_or_else(room)?,
                negative: side(&thresholds.negative, &slopes.negative).ok_or_else(room)?,
            }
        }
        model_file::Stage::Output(output) => Stage::Output {
            gain_um_per_v: output.gain_um_per_v as f32,
            offset_um: output.offset_um as f32,
        },
        model_file::Stage::ModifiedPlay(model) => Stage::ModifiedPlay {
            u_max_v: model.u_max_v as f32,
            slopes_um_per_v: numbers(&model.slopes_um_per_v).ok_or_else(|| {
                format!(
                    "has {} slopes and the target room for {PLAYS}; identify it with fewer",
                    model.slopes_um_per_v.len()
                )
            })?,
            offset_um: model.offset_um as f32,
            alpha_s: model.alpha_s as f32,
            beta_s: model.beta_s as f32,
            interleaving_per_v: model.interleaving_per_v as f32,
            feedback: model.feedback.map(|c| c as f32),
            frequency_hz: model.frequency_hz as f32,
            harmonics: model.harmonics.into(),
            sine: model.sine.map(|a| a as f32),
            cosine: model.cosine.map(|a| a as f32),
            sample_time_s: model.sample_time_s as f32,
            law: model.law.into(),
        },
        effect => {
            return Err(format!(
                "has a stage {}, which the firmware does not undo; upload a model without it",
                effect.name()
            ));
        }
    })
}

fn numbers<const N: usize>(values: &[f64]) -> Option<heapless::Vec<f32, N>> {
    let mut numbers = heapless::Vec::new();
    for &value in values {
        numbers.push(value as f32).ok()?;
    }
    Some(numbers)
}
