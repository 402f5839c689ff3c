//! Identification: from a data set to a model of the stage.
//!
//! The order of work, each step judged on the records with the role `select`:
//!
//! 1. the state in which each record starts is chosen from a short menu of histories;
//! 2. the number of plays grows until it no longer helps; thresholds are multiples of one spacing;
//!    beta is fitted where the records move over a decade of frequencies or more;
//! 3. thresholds are freed, beta and the asymmetry map are added, each only if it helps.
//!
//! Effects around the hysteresis that are asked for by name are fitted together with it, on an even
//! spread of plays, in place of 2 and 3.
//!
//! The records with the role `report` are scored once, at the end.

pub mod catalogue;
pub(crate) mod cycles;
mod fit;
pub(crate) mod joint;
mod json;
mod map;
pub(crate) mod noise;
mod outcome;
mod page;
mod plays;
mod reduce;
pub(crate) mod rounding;
pub(crate) mod run;
pub(crate) mod score;
mod search;
pub(crate) mod spectrum;
pub(crate) mod start;
mod whole;

pub use catalogue::Effect;
pub use fit::Thresholds;
pub use json::schema_text;
pub use noise::Source;
pub use outcome::{Identification, RecordFigures, Rms, joint_model};
pub use page::page;
pub use search::{Options, RecordWeights, fit_spaced, identify};
pub use whole::{WholeRms, whole};
