//! Beyond both papers: every compensator of the program over both papers' ranges, on plants that none
//! of them was derived from, its parameters identified from records of the plant; again with all
//! parameters of the plant 10 % off; and with feedback around it.

pub mod against_dim;
pub mod compensators;
pub mod feedback;
pub mod inputs;
mod page;
pub mod plants;
mod records;
mod summary;
pub mod sweep;

use rayon::prelude::*;
use serde_json::{Value, json};

use crate::error::Error;
use crate::experiment::refused;
use crate::model_file::ModelFile;
use crate::report::Page;

pub use summary::{Standing, standings};

use against_dim::{AtFrequency, Comparison};
use compensators::Identified;
use feedback::FourWays;
use inputs::Input;
use plants::{PLANTS, Plant};
use sweep::Row;

/// Stack of a thread.
const STACK_BYTES: usize = 64 << 20;

/// What is computed.
pub struct Extent<'a> {
    /// Frequencies at which the cascade is held against DIM, Hz; one of 5 Hz or more among them.
    pub against_dim_hz: &'a [f64],
    /// Which references of the sweep.
    pub wanted: &'a (dyn Fn(Plant, &Input) -> bool + Sync),
    /// Frequencies of the sines with feedback, Hz.
    pub feedback_hz: &'a [f64],
}

/// Frequencies of paper M, Hz.
pub fn paper_m_hz() -> Vec<f64> {
    (1..=super::m::HIGHEST_HZ).map(f64::from).collect()
}

impl Extent<'_> {
    /// How often [`run`] reports a finished piece of work.
    pub fn pieces(&self) -> u64 {
        let rows = PLANTS.into_iter().map(|plant| {
            let inputs = inputs::inputs(plant).into_iter();
            inputs.filter(|input| (self.wanted)(plant, input)).count()
        });
        let per_plant = 1 + self.feedback_hz.len();
        (PLANTS.len() * per_plant + self.against_dim_hz.len() + rows.sum::<usize>()) as u64
    }
}

/// What was identified on a plant.
#[derive(Clone, Debug)]
pub struct OnPlant {
    /// The plant.
    pub plant: Plant,
    /// beta of the explicit and of the preview inverse, s.
    pub beta_s: f64,
    /// The model of the cascade.
    pub cascade: ModelFile,
}

/// All results.
#[derive(Clone, Debug)]
pub struct Results {
    /// One a plant.
    pub identified: Vec<OnPlant>,
    /// The sweep, plant after plant.
    pub rows: Vec<Row>,
    /// The cascade against DIM on the bimorph.
    pub against_dim: Vec<AtFrequency>,
    /// What that comes to.
    pub comparison: Comparison,
    /// With feedback.
    pub feedback: Vec<FourWays>,
    /// What the sweep comes to, one a plant and compensator.
    pub standings: Vec<Standing>,
}

/// Computes everything on all cores; `done` is called [`Extent::pieces`] times.
///
/// # Errors
/// An extent without a frequency of 5 Hz or more; a plant or reference that is refused, which with the
/// fixed ones of this experiment none is.
pub fn run(extent: &Extent<'_>, done: &(dyn Fn() + Sync)) -> Result<Results, Error> {
    // The state of a preview inverse for any model is built on the stack of its thread.
    let threads = rayon::ThreadPoolBuilder::new().stack_size(STACK_BYTES);
    threads
        .build()
        .map_err(refused)?
        .install(|| compute(extent, done))
}

fn compute(extent: &Extent<'_>, done: &(dyn Fn() + Sync)) -> Result<Results, Error> {
    let identified = PLANTS
        .into_par_iter()
        .map(Identified::new)
        .inspect(|_| done())
        .collect::<Result<Vec<_>, _>>()?;
    let each = || PLANTS.into_par_iter().zip(&identified);
    let rows = each()
        .map(|(plant, found)| {
            sweep::run(plant, found, &|input| (extent.wanted)(plant, input), done)
        })
        .collect::<Result<Vec<_>, _>>()?
        .concat();
    let feedback = each()
        .map(|(plant, found)| feedback::run(plant, found, extent.feedback_hz, done))
        .collect::<Result<Vec<_>, _>>()?
        .concat();
    let mut pairs = PLANTS.into_iter().zip(&identified);
    let (_, bimorph) = pairs
        .find(|(plant, _)| *plant == Plant::Bimorph)
        .ok_or_else(|| refused("no bimorph"))?;
    let against_dim = against_dim::run(&bimorph.cascade, extent.against_dim_hz, done)?;
    let comparison =
        Comparison::new(&against_dim).ok_or_else(|| refused("no frequency to hold against DIM"))?;
    let identified = PLANTS.into_iter().zip(&identified);
    Ok(Results {
        identified: identified
            .map(|(plant, found)| OnPlant {
                plant,
                beta_s: found.beta_s(),
                cascade: found.cascade.clone(),
            })
            .collect(),
        standings: standings(&rows),
        rows,
        against_dim,
        comparison,
        feedback,
    })
}

impl Results {
    /// The contents of `beyond.json`; `docs/beyond.md` lists its keys.
    pub fn to_json(&self) -> Value {
        let identified: Vec<Value> = self
            .identified
            .iter()
            .map(|found| {
                json!({
                    "plant": found.plant,
                    "beta_s": found.beta_s,
                    "cascade": found.cascade.parameters(),
                })
            })
            .collect();
        json!({
            "conditions": {
                "wrong": plants::WRONG,
                "wrong_plants": sweep::WRONG_PLANTS,
                "ease_s": inputs::EASE_S,
                "settled_s": inputs::SETTLED_S,
            },
            "identified": identified,
            "comparison": self.comparison,
            "standings": self.standings,
            "sweep": self.rows,
            "against_dim": self.against_dim,
            "feedback": self.feedback,
        })
    }

    /// The page.
    pub fn page(&self) -> Page {
        page::page(self)
    }
}
