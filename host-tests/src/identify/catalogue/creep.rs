//! Creep: its gain a decade, the logarithm of its shortest time constant in seconds, and over how many
//! decades it goes on.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct Creep;

impl Template for Creep {
    fn name(&self) -> &'static str {
        "creep"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        let longest = seen.duration_s;
        [
            (0.0, 10.0),
            (1.0, 40.0),
            (2.0, 300.0),
            (3.0, 3e3),
            (4.0, 3e4),
        ]
        .iter()
        .map(|&(decades, shorter)| {
            let shortest = (longest / shorter).max(5.0 * seen.sample_time_s);
            vec![0.02, shortest.ln(), decades]
        })
        .collect()
    }

    fn bounds(&self, seen: &Seen, numbers: &[f64]) -> Vec<(f64, f64)> {
        let decades = numbers.get(2).copied().unwrap_or(0.0);
        vec![
            (-0.1, 1.0),
            (seen.sample_time_s.ln(), (10.0 * seen.duration_s).ln()),
            (decades, decades),
        ]
    }

    fn stage(&self, numbers: &[f64], _seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[gain_per_decade, shortest, decades] = numbers else {
            return None;
        };
        Some(Stage::Creep(model_file::Creep {
            gain_per_decade,
            tau_min_s: shortest.exp(),
            tau_max_s: shortest.exp() * 10f64.powf(decades),
        }))
    }

    fn numbers(&self, stage: &Stage, _seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::Creep(creep) = stage else {
            return None;
        };
        let decades = (creep.tau_max_s / creep.tau_min_s).log10();
        Some(vec![creep.gain_per_decade, creep.tau_min_s.ln(), decades])
    }
}
