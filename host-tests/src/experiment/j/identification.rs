//! The authors' identification: three loops of 200 points, weighted by hysteresis percent.

use serde::Serialize;

use crate::dataset::{Dataset, LengthUnit, Record, Role, Zero};
use crate::error::Error;
use crate::experiment::references::{Grid, sine};
use crate::experiment::refused;
use crate::identify::{Options, RecordWeights, Thresholds, identify};
use crate::metrics::{hysteresis_percent, max_abs_error};
use crate::model_file::ModelFile;
use crate::plant::Stage;
use crate::stage;

use super::plants::lag_removed;
use super::published::LOOP_FREQUENCIES_HZ;
use super::sweep::{FREQUENCIES_HZ, reference};
use super::{AMPLITUDE, SAMPLE_TIME_S};

/// Points of a loop.
const POINTS: u32 = 200;

/// Constants found from the three loops of one stage.
#[derive(Clone, Debug, Serialize)]
pub struct Identified {
    /// a_0 to a_3 in um/V.
    pub weights: Vec<f64>,
    /// Spacing of the thresholds in V.
    pub zeta_v: f64,
    /// Rate term in s.
    pub beta_s: f64,
    /// Weights A_p of the loops.
    pub record_weights: Vec<f64>,
    /// Rms residual over the three loops in um.
    pub rms_um: f64,
    /// The identified model.
    #[serde(skip)]
    pub model: ModelFile,
}

/// Largest error of the stage under the inverse of the model that was identified from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Compensated {
    /// Frequency in Hz of the reference.
    pub frequency_hz: f64,
    /// Largest error in um, the lag removed.
    pub rate_dependent: f64,
}

/// What the identification gives.
#[derive(Clone, Debug, Serialize)]
pub struct Identifications {
    /// From the corrected model's own loops without noise: what it should find again.
    pub from_model: Identified,
    /// From the simulated stage with noise, the lag removed by hand.
    pub from_stage: Identified,
    /// The simulated stage under the inverse of `from_stage`.
    pub largest_error_um: Vec<Compensated>,
}

/// Identifies both stages and drives the simulated one with what was found.
///
/// # Errors
/// A signal or stage that is refused, records that cannot be identified.
pub fn run() -> Result<Identifications, Error> {
    let published_recursion = Stage {
        oversample: 1,
        ..Stage::p753_three_plays()
    };
    let from_model = identified(records(|frequency_hz| {
        let h = 1.0 / (f64::from(POINTS) * frequency_hz);
        steady_loop(&published_recursion, frequency_hz, h, 1)
    })?)?;
    let from_stage = identified(records(|frequency_hz| {
        // The stage is driven at 10 kHz or more; of a slow loop every so many samples are kept.
        let every = (1.0 / (SAMPLE_TIME_S * f64::from(POINTS) * frequency_hz))
            .ceil()
            .max(1.0);
        let h = 1.0 / (f64::from(POINTS) * frequency_hz * every);
        steady_loop(&Stage::p753(), frequency_hz, h, every as usize)
    })?)?;
    let largest_error_um = FREQUENCIES_HZ
        .into_iter()
        .map(|frequency_hz| {
            let (reference, settled) = reference(frequency_hz)?;
            let h = reference.sample_time_s;
            let compensator = stage::compensator(&from_stage.model, h)?;
            let drive = stage::compensate(&compensator, &reference.samples).map_err(refused)?;
            let measured = Stage::p753().run(&drive, h).map_err(refused)?;
            let displacement = lag_removed(&measured, h);
            let wanted = &reference.samples[settled..displacement.len()];
            Ok(Compensated {
                frequency_hz,
                rate_dependent: max_abs_error(wanted, &displacement[settled..]).map_err(refused)?,
            })
        })
        .collect::<Result<_, Error>>()?;
    Ok(Identifications {
        from_model,
        from_stage,
        largest_error_um,
    })
}

/// Drive in V and displacement in um of one steady period.
type Loop = (Vec<f64>, Vec<f64>);

/// The second of three periods from rest, every `every`-th sample; the amplifier lag is removed
/// where the stage has one.
fn steady_loop(
    stage: &Stage,
    frequency_hz: f64,
    sample_time_s: f64,
    every: usize,
) -> Result<Loop, Error> {
    let grid = Grid::for_cycles(sample_time_s, frequency_hz, 3.0).map_err(refused)?;
    let drive = sine(&grid, AMPLITUDE, frequency_hz, 0.0)
        .map_err(refused)?
        .samples;
    let measured = stage.run(&drive, sample_time_s).map_err(refused)?;
    let displacement = if stage.amplifier_tau_s > 0.0 {
        lag_removed(&measured, sample_time_s)
    } else {
        measured
    };
    let period = drive.len() / 3..drive.len() / 3 * 2;
    let kept = |signal: &[f64]| {
        signal[period.clone()]
            .iter()
            .copied()
            .step_by(every)
            .collect()
    };
    Ok((kept(&drive), kept(&displacement)))
}

fn records(of: impl Fn(f64) -> Result<Loop, Error>) -> Result<Dataset, Error> {
    let records = LOOP_FREQUENCIES_HZ
        .into_iter()
        .map(|frequency_hz| {
            let (drive_v, displacement_um) = of(frequency_hz)?;
            let sample_time_s = 1.0 / (f64::from(POINTS) * frequency_hz);
            Ok(Record {
                name: format!("{frequency_hz} Hz"),
                role: Role::Fit,
                start_s: 0.0,
                sample_time_s,
                time_s: (0..drive_v.len())
                    .map(|k| k as f64 * sample_time_s)
                    .collect(),
                drive_v,
                displacement_um,
                continues: None,
            })
        })
        .collect::<Result<_, Error>>()?;
    Ok(Dataset {
        name: "three loops".to_owned(),
        output_unit: LengthUnit::Micrometre,
        zero: Zero::Shared,
        input_zero: Zero::Shared,
        records,
    })
}

fn identified(dataset: Dataset) -> Result<Identified, Error> {
    let options = Options {
        plays: Some(3),
        thresholds: Some(Thresholds::Spaced),
        beta: Some(true),
        asymmetry: false,
        weights: RecordWeights::Hysteresis,
        effects: Vec::new(),
    };
    let found = identify(&dataset, &options, &|_| {})?;
    let percents = dataset
        .records
        .iter()
        .map(|record| hysteresis_percent(&record.drive_v, &record.displacement_um).map_err(refused))
        .collect::<Result<Vec<_>, _>>()?;
    let (gain, _) = found.model.output();
    let hysteresis = found.model.hysteresis();
    Ok(Identified {
        weights: hysteresis.map_or_else(Vec::new, |h| h.weights.iter().map(|a| gain * a).collect()),
        zeta_v: hysteresis.map_or(f64::NAN, |h| h.thresholds_v[0]),
        beta_s: hysteresis.map_or(f64::NAN, |h| h.beta_s),
        record_weights: percents
            .iter()
            .map(|percent| percent / percents[0])
            .collect(),
        rms_um: found.rms.fit.unwrap_or(f64::NAN),
        model: found.model,
    })
}
