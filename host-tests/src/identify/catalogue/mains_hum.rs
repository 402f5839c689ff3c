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

/// Turns by which the mains may be off within samples that are taken together.
const TOGETHER: f64 = 0.03;

/// Starts at the frequencies near 50 and 60 Hz that stand out of what is left over: absolute time in s
/// and residual in um, times rising within a record.
pub fn hum_starts(seen: &Seen, left: &[(f64, f64)]) -> Vec<Vec<f64>> {
    let span = seen.time_s.1 - seen.time_s.0;
    let start = |line: f64| {
        let widest = OFF * line * span;
        let parts = demodulated(left, line, TOGETHER / (OFF * line));
        let count = ((8.0 * widest) as usize).clamp(1, TRIED);
        let found = (0..=count).map(|i| {
            let off = widest * (2.0 * i as f64 / count as f64 - 1.0);
            let turns = std::f64::consts::TAU * off / span;
            let (cosine, sine) = parts.iter().fold((0.0, 0.0), |(c, s), part| {
                let (sine, cosine) = (turns * part.time_s).sin_cos();
                (
                    c + part.cosine * cosine - part.sine * sine,
                    s + part.sine * cosine + part.cosine * sine,
                )
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

/// What a few samples hold of a line.
struct Part {
    time_s: f64,
    cosine: f64,
    sine: f64,
}

/// Parts of up to `longest` seconds, with the line's own turns taken out.
fn demodulated(left: &[(f64, f64)], line: f64, longest: f64) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    let mut end = f64::NEG_INFINITY;
    let mut last = f64::INFINITY;
    for &(time, residual) in left {
        if time >= end || time < last {
            end = time + longest;
            parts.push(Part {
                time_s: time + 0.5 * longest,
                cosine: 0.0,
                sine: 0.0,
            });
        }
        last = time;
        let (sine, cosine) = (std::f64::consts::TAU * line * time).sin_cos();
        if let Some(part) = parts.last_mut() {
            part.cosine += residual * cosine;
            part.sine += residual * sine;
        }
    }
    parts
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

    fn numbers(&self, stage: &Stage, seen: &Seen, _gain: f64) -> Option<Vec<f64>> {
        let Stage::MainsHum(hum) = stage else {
            return None;
        };
        let at = |amplitude: f64, phase: f64| {
            let size = amplitude / seen.displacement_um;
            [size * phase.sin(), size * phase.cos()]
        };
        let [cosine, sine] = at(hum.amplitude, hum.phase_rad);
        let [third_cosine, third_sine] = at(hum.third_amplitude, hum.third_phase_rad);
        let near = |line: &f64| (hum.frequency_hz / line - 1.0).abs() < OFF;
        let line = [50.0, 60.0].into_iter().find(near);
        let line = line.unwrap_or(hum.frequency_hz);
        let off = (hum.frequency_hz - line) * (seen.time_s.1 - seen.time_s.0);
        Some(vec![cosine, sine, third_cosine, third_sine, off, line])
    }

    fn inverted(&self) -> bool {
        false
    }
}
