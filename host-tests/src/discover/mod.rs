//! Discovery: where simulation and measurement disagree, which effect is missing, what adding it does.

pub mod baseline;
pub mod blind;
mod diagnosis;
pub mod search;
mod workflow;

pub use baseline::Baseline;
pub use diagnosis::{Ablation, Diagnosis, FoundEffect, RecordResiduals, Residuals, Roles, Verdict};
pub use workflow::{Options, diagnose};
