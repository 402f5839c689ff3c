//! Quantisation: the step, read off the readings; no fit moves it.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct Quantisation;

impl Template for Quantisation {
    fn name(&self) -> &'static str {
        "quantisation"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        vec![]
    }

    fn bounds(&self, seen: &Seen, numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, gain: f64) -> Option<Stage> {
        None
    }

    fn inverted(&self) -> bool {
        false
    }
}
