//! Backlash: its width over half the range of the displacement.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// Widths that are tried: the least, how many, and how much wider each is than the one before.
const LEAST: f64 = 0.006;
const STARTS: i32 = 9;
const RATIO: f64 = 1.4;

/// See the [module](self).
pub struct Backlash;

impl Template for Backlash {
    fn name(&self) -> &'static str {
        "backlash"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        // Plays stand in for a gap of another width: only from near its own it is found.
        (0..STARTS).map(|i| vec![LEAST * RATIO.powi(i)]).collect()
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
