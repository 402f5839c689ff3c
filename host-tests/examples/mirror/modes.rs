//! Modes and delay in a separated response.

use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::recording::AXES;
use super::response::Response;

/// Lines to either side of a peak that its mode is fitted to.
const NEAR: usize = 10;
/// Lines to either side that a peak is the highest of, and of which it stands out.
const PEAK: usize = 15;
const AROUND: usize = 100;
/// How far a peak stands above the median around it.
const PROMINENT: f64 = 1.5;

/// A mode that all nine paths share.
#[derive(Clone, Copy, Debug)]
pub struct Mode {
    /// Natural frequency in Hz.
    pub hz: f64,
    /// Damping ratio.
    pub zeta: f64,
    /// Share of the response near it that one mode and a straight line do not explain, rms.
    pub left: f64,
    /// How far the nine residues lie on one line through zero, 0 to 1.
    pub aligned: f64,
    /// Delay by which that line is turned, s, taken nearest to a guess: a lightly damped mode alone has real residues.
    pub delay_s: f64,
}

/// Delay in s of one path from the slope of its phase between two frequencies, and the phase in rad
/// that the slope leaves at zero frequency, its sign taken out.
pub fn delay(response: &Response, axis: usize, from_hz: f64, to_hz: f64) -> (f64, f64) {
    let mut turned: f64 = 0.0;
    let mut before = f64::NAN;
    let mut points = Vec::new();
    for line in 1..response.lines.len() {
        let hz = response.hz(line);
        if !(from_hz..=to_hz).contains(&hz) {
            continue;
        }
        let phase = response.lines[line][(axis, axis)].arg();
        if !before.is_nan() {
            turned -= TAU * ((phase - before) / TAU).round();
        }
        before = phase;
        points.push((TAU * hz, phase + turned));
    }
    let count = points.len() as f64;
    let middle = points.iter().map(|p| p.0).sum::<f64>() / count;
    let mean = points.iter().map(|p| p.1).sum::<f64>() / count;
    let along: f64 = points.iter().map(|p| (p.0 - middle) * (p.1 - mean)).sum();
    let size: f64 = points.iter().map(|p| (p.0 - middle).powi(2)).sum();
    let slope = along / size;
    let start = mean - slope * middle;
    (-slope, start - PI * (start / PI).round())
}

/// The modes between two frequencies, from the lowest; their delays nearest to `guess_s`.
pub fn modes(response: &Response, from_hz: f64, to_hz: f64, guess_s: f64) -> Vec<Mode> {
    let size: Vec<f64> = response.lines.iter().map(|g| g.norm()).collect();
    (AROUND..size.len().saturating_sub(AROUND))
        .filter(|&line| (from_hz..=to_hz).contains(&response.hz(line)))
        .filter(|&line| {
            let highest = size[line - PEAK..=line + PEAK]
                .iter()
                .all(|s| *s <= size[line]);
            let mut around = size[line - AROUND..=line + AROUND].to_vec();
            around.sort_by(f64::total_cmp);
            highest && size[line] > PROMINENT * around[AROUND]
        })
        .map(|line| mode(response, line, guess_s))
        .collect()
}

