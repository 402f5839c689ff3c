//! Discovery: where simulation and measurement disagree, which effect is missing, what adding it does.

mod baseline;
pub mod blind;
mod bootstrap;
mod diagnosis;
mod holding;
mod json;
pub mod localise;
mod naming;
mod next_record;
mod own_model;
mod page;
mod reading;
mod search;
mod words;
mod workflow;

pub use baseline::Baseline;
pub use diagnosis::{Ablation, Diagnosis, FoundEffect, RecordResiduals, Residuals, Roles, Verdict};
pub use json::schema_text;
pub use next_record::next_record;
pub use page::page;
pub use workflow::{Options, baseline_alone, diagnose};
