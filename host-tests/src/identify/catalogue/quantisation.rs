//! Quantisation: the step, read off the readings; no fit moves it.

use crate::model_file::Stage;

use super::{Seen, Template};

/// See the [module](self).
pub struct Quantisation;

impl Template for Quantisation {
    fn name(&self) -> &'static str {
        "quantisation"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![]
    }

    fn stage(&self, _numbers: &[f64], _seen: &Seen, _gain: f64) -> Option<Stage> {
        None
    }

    fn inverted(&self) -> bool {
        false
    }
}
