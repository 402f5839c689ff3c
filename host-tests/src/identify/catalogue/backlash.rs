//! Backlash: its width over half the range of the displacement.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct Backlash;

impl Template for Backlash {
    fn name(&self) -> &'static str {
        "backlash"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![vec![0.03]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(0.0, 0.8)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::Backlash(model_file::Backlash {
            width: x * seen.displacement_um / gain,
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, gain: f64) -> Option<Vec<f64>> {
        let Stage::Backlash(gap) = stage else {
            return None;
        };
        Some(vec![gap.width * gain / seen.displacement_um])
    }
}
