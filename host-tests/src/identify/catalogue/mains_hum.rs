//! Mains hum: cosine and sine of a line and of its third over half the range of the displacement, and what
//! the line is off 50 or 60 Hz over the records' whole time.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct MainsHum;

impl Template for MainsHum {
    fn name(&self) -> &'static str {
        "mains-hum"
    }

    fn starts(&self, _seen: &Seen) -> Vec<Vec<f64>> {
        [50.0, 60.0]
            .iter()
            .map(|&line| vec![0.0, 0.0, 0.0, 0.0, 0.0, line])
            .collect()
    }

    fn bounds(&self, seen: &Seen, numbers: &[f64]) -> Vec<(f64, f64)> {
        let line = numbers.get(5).copied().unwrap_or(50.0);
        let off = 0.02 * line * (seen.time_s.1 - seen.time_s.0);
        let size = (-1.0, 1.0);
        vec![size, size, size, size, (-off, off), (line, line)]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, _gain: f64) -> Option<Stage> {
        let &[cosine, sine, third_cosine, third_sine, off, line] = numbers else {
            return None;
        };
        let polar = |cosine: f64, sine: f64| {
            (
                cosine.hypot(sine) * seen.displacement_um,
                cosine.atan2(sine),
            )
        };
        let (amplitude, phase_rad) = polar(cosine, sine);
        let (third_amplitude, third_phase_rad) = polar(third_cosine, third_sine);
        Some(Stage::MainsHum(model_file::MainsHum {
            frequency_hz: line + off / (seen.time_s.1 - seen.time_s.0),
            amplitude,
            phase_rad,
            third_amplitude,
            third_phase_rad,
        }))
    }

    fn inverted(&self) -> bool {
        false
    }
}
