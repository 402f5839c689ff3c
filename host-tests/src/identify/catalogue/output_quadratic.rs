//! Even curvature behind the modes: q at half the range of the displacement.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct OutputQuadratic;

impl Template for OutputQuadratic {
    fn name(&self) -> &'static str {
        "output-quadratic"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(-0.3, 0.3)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::OutputQuadratic(model_file::Quadratic {
            q: x / seen.displacement_um * gain,
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, gain: f64) -> Option<Vec<f64>> {
        let Stage::OutputQuadratic(map) = stage else {
            return None;
        };
        Some(vec![map.q * seen.displacement_um / gain])
    }
}
