//! Hysteresis models and their inverses.

pub mod bouc_wen;
pub mod elements;
pub mod modified_play;
pub mod preview;
mod rate_dependent_pi;

pub use rate_dependent_pi::{Parameters, RateDependentPi, State};
