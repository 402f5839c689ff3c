//! Model and inverse constants: what the formulas give, what is printed, and where that disagrees.

use serde::Serialize;
use serde_json::{Map, Value, json};

use hysteron::hysteresis::RateDependentPi;

use crate::error::Error;
use crate::experiment::references::{Grid, sine};
use crate::experiment::refused;
use crate::metrics::max_abs_error;
use crate::model_file::ModelFile;
use crate::stage::{self, PLAYS};

use super::SAMPLE_TIME_S;
use super::published::{INVERSE, WEIGHTS};

/// Relative deviation that the four printed digits of the weights can leave in an inverse constant.
const ROUNDING: f64 = 0.002;

/// One constant of the inverse, published and computed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Compared {
    /// Its name in the paper.
    pub constant: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// As printed.
    pub published: f64,
    /// Of the model with the printed weights.
    pub from_printed: f64,
    /// Whether that is the published value but for rounding.
    pub printed_agrees: bool,
    /// Of the model with the corrected weights.
    pub from_corrected: f64,
    /// Whether that is the published value but for rounding.
    pub corrected_agrees: bool,
}

/// Something printed that contradicts the rest of the paper.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contradiction {
    /// The constant or equation.
    pub what: &'static str,
    /// The value as printed, or what follows from the equation as printed.
    pub printed: f64,
    /// The value that agrees with the rest.
    pub consistent: f64,
    /// What the two numbers are.
    pub why: &'static str,
}

/// Constants of the corrected and the printed model.
#[derive(Clone, Debug)]
pub struct Constants {
    /// The model with corrected constants.
    pub corrected: ModelFile,
    /// The model as printed.
    pub printed: ModelFile,
    /// The constants of the inverse.
    pub compared: Vec<Compared>,
    /// Weights a_0 to a_3 that follow from the published inverse and zeta.
    pub implied_weights: Vec<f64>,
    /// What does not agree.
    pub contradictions: Vec<Contradiction>,
    inverses: [Map<String, Value>; 2],
}

impl Constants {
    /// Computes the inverses of both models and holds them against the printed one.
    ///
    /// # Errors
    /// A model that cannot be built or inverted.
    pub fn new(corrected: ModelFile, printed: ModelFile) -> Result<Self, Error> {
        let of_corrected = inverse(&corrected)?;
        let of_printed = inverse(&printed)?;
        let agrees = |ours: f64, published: f64| (ours / published - 1.0).abs() <= ROUNDING;
        let compared = INVERSE
            .iter()
            .zip(
                constants(&of_printed)
                    .into_iter()
                    .zip(constants(&of_corrected)),
            )
            .map(
                |(&(constant, published, unit), (from_printed, from_corrected))| Compared {
                    constant,
                    unit,
                    published,
                    from_printed,
                    printed_agrees: agrees(from_printed, published),
                    from_corrected,
                    corrected_agrees: agrees(from_corrected, published),
                },
            )
            .collect();
        let zeta = corrected
            .hysteresis()
            .map_or(f64::NAN, |h| h.thresholds_v[0]);
        let implied_weights = implied_weights(zeta);
        let contradictions = contradictions(&implied_weights, &of_corrected, &corrected, zeta)?;
        Ok(Self {
            inverses: [parameters(&of_corrected), parameters(&of_printed)],
            corrected,
            printed,
            compared,
            implied_weights,
            contradictions,
        })
    }

    /// The models under the keys of `model.toml`, and what contradicts what.
    pub fn model_json(&self) -> Value {
        json!({
            "corrected": self.corrected.parameters(),
            "printed": self.printed.parameters(),
            "implied_by_published_inverse": { "weights": self.implied_weights },
            "contradictions": self.contradictions,
        })
    }

    /// The inverses, computed and published.
    pub fn inverse_json(&self) -> Value {
        let [corrected, printed] = &self.inverses;
        json!({
            "of_corrected": corrected,
            "of_printed": printed,
            "published": {
                "weights": INVERSE[..4].iter().map(|c| c.1).collect::<Vec<_>>(),
                "thresholds_um": INVERSE[4..7].iter().map(|c| c.1).collect::<Vec<_>>(),
                "beta_s": INVERSE[7].1,
            },
            "compared": self.compared,
        })
    }
}

fn inverse(file: &ModelFile) -> Result<RateDependentPi<f64, PLAYS>, Error> {
    stage::model(file, SAMPLE_TIME_S)?
        .hysteresis()
        .inverse()
        .map_err(refused)
}

fn parameters(inverse: &RateDependentPi<f64, PLAYS>) -> Map<String, Value> {
    let bank = inverse.bank();
    let mut parameters = Map::new();
    let weights = [&[inverse.weight_0()], bank.weights()].concat();
    parameters.insert("weights".into(), json!(weights));
    parameters.insert("thresholds_um".into(), json!(bank.thresholds()));
    parameters.insert("beta_s".into(), json!(inverse.beta()));
    parameters
}

