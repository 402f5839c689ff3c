//! Power of the rate in the law of the thresholds: less one. Needs a rate term.

use crate::model_file::{self, Stage};

use super::{DECADE, Seen, Template};

/// See the [module](self).
pub struct RateLaw;

impl Template for RateLaw {
    fn name(&self) -> &'static str {
        "rate-law"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![vec![-0.3], vec![0.3]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(-0.8, 2.0)]
    }

    fn stage(&self, numbers: &[f64], _seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::RateLaw(model_file::RateLaw { exponent: 1.0 + x }))
    }

    fn numbers(&self, stage: &Stage, _seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::RateLaw(law) = stage else {
            return None;
        };
        Some(vec![law.exponent - 1.0])
    }

    fn hidden(&self, seen: &Seen) -> Option<&'static str> {
        (seen.frequency_span < DECADE)
            .then_some("the records span less than a decade of frequencies")
    }
}
