//! Rate term of the thresholds: what it widens the plays by at the highest rate, over the widest threshold.

use crate::model_file::Stage;

use super::{DECADE, Seen, Template};

/// See the [module](self).
pub struct RateDependence;

impl Template for RateDependence {
    fn name(&self) -> &'static str {
        "rate-dependence"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        // A stage that is dragged along may widen its loops by more than its widest play.
        vec![vec![0.1], vec![0.4], vec![1.2]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(0.0, 20.0)]
    }

    fn stage(&self, _numbers: &[f64], _seen: &Seen, _gain: f64) -> Option<Stage> {
        None
    }

    fn numbers(&self, _stage: &Stage, _seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        None
    }

    fn hidden(&self, seen: &Seen) -> Option<&'static str> {
        (seen.frequency_span < DECADE)
            .then_some("the records span less than a decade of frequencies")
    }
}