/// In the order of [`INVERSE`].
fn constants(inverse: &RateDependentPi<f64, PLAYS>) -> Vec<f64> {
    let bank = inverse.bank();
    [
        &[inverse.weight_0()],
        bank.weights(),
        bank.thresholds(),
        &[inverse.beta()],
    ]
    .concat()
}

/// The weights whose inverse has the published thresholds and the published b_3, by (14) and (15).
fn implied_weights(zeta: f64) -> Vec<f64> {
    let [_, _, _, b_3, s_1, s_2, s_3, _] = INVERSE.map(|constant| constant.1);
    let sums = [s_1 / zeta, (s_2 - s_1) / zeta, (s_3 - s_2) / zeta];
    let last = 1.0 / (1.0 / sums[2] + b_3);
    vec![
        sums[0],
        sums[1] - sums[0],
        sums[2] - sums[1],
        last - sums[2],
    ]
}

fn contradictions(
    implied: &[f64],
    inverse: &RateDependentPi<f64, PLAYS>,
    corrected: &ModelFile,
    zeta: f64,
) -> Result<Vec<Contradiction>, Error> {
    let published = INVERSE.map(|constant| constant.1);
    let sum_1 = implied[0] + implied[1];
    let [as_printed, as_corrected] = initial_state_errors(corrected)?;
    Ok(vec![
        Contradiction {
            what: "a_0",
            printed: WEIGHTS[0],
            consistent: implied[0],
            why: "printed weight; s_1 / zeta of the published inverse",
        },
        Contradiction {
            what: "a_2",
            printed: WEIGHTS[2],
            consistent: implied[2],
            why: "printed weight, two digits swapped; from the published s_1, s_2, s_3",
        },
        Contradiction {
            what: "b_0",
            printed: published[0],
            consistent: 1.0 / implied[0],
            why: "printed weight; 1 / a_0 with a_0 from the published s_1. It is the inverse of \
                  neither a_0",
        },
        Contradiction {
            what: "b_2",
            printed: published[2],
            consistent: inverse.bank().weights()[1],
            why: "printed with one digit less, cut rather than rounded; of the corrected weights",
        },
        Contradiction {
            what: "(23)",
            printed: sum_1 * (zeta * zeta - zeta),
            consistent: sum_1 * zeta,
            why: "s_2 - s_1 in um with thresholds zeta^i as in (23), and with zeta i as in (25); \
                  the published difference is 9.853",
        },
        Contradiction {
            what: "(16)",
            printed: as_printed,
            consistent: as_corrected,
            why: "largest error in um of model after inverse, both with one rate, from a state \
                  inside a loop: y_1 = a_1 x_1 as in (16), and y_1 = a_0 x_1",
        },
    ])
}

/// Largest error in um of model after inverse from a state with displaced plays: the inverse started
/// with y_1 = a_1 x_1 as printed, and with y_1 = a_0 x_1.
fn initial_state_errors(file: &ModelFile) -> Result<[f64; 2], Error> {
    let model = stage::model(file, SAMPLE_TIME_S)?;
    let operator = model.hysteresis();
    let inverse = operator.inverse().map_err(refused)?;
    let bank = operator.bank();
    // A descent from 40 V to 10 V leaves the plays above the drive.
    let mut state = operator.start(0.0);
    for u in [0.0, 40.0, 10.0, 10.0] {
        operator.step(&mut state, u);
    }
    let u = 10.0;
    let z = state.plays().outputs(bank);
    let z = &z[..bank.len()];
    let (v, outputs) = operator.inverse_start(u, z).map_err(refused)?;
    let grid = Grid::for_cycles(SAMPLE_TIME_S, 50.0, 2.0).map_err(refused)?;
    let mut reference = sine(&grid, 20.0, 50.0, 0.0).map_err(refused)?.samples;
    reference.iter_mut().for_each(|sample| *sample += v);

    let error = |shift: f64| {
        let outputs: Vec<f64> = outputs[..bank.len()].iter().map(|d| d - shift).collect();
        let mut inverse_state = inverse.start_from(v, &outputs).map_err(refused)?;
        let mut state = operator.start_from(u, z).map_err(refused)?;
        let mut before = v;
        let displacement: Vec<f64> = reference
            .iter()
            .map(|&wanted| {
                let rate = (wanted - before) / SAMPLE_TIME_S;
                before = wanted;
                let drive = inverse.step_with_rate(&mut inverse_state, wanted, rate);
                operator.step_with_rate(&mut state, drive, rate)
            })
            .collect();
        max_abs_error(&reference, &displacement).map_err(refused)
    };
    // The printed formula moves every y_i by the same amount, and with it every play.
    let printed_shift = (bank.weights()[0] - operator.weight_0()) * (u - z[0]);
    Ok([error(printed_shift)?, error(0.0)?])
}
