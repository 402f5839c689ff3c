//! Paper J computed from code: M. Al Janaideh, P. Krejci, "Inverse rate-dependent Prandtl-Ishlinskii
//! model for feedforward compensation of hysteresis in a piezomicropositioning actuator", IEEE/ASME
//! Transactions on Mechatronics 18(5), 2013, doi 10.1109/TMECH.2012.2205265.
//!
//! The authors measured a stage P-753.31C. Here the stage is simulated by code that shares nothing
//! with the model ([`crate::plant`]); models, inverses and identification are those of the program.
//! All is driven with 40 V or asked for 40 um at 10 kHz, as in the paper.

mod constants;
mod drives;
mod hysteresis;
mod identification;
mod inputs;
mod page;
mod plants;
pub mod published;
mod sweep;
mod worked_example;

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::error::Error;
use crate::model_file::{ModelFile, builtin};
use crate::report::Page;

pub use constants::{Compared, Constants, Contradiction};
pub use drives::PerDrive;
pub use hysteresis::{Loops, Percent};
pub use identification::{Compensated, Identifications, Identified};
pub use inputs::{AlongInput, Shape, Traces};
pub use plants::{Errors, Plant};
pub use sweep::{AtFrequency, Band};
pub use worked_example::{Example, Signals};

/// Amplitude in V or um.
const AMPLITUDE: f64 = 40.0;
/// Time between samples in s.
const SAMPLE_TIME_S: f64 = 1e-4;

/// How often [`run`] reports a finished piece of work.
pub const PIECES: u64 = (sweep::FREQUENCIES_HZ.len() + inputs::INPUTS.len() + 2) as u64;

/// All results.
#[derive(Clone, Debug)]
pub struct Results {
    /// Constants of model and inverse.
    pub constants: Constants,
    /// Section F.
    pub examples: Vec<Example>,
    /// Hysteresis percent at three frequencies.
    pub percents: Vec<Percent>,
    /// Largest errors along sines.
    pub sweep: Vec<AtFrequency>,
    /// Their range over the frequencies.
    pub bands: Vec<Band>,
    /// Largest errors along other references.
    pub inputs: Vec<AlongInput>,
    /// How the simulated stage follows those.
    pub traces: Vec<Traces>,
    /// What the authors' identification gives.
    pub identification: Identifications,
}

/// Computes everything on all cores; `done` is called [`PIECES`] times.
///
/// # Errors
/// A model, signal or stage that is refused; with the fixed ones of this experiment, none is.
pub fn run(done: &(dyn Fn() + Sync)) -> Result<Results, Error> {
    let corrected = named("p753")?;
    let sines = || {
        sweep::FREQUENCIES_HZ
            .into_par_iter()
            .map(|frequency_hz| sweep::at(&corrected, frequency_hz))
            .inspect(|_| done())
            .collect::<Result<Vec<_>, _>>()
    };
    let others = || {
        inputs::INPUTS
            .into_par_iter()
            .map(|input| inputs::run(&corrected, input))
            .inspect(|_| done())
            .collect::<Result<Vec<_>, _>>()
    };
    let (sines, (others, identification)) = rayon::join(sines, || {
        rayon::join(others, || {
            let found = identification::run();
            done();
            found
        })
    });
    let percents = hysteresis::percents(&corrected)?;
    done();
    let sweep = sines?.concat();
    let (inputs, traces): (Vec<_>, Vec<_>) = others?.into_iter().unzip();
    Ok(Results {
        constants: Constants::new(corrected.clone(), named("p753-printed")?)?,
        examples: worked_example::examples(&named("example-f")?)?,
        percents,
        bands: sweep::bands(&sweep),
        sweep,
        inputs: inputs.concat(),
        traces,
        identification: identification?,
    })
}

impl Results {
    /// The contents of `j.json`; `docs/experiment-j.md` lists its keys.
    pub fn to_json(&self) -> Value {
        json!({
            "model": self.constants.model_json(),
            "inverse": self.constants.inverse_json(),
            "example_f": self.examples,
            "hysteresis_percent": self.percents,
            "largest_error_um": self.sweep,
            "error_bands_um": self.bands,
            "inputs": self.inputs,
            "identification": self.identification,
            "published": {
                "hysteresis_percent": published::HYSTERESIS_PERCENT,
                "record_weights": published::LOOP_WEIGHTS,
                "weights": published::WEIGHTS,
                "largest_error_um": {
                    "without": published::ERROR_WITHOUT_UM,
                    "with": published::ERROR_WITH_UM,
                },
            },
        })
    }

    /// The page.
    pub fn page(&self) -> Page {
        page::page(self)
    }
}

fn named(name: &str) -> Result<ModelFile, Error> {
    builtin(name).ok_or_else(|| crate::experiment::refused(format!("no built-in model {name}")))
}
