//! Drift: its end over half the range of the displacement, and the logarithm of its time constant.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct Drift;

impl Template for Drift {
    fn name(&self) -> &'static str {
        "drift"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        let span = seen.time_s.1 - seen.time_s.0;
        [0.1, 0.5, 5.0]
            .iter()
            .map(|share| vec![0.0, (share * span).ln()])
            .collect()
    }

    fn bounds(&self, seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        let span = seen.time_s.1 - seen.time_s.0;
        vec![(-30.0, 30.0), ((0.01 * span).ln(), (30.0 * span).ln())]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[amplitude, tau] = numbers else {
            return None;
        };
        Some(Stage::Drift(model_file::Drift {
            amplitude: amplitude * seen.displacement_um,
            tau_s: tau.exp(),
        }))
    }

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::Drift(drift) = stage else {
            return None;
        };
        let amplitude = drift.amplitude / seen.displacement_um;
        Some(vec![amplitude, drift.tau_s.ln()])
    }

    fn inverted(&self) -> bool {
        false
    }
}