/// Fits `H = R / (s - p) + b + c s` to all nine paths near a line, p shared: `s H = p H + (...) + (...) s`
/// is linear in everything; divided by `s - p` of the round before, it weighs the errors of H itself.
fn mode(response: &Response, peak: usize, guess_s: f64) -> Mode {
    const ROUNDS: usize = 20;
    let centre = TAU * response.hz(peak);
    let lines = peak - NEAR..=peak + NEAR;
    let s: Vec<Complex<f64>> = lines
        .clone()
        .map(|line| Complex::new(0.0, TAU * response.hz(line) - centre))
        .collect();
    let paths: Vec<Vec<Complex<f64>>> = (0..AXES * AXES)
        .map(|path| {
            let at = |line: usize| response.lines[line][(path / AXES, path % AXES)];
            lines.clone().map(at).collect()
        })
        .collect();
    let mut pole = Complex::new(-0.01 * centre, 0.0);
    for _ in 0..ROUNDS {
        let basis = Basis::new(&s, pole);
        let (mut along, mut square) = (Complex::new(0.0, 0.0), 0.0);
        for path in &paths {
            let plain = basis.without(path.iter().zip(&basis.weight).map(|(h, w)| h * w));
            let moved = path.iter().zip(&s).zip(&basis.weight);
            let moved = basis.without(moved.map(|((h, s), w)| h * s * w));
            for (plain, moved) in plain.iter().zip(&moved) {
                along += plain.conj() * moved;
                square += plain.norm_sqr();
            }
        }
        pole = along / square;
    }
    let basis = Basis::new(&s, pole);
    let (mut left, mut whole) = (0.0, 0.0);
    let (mut squares, mut sizes) = (Complex::new(0.0, 0.0), 0.0_f64);
    for path in &paths {
        let weighed = path.iter().zip(&s).zip(&basis.weight);
        let target: Vec<_> = weighed.map(|((h, s), w)| h * (s - pole) * w).collect();
        let rest = basis.without(target.iter().copied());
        left += rest.iter().map(|e| e.norm_sqr()).sum::<f64>();
        whole += path.iter().map(|h| h.norm_sqr()).sum::<f64>();
        // R is the value of the straight line at the pole.
        let turned = Complex::<f64>::i() * basis.line_at(&target, pole);
        squares += turned * turned;
        sizes += turned.norm_sqr();
    }
    let pole = pole + Complex::new(0.0, centre);
    let angle = 0.5 * squares.arg();
    let turns = ((guess_s * pole.norm() + angle) / PI).round();
    Mode {
        hz: pole.norm() / TAU,
        zeta: -pole.re / pole.norm(),
        left: (left / whole).sqrt(),
        aligned: squares.norm() / sizes,
        delay_s: (turns * PI - angle) / pole.norm(),
    }
}

/// The straight lines in s over `s - p`, made orthonormal.
struct Basis {
    /// One over the size of `s - p`, by line.
    weight: Vec<f64>,
    level: Vec<Complex<f64>>,
    slope: Vec<Complex<f64>>,
    /// `slope` is (s - `middle`) `weight` / `spread`, `level` is `weight` / `norm`.
    middle: Complex<f64>,
    spread: f64,
    norm: f64,
}

impl Basis {
    fn new(s: &[Complex<f64>], pole: Complex<f64>) -> Self {
        let weight: Vec<f64> = s.iter().map(|s| 1.0 / (s - pole).norm()).collect();
        let norm = weight.iter().map(|w| w * w).sum::<f64>().sqrt();
        let sum: Complex<f64> = s.iter().zip(&weight).map(|(s, w)| s * (w * w)).sum();
        let middle = sum / (norm * norm);
        let off = |(s, w): (&Complex<f64>, &f64)| (s - middle) * *w;
        let squares = s.iter().zip(&weight).map(|pair| off(pair).norm_sqr());
        let spread = squares.sum::<f64>().sqrt();
        Self {
            level: weight.iter().map(|w| Complex::from(w / norm)).collect(),
            slope: s
                .iter()
                .zip(&weight)
                .map(|pair| off(pair) / spread)
                .collect(),
            weight,
            middle,
            spread,
            norm,
        }
    }

    /// How much of the two lines values hold.
    fn parts(&self, values: &[Complex<f64>]) -> [Complex<f64>; 2] {
        [&self.level, &self.slope].map(|line| {
            let products = line.iter().zip(values).map(|(l, v)| l.conj() * v);
            products.sum()
        })
    }

    /// Values less the best straight line.
    fn without(&self, values: impl Iterator<Item = Complex<f64>>) -> Vec<Complex<f64>> {
        let mut values: Vec<_> = values.collect();
        let [level, slope] = self.parts(&values);
        for ((value, l), s) in values.iter_mut().zip(&self.level).zip(&self.slope) {
            *value -= level * l + slope * s;
        }
        values
    }

    /// The best straight line through values, not weighed, at a point.
    fn line_at(&self, values: &[Complex<f64>], point: Complex<f64>) -> Complex<f64> {
        let [level, slope] = self.parts(values);
        level / self.norm + slope * (point - self.middle) / self.spread
    }
}
