//! Identification: from a data set to a model of the stage.
//!
//! The order of work, each step judged on the records with the role `select`:
//!
//! 1. the state in which each record starts is chosen from a short menu of histories;
//! 2. the number of plays grows until it no longer helps; thresholds are multiples of one spacing;
//!    beta is fitted where the records move over a decade of frequencies or more;
//! 3. thresholds are freed, beta and the asymmetry map are added, each only if it helps.
//!
//! The records with the role `report` are scored once, at the end.

mod cycles;
mod fit;
mod map;
mod noise;
mod outcome;
mod page;
mod plays;
mod reduce;
mod run;
mod score;
mod search;
mod spectrum;
mod start;

pub use fit::Thresholds;
pub use noise::Source;
pub use outcome::{Identification, RecordFigures, Rms};
pub use page::page;
pub use search::{Options, RecordWeights, fit_spaced, identify};
