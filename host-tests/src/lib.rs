//! Host side of hysteron: data sets, identification, simulated stages, reports.

pub mod dataset;
pub mod experiment;
pub mod metrics;
pub mod plant;
pub mod report;
