//! Experiments on stages: the signals they are driven with.

pub mod references;
