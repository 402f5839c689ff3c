//! What a stage does besides hysteresis: one file an effect, forward and inverse.

pub mod asymmetry;
