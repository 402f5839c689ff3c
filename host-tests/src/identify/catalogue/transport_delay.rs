//! Transport delay: in samples of the fastest record.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct TransportDelay;

impl Template for TransportDelay {
    fn name(&self) -> &'static str {
        "transport-delay"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        vec![vec![1.0], vec![4.0], vec![12.0]]
    }

    fn bounds(&self, _seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(0.0, 25.0)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::TransportDelay(model_file::TransportDelay {
            delay_s: x * seen.sample_time_s,
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::TransportDelay(delay) = stage else {
            return None;
        };
        Some(vec![delay.delay_s / seen.sample_time_s])
    }
}
