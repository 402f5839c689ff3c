//! Amplifier lag: the logarithm of its time constant in samples.

use crate::model_file::{self, Stage};

use super::{Seen, Template, spread};

/// See the [module](self).
pub struct AmplifierLag;

impl Template for AmplifierLag {
    fn name(&self) -> &'static str {
        "amplifier-lag"
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
        Some(Stage::AmplifierLag(model_file::AmplifierLag {
            tau_s: x.exp() * seen.sample_time_s,
        }))
    }
}
