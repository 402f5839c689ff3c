//! Slew limit: the logarithm of the limit over the largest rate of the drive.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct SlewLimit;

impl Template for SlewLimit {
    fn name(&self) -> &'static str {
        "slew-limit"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        [0.8, 0.4, 0.15, 0.05, 0.015]
            .iter()
            .map(|share: &f64| vec![share.ln()])
            .collect()
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(1e-4f64.ln(), 0.0)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::SlewLimit(model_file::SlewLimit {
            slew_v_per_s: x.exp() * seen.rate_v_per_s,
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::SlewLimit(limit) = stage else {
            return None;
        };
        Some(vec![(limit.slew_v_per_s / seen.rate_v_per_s).ln()])
    }

    fn inverted(&self) -> bool {
        false
    }
}
