//! Amplifier lag: the logarithm of its time constant in samples.

use crate::model_file::{self, Stage};

use super::{Seen, Template, lag};

/// See the [module](self).
pub struct AmplifierLag;

impl Template for AmplifierLag {
    fn name(&self) -> &'static str {
        "amplifier-lag"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        lag::starts(seen)
    }

    fn bounds(&self, seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        lag::bounds(seen)
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let tau_s = lag::tau_s(numbers, seen)?;
        Some(Stage::AmplifierLag(model_file::AmplifierLag { tau_s }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::AmplifierLag(lag) = stage else {
            return None;
        };
        Some(lag::numbers(lag.tau_s, seen))
    }
}
