//! Experiments on stages: the signals they are driven with, a paper's figures computed anew, and the
//! demonstration.

pub mod beyond;
pub mod demo;
pub mod j;
pub mod m;
pub mod references;
pub mod worked;

use std::fmt::Display;

use crate::error::Error;

/// An experiment's signals, stages and models are fixed, so a refusal by any of them is a fault of
/// the experiment itself and is told as such.
fn refused(reason: impl Display) -> Error {
    Error::request(format!("the experiment cannot be computed: {reason}"))
}
