//! The worked example of section F: u = 22 sin(2 pi f t) + 25 sin(6 pi f t), four plays.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::references::{Grid, example_f};
use crate::experiment::refused;
use crate::metrics::max_abs_error;
use crate::model_file::ModelFile;
use crate::stage;

use super::SAMPLE_TIME_S;
use super::plants::same_rate;

/// Fundamental frequencies in Hz.
const FUNDAMENTALS_HZ: [f64; 2] = [10.0, 60.0];

/// The example at one fundamental frequency.
#[derive(Clone, Debug, Serialize)]
pub struct Example {
    /// Fundamental frequency in Hz.
    pub fundamental_hz: f64,
    /// Largest |u - model after inverse|, both with the rate of u, in um.
    pub identity_error_um: f64,
    /// Largest |u - inverse after model|, both with the rate of u, in V.
    pub inverse_after_model_error_v: f64,
    /// Largest error (41) of the rate-independent inverse in front of the rate-dependent model,
    /// whose thresholds move with the rate of u, in um.
    pub rate_independent_error_um: f64,
    /// The same where they move with the rate of the model's own drive.
    pub rate_independent_error_own_rate_um: f64,
    /// The rate-dependent inverse in front of the model with the rate of its own drive.
    pub rate_dependent_error_own_rate_um: f64,
    /// The signals.
    #[serde(skip)]
    pub signals: Signals,
}

/// Signals of the example, all of one length.
#[derive(Clone, Debug)]
pub struct Signals {
    /// Time in s.
    pub time_s: Vec<f64>,
    /// The input u.
    pub input: Vec<f64>,
    /// Output of each play.
    pub plays: Vec<Vec<f64>>,
    /// Output of the model.
    pub model: Vec<f64>,
    /// Output of the inverse.
    pub inverse: Vec<f64>,
    /// Model after inverse.
    pub composition: Vec<f64>,
    /// Rate-dependent model after rate-independent inverse (40).
    pub rate_independent: Vec<f64>,
    /// Error (41) of that.
    pub error: Vec<f64>,
}

/// The example at both frequencies, three periods from rest.
///
/// # Errors
/// A model or signal that is refused.
pub fn examples(file: &ModelFile) -> Result<Vec<Example>, Error> {
    FUNDAMENTALS_HZ
        .into_iter()
        .map(|fundamental_hz| example(file, fundamental_hz))
        .collect()
}

fn example(file: &ModelFile, fundamental_hz: f64) -> Result<Example, Error> {
    let grid = Grid::for_cycles(SAMPLE_TIME_S, fundamental_hz, 3.0).map_err(refused)?;
    let input = example_f(&grid, fundamental_hz).map_err(refused)?.samples;
    let model = stage::model(file, SAMPLE_TIME_S)?;
    let operator = model.hysteresis();
    let bank = operator.bank();
    let mut state = operator.start(input[0]);
    let mut plays = vec![Vec::with_capacity(input.len()); bank.len()];
    let mut output = Vec::with_capacity(input.len());
    for &u in &input {
        output.push(operator.step(&mut state, u));
        let outputs = state.plays().outputs(bank);
        for (trace, z) in plays.iter_mut().zip(outputs) {
            trace.push(z);
        }
    }

    let exact = stage::compensator(file, SAMPLE_TIME_S)?;
    let without_rate = stage::compensator(&file.clone().rate_independent(), SAMPLE_TIME_S)?;
    let drive = stage::compensate(&exact, &input).map_err(refused)?;
    let simple_drive = stage::compensate(&without_rate, &input).map_err(refused)?;
    let composition = same_rate(&model, &drive, &input);
    let rate_independent = same_rate(&model, &simple_drive, &input);
    let largest = |signal: &[f64]| max_abs_error(&input, signal).map_err(refused);

    Ok(Example {
        fundamental_hz,
        identity_error_um: largest(&composition)?,
        inverse_after_model_error_v: largest(&inverse_after_model(&model, &output, &input)?)?,
        rate_independent_error_um: largest(&rate_independent)?,
        rate_independent_error_own_rate_um: largest(&stage::simulate(&model, &simple_drive))?,
        rate_dependent_error_own_rate_um: largest(&stage::simulate(&model, &drive))?,
        signals: Signals {
            time_s: (0..input.len()).map(|k| k as f64 * SAMPLE_TIME_S).collect(),
            error: input
                .iter()
                .zip(&rate_independent)
                .map(|(u, w)| u - w)
                .collect(),
            plays,
            model: output,
            inverse: drive,
            composition,
            rate_independent,
            input,
        },
    })
}

/// The inverse driven by the model's output, its thresholds moved by the rate of the model's input.
fn inverse_after_model(
    model: &stage::Model,
    output: &[f64],
    input: &[f64],
) -> Result<Vec<f64>, Error> {
    let inverse = model.hysteresis().inverse().map_err(refused)?;
    let mut state = inverse.start(output[0]);
    let mut before = input[0];
    Ok(output
        .iter()
        .zip(input)
        .map(|(&v, &u)| {
            let rate = (u - before) / SAMPLE_TIME_S;
            before = u;
            inverse.step_with_rate(&mut state, v, rate)
        })
        .collect())
}
