//! Paper M computed from code: K. Morita, F. Fujii, K. Hosoda, "Modeling and Compensation of a Bimorph
//! Type Piezoelectric Actuator Exhibiting Odd-Harmonic Oscillation and Frequency-Dependent,
//! Interleaved Hysteresis", Actuators 9(2), 2020.
//!
//! The authors measured a bimorph PZBA-00030. Here it is simulated by code that shares nothing with the
//! models ([`crate::plant::bimorph`]); model, recursive identification and direct inverse
//! multiplication are those of the core. Units are the paper's: drive in parts of 5 V, mm, 5 kHz.

mod bouc_wen;
mod compensation;
mod fitting;
mod free_run;
pub(super) mod model;
mod page;
pub mod published;
pub(super) mod record;
mod separable;
mod studies;
mod summary;
mod sweep;

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::error::Error;
use crate::report::Page;

pub use bouc_wen::BoucWen;
pub use compensation::{Outcome, PerLaw, REFERENCE_MM};
pub use fitting::{Comparison, Scores};
pub use model::Recipe;
pub use record::{Record, Score};
pub use studies::{AtCovariance, AtEnvelope, AtHarmonic, Compared, Content, Held, Plane, Studies};
pub use summary::{Counts, Facts, Summary};
pub use sweep::{AtFrequency, Traces};

/// Highest frequency in Hz; the lowest is 1, the step 1.
pub const HIGHEST_HZ: u32 = 110;

/// How often [`run`] reports a finished piece of work.
pub const PIECES: u64 = HIGHEST_HZ as u64 + studies::PIECES;

/// All results.
#[derive(Clone, Debug)]
pub struct Results {
    /// One entry a frequency, from 1 Hz on.
    pub frequencies: Vec<AtFrequency>,
    /// Signals of some of them.
    pub traces: Vec<Traces>,
    /// The paper's choices one at a time.
    pub studies: Studies,
    /// What it all comes to.
    pub summary: Summary,
}

/// Computes everything on all cores; `done` is called [`PIECES`] times.
///
/// # Errors
/// A model or drive that is refused; with the fixed ones of this experiment, none is.
pub fn run(done: &(dyn Fn() + Sync)) -> Result<Results, Error> {
    let all: Vec<u32> = (1..=HIGHEST_HZ).collect();
    run_at(&all, done)
}

/// The same at some of the frequencies, Hz, in ascending order; `done` is called once less for each that
/// is left out.
///
/// # Errors
/// As [`run`]; without the frequencies that the figures of the page are drawn at.
pub fn run_at(frequencies_hz: &[u32], done: &(dyn Fn() + Sync)) -> Result<Results, Error> {
    let found = frequencies_hz
        .par_iter()
        .map(|&hz| sweep::at(hz))
        .inspect(|_| done())
        .collect::<Result<Vec<_>, _>>()?;
    let studies = studies::run(done)?;
    let (frequencies, traces): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let traces: Vec<Traces> = traces.into_iter().flatten().collect();
    let summary = Summary::new(&frequencies, &traces, &studies)?;
    Ok(Results {
        frequencies,
        traces,
        studies,
        summary,
    })
}

impl Results {
    /// The contents of `m.json`; `docs/experiment-m.md` lists its keys.
    pub fn to_json(&self) -> Value {
        json!({
            "conditions": {
                "sample_time_s": record::SAMPLE_TIME_S,
                "sensor_noise_mm": 2e-5,
                "reference_mm": REFERENCE_MM,
                "initial_covariance": Recipe::COVARIANCE,
                "initial_covariance_one_step": Recipe::WEAK_COVARIANCE,
                "alpha_s": Recipe::PROPOSED.envelope_s,
                "beta_s": Recipe::PROPOSED.envelope_s,
            },
            "summary": self.summary,
            "frequencies": self.frequencies,
            "studies": self.studies,
            "published": {
                "proposed_best_of_110": published::PROPOSED_BEST,
                "fitting_loss_percent": published::FITTING_LOSS_PERCENT,
                "degraded_hz": published::DEGRADED_HZ,
                "third_over_first_after_25_hz": published::THIRD_AFTER,
                "third_over_first_25_hz": published::THIRD_AT_25_HZ,
                "third_over_first_35_hz": published::THIRD_AT_35_HZ,
                "fifth_over_third_15_hz": published::FIFTH_AT_15_HZ,
            },
        })
    }

    /// The page.
    pub fn page(&self) -> Page {
        page::page(self)
    }
}
