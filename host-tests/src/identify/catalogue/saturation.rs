//! Saturation: the limit over the largest drive.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct Saturation;

impl Template for Saturation {
    fn name(&self) -> &'static str {
        "saturation"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![vec![0.97], vec![0.85], vec![0.65]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(0.2, 1.0)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::Saturation(model_file::Saturation {
            limit_v: x * seen.drive_v,
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::Saturation(limit) = stage else {
            return None;
        };
        Some(vec![limit.limit_v / seen.drive_v])
    }

    fn inverted(&self) -> bool {
        false
    }
}
