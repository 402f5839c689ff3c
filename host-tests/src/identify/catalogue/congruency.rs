//! Congruency: kappa at half the range of the displacement.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct Congruency;

impl Template for Congruency {
    fn name(&self) -> &'static str {
        "congruency"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(-0.9, 0.9)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::Congruency(model_file::Congruency {
            kappa: x / seen.displacement_um,
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::Congruency(law) = stage else {
            return None;
        };
        Some(vec![law.kappa * seen.displacement_um])
    }
}
