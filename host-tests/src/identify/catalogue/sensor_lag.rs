//! Sensor lag: the logarithm of its time constant in samples. It is no motion, so nothing undoes it.

use crate::model_file::{self, Stage};

use super::{Seen, Template, spread};

/// See the [module](self).
pub struct SensorLag;

impl Template for SensorLag {
    fn name(&self) -> &'static str {
        "sensor-lag"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        spread(1.0, 0.01 * seen.duration_s / seen.sample_time_s, 3)
            .map(|samples| vec![samples.max(1.0).ln()])
            .collect()
    }

    fn bounds(&self, seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        let longest = 0.2 * seen.duration_s / seen.sample_time_s;
        vec![(0.03f64.ln(), longest.max(1.0).ln())]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[x] = numbers else { return None };
        Some(Stage::SensorLag(model_file::SensorLag {
            tau_s: x.exp() * seen.sample_time_s,
        }))
    }

    fn inverted(&self) -> bool {
        false
    }
}
