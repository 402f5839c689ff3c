//! Hysteresis percent of steady loops.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::references::{Grid, sine};
use crate::experiment::refused;
use crate::metrics::hysteresis_percent;
use crate::model_file::ModelFile;
use crate::{plant, stage};

use super::plants::lag_removed;
use super::published::{HYSTERESIS_PERCENT, LOOP_FREQUENCIES_HZ};
use super::{AMPLITUDE, SAMPLE_TIME_S};

/// Hysteresis percent at one frequency: largest loop width over the range of the output.
#[derive(Clone, Debug, Serialize)]
pub struct Percent {
    /// Frequency in Hz of the drive.
    pub frequency_hz: f64,
    /// Of the model with the corrected constants.
    pub model: f64,
    /// Of the simulated stage against the commanded drive.
    pub stage: f64,
    /// The same after the amplifier lag is taken out of the displacement.
    pub stage_lag_removed: f64,
    /// As printed, of the measured stage.
    pub published: f64,
    /// The loops.
    #[serde(skip)]
    pub loops: Loops,
}

/// One steady period: samples that belong together.
#[derive(Clone, Debug)]
pub struct Loops {
    /// Drive in V.
    pub drive: Vec<f64>,
    /// Displacement of the model in um.
    pub model: Vec<f64>,
    /// Displacement of the simulated stage in um, lag removed.
    pub stage: Vec<f64>,
}

/// The percentages at the published frequencies; the second of three periods is taken.
///
/// # Errors
/// A model, signal or stage that is refused.
pub fn percents(file: &ModelFile) -> Result<Vec<Percent>, Error> {
    LOOP_FREQUENCIES_HZ
        .into_iter()
        .zip(HYSTERESIS_PERCENT)
        .map(|(frequency_hz, published)| {
            let grid = Grid::for_cycles(SAMPLE_TIME_S, frequency_hz, 3.0).map_err(refused)?;
            let drive = sine(&grid, AMPLITUDE, frequency_hz, 0.0)
                .map_err(refused)?
                .samples;
            let model = stage::simulate(&stage::model(file, SAMPLE_TIME_S)?, &drive);
            let measured = plant::Stage::p753()
                .run(&drive, SAMPLE_TIME_S)
                .map_err(refused)?;
            let removed = lag_removed(&measured, SAMPLE_TIME_S);
            let period = drive.len() / 3..drive.len() / 3 * 2;
            let percent = |output: &[f64]| {
                hysteresis_percent(&drive[period.clone()], &output[period.clone()]).map_err(refused)
            };
            Ok(Percent {
                frequency_hz,
                model: percent(&model)?,
                stage: percent(&measured)?,
                stage_lag_removed: percent(&removed)?,
                published,
                loops: Loops {
                    drive: drive[period.clone()].to_vec(),
                    model: model[period.clone()].to_vec(),
                    stage: removed[period.clone()].to_vec(),
                },
            })
        })
        .collect()
}
