//! The lines of a periodic drive, and what kind of frequency each line of a residual is.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex64;

use super::super::diagnosis::RecordResiduals;
use crate::identify::spectrum::band;

/// How far the drive may be from repeating itself, mean square over its own.
const REPEATS: f64 = 1e-4;
/// Power of the least driven line over that of the largest.
const DRIVEN: f64 = 1e-3;
/// Lines of the mains, Hz.
const MAINS: [f64; 4] = [50.0, 60.0, 150.0, 180.0];

/// Kinds of frequencies, as they are called in a sentence.
pub(super) const KINDS: [&str; 7] = [
    "on driven lines",
    "on odd lines",
    "on even lines",
    "between the lines",
    "on lines of the mains",
    "in the band of the drive",
    "outside the band of the drive",
];

/// Odd multiples of the drive's period that are not driven.
pub(super) const ODD: usize = 1;

/// A record's spectrum, its mean taken out.
pub(super) struct Spectrum {
    /// Frequency step in Hz.
    pub step_hz: f64,
    /// Power of the residual at step 1, 2, ..; their sum is the mean square about the mean.
    pub power: Vec<f64>,
    /// The same of the displacement.
    pub motion: Vec<f64>,
    /// Kind of each.
    pub kinds: Vec<usize>,
    /// Multiple of the drive's period, of the lines, and whether the drive is one line alone.
    pub periods: Option<(usize, bool)>,
}

impl Spectrum {
    /// Whole periods from the end where the drive repeats itself, else all of the record.
    pub fn new(record: &RecordResiduals) -> Option<Self> {
        let count = record.residual_um.len();
        let period = period(&record.drive_v);
        let (from, periods) = match period {
            Some(period) => (count - count / period * period, Some(count / period)),
            None => (0, None),
        };
        let residual = powers(&record.residual_um[from..], periods.is_none())?;
        let motion = powers(&record.displacement_um[from..], periods.is_none())?;
        let drive = powers(&record.drive_v[from..], periods.is_none())?;
        let step_hz = 1.0 / ((count - from) as f64 * record.sample_time_s);
        let largest = drive.iter().fold(0.0, |a: f64, &b| a.max(b));
        let driven = |line: usize| drive[line - 1] > DRIVEN * largest;
        let mut driven_lines = 0;
        let edges = band(&record.drive_v, record.sample_time_s);
        let kinds = (1..=residual.len())
            .map(|line| {
                let hz = line as f64 * step_hz;
                match periods {
                    Some(m) if line % m == 0 && driven(line) => {
                        driven_lines += 1;
                        0
                    }
                    _ if MAINS.iter().any(|mains| (hz - mains).abs() <= step_hz) => 4,
                    Some(m) if line % m == 0 => {
                        if line / m % 2 == 1 {
                            ODD
                        } else {
                            2
                        }
                    }
                    Some(_) => 3,
                    None => match edges {
                        Some((low, high)) if hz >= low && hz <= high => 5,
                        _ => 6,
                    },
                }
            })
            .collect();
        Some(Self {
            step_hz,
            power: residual,
            motion,
            kinds,
            periods: periods.map(|m| (m, driven_lines == 1)),
        })
    }
}

/// Power of each line above zero; `windowed` for signals that do not repeat themselves.
fn powers(signal: &[f64], windowed: bool) -> Option<Vec<f64>> {
    let count = signal.len();
    let mean = signal.iter().sum::<f64>() / count.max(1) as f64;
    let mut values: Vec<f64> = signal.iter().map(|v| v - mean).collect();
    if windowed {
        // A Hann window of unit mean square.
        let scale = (2.0f64 / 3.0).sqrt();
        for (k, v) in values.iter_mut().enumerate() {
            let phase = std::f64::consts::TAU * (k as f64 + 0.5) / count as f64;
            *v *= scale * (1.0 - phase.cos());
        }
    }
    let transform = RealFftPlanner::new().plan_fft_forward(count);
    let mut lines = transform.make_output_vec();
    transform.process(&mut values, &mut lines).ok()?;
    let squared = (count as f64).powi(2);
    let nyquist = count.is_multiple_of(2).then_some(count / 2);
    Some(
        lines
            .iter()
            .enumerate()
            .skip(1)
            .map(|(line, value)| {
                let sides = if Some(line) == nyquist { 1.0 } else { 2.0 };
                sides * value.norm_sqr() / squared
            })
            .collect(),
    )
}

/// The least number of samples after which the drive repeats itself, seen over at least half of its
/// motion.
fn period(drive: &[f64]) -> Option<usize> {
    let count = drive.len();
    let mean = drive.iter().sum::<f64>() / count.max(1) as f64;
    let centred: Vec<f64> = drive.iter().map(|u| u - mean).collect();
    let mut sums = vec![0.0];
    for u in &centred {
        sums.push(sums[sums.len() - 1] + u * u);
    }
    let total = sums[count];
    if total <= 0.0 || !total.is_finite() {
        return None;
    }
    let products = autocorrelation(&centred)?;
    let scaled = |lag: usize| {
        // Sum of squared differences over the overlap, relative to the squares in it.
        let squares = (sums[count] - sums[lag]) + sums[count - lag];
        (squares - 2.0 * products[lag], squares)
    };
    let repeats = |lag: usize| {
        let (difference, squares) = scaled(lag);
        squares > 0.4 * total && difference < REPEATS * squares
    };
    let longest = count - count / 8;
    // Past the lags that are short against the motion itself.
    let first = (1..longest).find(|&lag| !repeats(lag))?;
    let lag = (first..longest).find(|&lag| repeats(lag))?;
    // The best of the neighbours that pass.
    let best = (lag..longest)
        .take_while(|&lag| repeats(lag))
        .min_by(|&a, &b| scaled(a).0.total_cmp(&scaled(b).0))?;
    (best >= 8).then_some(best)
}

fn autocorrelation(signal: &[f64]) -> Option<Vec<f64>> {
    let count = (2 * signal.len()).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(count);
    let mut padded = signal.to_vec();
    padded.resize(count, 0.0);
    let mut lines = forward.make_output_vec();
    forward.process(&mut padded, &mut lines).ok()?;
    for line in &mut lines {
        *line = Complex64::new(line.norm_sqr() / count as f64, 0.0);
    }
    planner
        .plan_fft_inverse(count)
        .process(&mut lines, &mut padded)
        .ok()?;
    padded.truncate(signal.len());
    Some(padded)
}
