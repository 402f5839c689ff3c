//! Interleaving: g at the largest drive.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct Interleaving;

impl Template for Interleaving {
    fn name(&self) -> &'static str {
        "interleaving"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(-0.9, 0.9)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::Interleaving(model_file::Interleaving {
            g: x / seen.drive_v,
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::Interleaving(product) = stage else {
            return None;
        };
        Some(vec![product.g * seen.drive_v])
    }
}
