//! Mains hum: cosine and sine of a line and of its third over half the range of the displacement, and what
//! the line is off 50 or 60 Hz over the records' whole time.

use crate::model_file::{self, Stage};

use super::{Seen, Template};

/// See the [module](self).
pub struct MainsHum;

/// How far the mains may be off, over their frequency.
const OFF: f64 = 0.012;
/// Frequencies that are tried for each line at most.
const TRIED: usize = 1_500;

/// Starts at the frequencies near 50 and 60 Hz that stand out of what is left over: absolute time in s
/// and residual in um.
pub fn hum_starts(seen: &Seen, left: &[(f64, f64)]) -> Vec<Vec<f64>> {
    let span = seen.time_s.1 - seen.time_s.0;
    let start = |line: f64| {
        let widest = OFF * line * span;
        let count = ((8.0 * widest) as usize).clamp(1, TRIED);
        let found = (0..=count).map(|i| {
            let off = widest * (2.0 * i as f64 / count as f64 - 1.0);
            let turns = std::f64::consts::TAU * (line + off / span);
            let (cosine, sine) = left.iter().fold((0.0, 0.0), |(c, s), &(time, residual)| {
                let (sine, cosine) = (turns * time).sin_cos();
                (c + residual * cosine, s + residual * sine)
            });
            let unit = 2.0 / left.len().max(1) as f64 / seen.displacement_um;
            (off, unit * cosine, unit * sine)
        });
        let best = found.max_by(|a, b| a.1.hypot(a.2).total_cmp(&b.1.hypot(b.2)));
        let (off, cosine, sine) = best.unwrap_or_default();
        vec![cosine, sine, 0.0, 0.0, off, line]
    };
    vec![start(50.0), start(60.0)]
}

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
