//! Figures of merit of sampled signals.

use std::f64::consts::TAU;

/// Why a figure cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MetricError {
    /// Nothing to measure.
    #[error("the signal has no samples")]
    Empty,
    /// Two signals that belong together differ in length.
    #[error("signals of {left} and {right} samples do not belong together")]
    Length {
        /// Samples of the first.
        left: usize,
        /// Samples of the second.
        right: usize,
    },
    /// A sample is NaN or infinite.
    #[error("sample {index} is not finite")]
    NotFinite {
        /// Its zero-based number.
        index: usize,
    },
    /// The input turns more than twice in the cycle.
    #[error("the input is not one rise and one fall: it turns back at sample {index}")]
    NotOneLoop {
        /// The sample at which it moves against its branch.
        index: usize,
    },
    /// Input or output is constant, so a loop has no width or no range.
    #[error("the {signal} does not move")]
    NoRange {
        /// `input` or `output`.
        signal: &'static str,
    },
    /// The record does not hold whole periods of a frequency between 0 and half the sample rate.
    #[error("the record holds {cycles} periods: must be a whole number, 1 to below half a sample")]
    Periods {
        /// Periods in the record.
        cycles: f64,
    },
}

fn check(signal: &[f64]) -> Result<(), MetricError> {
    if signal.is_empty() {
        return Err(MetricError::Empty);
    }
    match signal.iter().position(|x| !x.is_finite()) {
        Some(index) => Err(MetricError::NotFinite { index }),
        None => Ok(()),
    }
}

fn check_pair(left: &[f64], right: &[f64]) -> Result<(), MetricError> {
    if left.len() != right.len() {
        return Err(MetricError::Length {
            left: left.len(),
            right: right.len(),
        });
    }
    check(left)?;
    check(right)
}

/// Largest |a - b|, in the unit of the signals.
///
/// # Errors
/// [`MetricError`] for signals that are empty, not finite or of different lengths.
pub fn max_abs_error(a: &[f64], b: &[f64]) -> Result<f64, MetricError> {
    check_pair(a, b)?;
    Ok(a.iter()
        .zip(b)
        .fold(0.0, |largest, (a, b)| (a - b).abs().max(largest)))
}

/// Root of the mean square of a - b, in the unit of the signals.
///
/// # Errors
/// As [`max_abs_error`].
pub fn rms_error(a: &[f64], b: &[f64]) -> Result<f64, MetricError> {
    check_pair(a, b)?;
    let sum: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
    Ok((sum / a.len() as f64).sqrt())
}

/// Root of the mean square, the mean included, in the unit of the signal.
///
/// # Errors
/// [`MetricError`] for a signal that is empty or not finite.
pub fn rms(signal: &[f64]) -> Result<f64, MetricError> {
    check(signal)?;
    let sum: f64 = signal.iter().map(|x| x * x).sum();
    Ok((sum / signal.len() as f64).sqrt())
}

/// Hysteresis of one steady cycle in percent: the largest vertical width of the loop over the range
/// of the output.
///
/// `input` and `output` are the same samples of exactly one period, which may start anywhere; the
/// last sample joins the first. The input must rise once and fall once (plateaus are allowed). The
/// width is the distance between the branches at equal input, each branch interpolated linearly.
///
/// # Errors
/// [`MetricError::NotOneLoop`] where the input turns back, [`MetricError::NoRange`] where nothing
/// moves, and what is said of signals in [`max_abs_error`].
pub fn hysteresis_percent(input: &[f64], output: &[f64]) -> Result<f64, MetricError> {
    check_pair(input, output)?;
    let (bottom, top) = extremes(input);
    let (low, high) = extremes(output);
    let range = output[high] - output[low];
    if input[top] <= input[bottom] {
        return Err(MetricError::NoRange { signal: "input" });
    }
    if range <= 0.0 {
        return Err(MetricError::NoRange { signal: "output" });
    }

    let rising = branch(input, output, bottom, top, 1.0)?;
    let mut falling = branch(input, output, top, bottom, -1.0)?;
    falling.reverse();
    // Both branches are piecewise linear, so their distance is largest at a knot of one of them.
    let widest = |knots: &[(f64, f64)], other: &[(f64, f64)]| {
        knots.iter().fold(0.0, |widest: f64, &(x, y)| {
            widest.max((y - interpolate(other, x)).abs())
        })
    };
    Ok(100.0 * widest(&rising, &falling).max(widest(&falling, &rising)) / range)
}

/// Indices of the smallest and the largest sample; the first of equal ones.
fn extremes(signal: &[f64]) -> (usize, usize) {
    signal
        .iter()
        .enumerate()
        .fold((0, 0), |(low, high), (k, &x)| {
            (
                if x < signal[low] { k } else { low },
                if x > signal[high] { k } else { high },
            )
        })
}

/// The points (input, output) from sample `from` to sample `to` of a closed cycle, both included;
/// the input must not move against `direction`.
fn branch(
    input: &[f64],
    output: &[f64],
    from: usize,
    to: usize,
    direction: f64,
) -> Result<Vec<(f64, f64)>, MetricError> {
    let len = input.len();
    let steps = (to + len - from) % len;
    let indices = (0..=steps).map(|step| (from + step) % len);
    let points: Vec<_> = indices.map(|k| (input[k], output[k])).collect();
    match points
        .windows(2)
        .position(|pair| direction * (pair[1].0 - pair[0].0) < 0.0)
    {
        Some(step) => Err(MetricError::NotOneLoop {
            index: (from + step) % len,
        }),
        None => Ok(points),
    }
}

/// Value at x of the polyline through points of ascending x; constant beyond its ends.
fn interpolate(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.partition_point(|point| point.0 <= x);
    match (after.checked_sub(1).map(|k| points[k]), points.get(after)) {
        (Some((x0, y0)), Some(&(x1, y1))) => y0 + (y1 - y0) * ((x - x0) / (x1 - x0)),
        (Some((_, y)), None) | (None, Some(&(_, y))) => y,
        (None, None) => f64::NAN,
    }
}

/// One spectral line, `amplitude * sin(2 pi f t + phase_rad)` with t = 0 at the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Amplitude, in the unit of the signal.
    pub amplitude: f64,
    /// Phase against a sine that starts at the first sample, rad, above -pi and up to pi.
    pub phase_rad: f64,
}

/// The line at `frequency_hz`: one bin of the discrete Fourier transform.
///
/// The record must hold whole periods of the frequency (to 1e-6 of a period); other lines that do
/// too, the mean included, then leave no trace in it.
///
/// # Errors
/// [`MetricError::Periods`] for another record length, and what is said of signals in [`rms`].
pub fn line(signal: &[f64], sample_time_s: f64, frequency_hz: f64) -> Result<Line, MetricError> {
    check(signal)?;
    let cycles = signal.len() as f64 * sample_time_s * frequency_hz;
    let whole = cycles.round();
    let holds = (cycles - whole).abs() <= 1e-6 && whole >= 1.0 && whole < signal.len() as f64 / 2.0;
    if !holds {
        return Err(MetricError::Periods { cycles });
    }
    let len = signal.len() as u128;
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (k, x) in signal.iter().enumerate() {
        // Whole turns are taken off in integers, which keeps late samples as exact as early ones.
        let at = ((k as u128 * whole as u128) % len) as f64 / len as f64;
        let (sin, cos) = (TAU * at).sin_cos();
        sine += x * sin;
        cosine += x * cos;
    }
    let scale = 2.0 / signal.len() as f64;
    Ok(Line {
        amplitude: scale * sine.hypot(cosine),
        phase_rad: cosine.atan2(sine),
    })
}
