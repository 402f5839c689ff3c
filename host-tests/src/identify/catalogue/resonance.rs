//! A mode: the logarithms of its frequency and damping ratio.

use crate::model_file::{self, Stage};

use super::{Seen, Template, spread};

/// See the [module](self).
pub struct Resonance;

impl Template for Resonance {
    fn name(&self) -> &'static str {
        "resonance"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        let (low, high) = (2.0 / seen.duration_s, 0.3 / seen.sample_time_s);
        // Close enough for a lightly damped mode to be met by its own width.
        spread(low.min(0.1 * high), high, 60)
            .flat_map(|f_n_hz| [0.02f64, 0.1].map(|zeta| vec![f_n_hz.ln(), zeta.ln()]))
            .collect()
    }

    fn bounds(&self, seen: &Seen, _numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![
            (
                (0.5 / seen.duration_s).ln(),
                (0.45 / seen.sample_time_s).ln(),
            ),
            (1e-3f64.ln(), 0.9f64.ln()),
        ]
    }

    fn stage(&self, numbers: &[f64], _seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[frequency, damping] = numbers else {
            return None;
        };
        Some(Stage::Resonance(model_file::Resonance {
            f_n_hz: frequency.exp(),
            zeta: damping.exp(),
        }))
    }

    fn numbers(&self, stage: &Stage, _seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::Resonance(mode) = stage else {
            return None;
        };
        Some(vec![mode.f_n_hz.ln(), mode.zeta.ln()])
    }
}
