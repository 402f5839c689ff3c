//! Odd curvature: c at half the range of the displacement.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct Cubic;

impl Template for Cubic {
    fn name(&self) -> &'static str {
        "cubic"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(-0.2, 1.0)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::Cubic(model_file::Cubic {
            c: x * (gain / seen.displacement_um).powi(2),
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, gain: f64) -> Option<Vec<f64>> {
        let Stage::Cubic(map) = stage else {
            return None;
        };
        Some(vec![map.c * (seen.displacement_um / gain).powi(2)])
    }
}
