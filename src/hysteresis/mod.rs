//! Hysteresis models and their inverses.

pub mod modified_play;
mod rate_dependent_pi;

pub use rate_dependent_pi::{Parameters, RateDependentPi, State};
