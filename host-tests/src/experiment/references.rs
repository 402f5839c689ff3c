//! Sampled test signals: drives in V or references in um, whatever the amplitude is given in.
//!
//! Phases are kept as fractions of a cycle, so a signal of many cycles stays as exact as its first.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// A uniformly sampled signal; sample k belongs to time k * `sample_time_s`.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Time between samples, s.
    pub sample_time_s: f64,
    /// The samples, in the unit of the amplitudes it was made from.
    pub samples: Vec<f64>,
}

/// A parameter that makes no signal.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{field} = {value}: {requirement}")]
pub struct ReferenceError {
    /// Name of the parameter.
    pub field: &'static str,
    /// Its value.
    pub value: f64,
    /// What it has to be.
    pub requirement: &'static str,
}

fn require(
    holds: bool,
    field: &'static str,
    value: f64,
    requirement: &'static str,
) -> Result<(), ReferenceError> {
    if holds {
        Ok(())
    } else {
        Err(ReferenceError {
            field,
            value,
            requirement,
        })
    }
}

/// When a signal is sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    sample_time_s: f64,
    len: usize,
}

impl Grid {
    /// `duration_s` seconds, rounded to whole samples of `sample_time_s` seconds.
    ///
    /// # Errors
    /// Names `sample_time_s` if it is not positive, `duration_s` if it is not 1 to 10^8 samples.
    pub fn for_duration(sample_time_s: f64, duration_s: f64) -> Result<Self, ReferenceError> {
        require_sample_time(sample_time_s)?;
        let len = whole_samples("duration_s", duration_s, duration_s / sample_time_s)?;
        Ok(Self { sample_time_s, len })
    }

    /// `cycles` cycles of `frequency_hz`, rounded to whole samples of `sample_time_s` seconds.
    ///
    /// # Errors
    /// Names `sample_time_s`, `frequency_hz` (not between 0 and half the sample rate) or `cycles`
    /// (not 1 to 10^8 samples).
    pub fn for_cycles(
        sample_time_s: f64,
        frequency_hz: f64,
        cycles: f64,
    ) -> Result<Self, ReferenceError> {
        require_sample_time(sample_time_s)?;
        require_frequency("frequency_hz", frequency_hz, sample_time_s)?;
        let len = whole_samples("cycles", cycles, cycles / frequency_hz / sample_time_s)?;
        Ok(Self { sample_time_s, len })
    }

    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.len
    }

    /// Samples a function of the phase of `frequency_hz` in cycles, counted from `phase_cycles`:
    /// it gets the number of the cycle and the fraction of it that has passed.
    fn sample(
        &self,
        frequency_hz: f64,
        phase_cycles: f64,
        f: impl Fn(f64, f64) -> f64,
    ) -> Reference {
        let cycles_per_sample = frequency_hz * self.sample_time_s;
        let samples = (0..self.len)
            .map(|k| {
                let phase = k as f64 * cycles_per_sample + phase_cycles;
                f(phase.floor(), phase - phase.floor())
            })
            .collect();
        Reference {
            sample_time_s: self.sample_time_s,
            samples,
        }
    }
}

fn require_sample_time(value: f64) -> Result<(), ReferenceError> {
    require(
        value > 0.0 && value.is_finite(),
        "sample_time_s",
        value,
        "must be positive",
    )
}

fn require_frequency(
    field: &'static str,
    value: f64,
    sample_time_s: f64,
) -> Result<(), ReferenceError> {
    let holds = value > 0.0 && value * sample_time_s < 0.5;
    require(
        holds,
        field,
        value,
        "must be above 0 and below half the sample rate",
    )
}

/// A number of samples as an integer; `field` and `value` are what it was computed from.
fn whole_samples(field: &'static str, value: f64, samples: f64) -> Result<usize, ReferenceError> {
    let samples = samples.round();
    require(
        (1.0..=1e8).contains(&samples),
        field,
        value,
        "must be 1 to 1e8 samples",
    )?;
    Ok(samples as usize)
}

fn require_finite(field: &'static str, value: f64) -> Result<(), ReferenceError> {
    require(value.is_finite(), field, value, "must be finite")
}

/// `amplitude * sin(2 pi frequency_hz t + phase_rad)`.
///
/// # Errors
/// Names the parameter that is not finite, or a frequency not below half the sample rate.
pub fn sine(
    grid: &Grid,
    amplitude: f64,
    frequency_hz: f64,
    phase_rad: f64,
) -> Result<Reference, ReferenceError> {
    require_finite("amplitude", amplitude)?;
    require_frequency("frequency_hz", frequency_hz, grid.sample_time_s)?;
    require_finite("phase_rad", phase_rad)?;
    Ok(grid.sample(frequency_hz, phase_rad / TAU, |_, at| {
        amplitude * (TAU * at).sin()
    }))
}

/// A symmetric triangle with the zeros and extremes of [`sine`].
///
/// # Errors
/// As [`sine`].
pub fn triangle(
    grid: &Grid,
    amplitude: f64,
    frequency_hz: f64,
    phase_rad: f64,
) -> Result<Reference, ReferenceError> {
    require_finite("amplitude", amplitude)?;
    require_frequency("frequency_hz", frequency_hz, grid.sample_time_s)?;
    require_finite("phase_rad", phase_rad)?;
    Ok(grid.sample(frequency_hz, phase_rad / TAU, |_, at| {
        let unit = if at < 0.25 {
            4.0 * at
        } else if at < 0.75 {
            2.0 - 4.0 * at
        } else {
            4.0 * at - 4.0
        };
        amplitude * unit
    }))
}

/// Periods of a sine whose amplitude alternates, `large`, `small`, `large`, ...
///
/// Each period starts and ends at zero on the rising branch, so the signal is continuous and its
/// rate jumps. With `small` below `large`, the extremes of a small period lie inside those of the
/// large ones: every small period is a closed minor loop that hangs on the rising branch of the
/// major loop. Two periods repeat.
///
/// # Errors
/// Names an amplitude that is not finite, `small` if it is not 0 to `large`, or a frequency not
/// below half the sample rate.
pub fn major_minor(
    grid: &Grid,
    large: f64,
    small: f64,
    frequency_hz: f64,
) -> Result<Reference, ReferenceError> {
    require_finite("large", large)?;
    require(
        (0.0..=large).contains(&small),
        "small",
        small,
        "must be 0 to large",
    )?;
    require_frequency("frequency_hz", frequency_hz, grid.sample_time_s)?;
    Ok(grid.sample(frequency_hz, 0.0, |cycle, at| {
        let amplitude = if cycle % 2.0 == 0.0 { large } else { small };
        amplitude * (TAU * at).sin()
    }))
}

/// One line of a sum of sines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Amplitude, in the unit of the signal.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Phase at time zero, rad.
    pub phase_rad: f64,
}

impl Tone {
    /// `amplitude * sin(2 pi frequency_hz t)`.
    pub const fn new(amplitude: f64, frequency_hz: f64) -> Self {
        Self {
            amplitude,
            frequency_hz,
            phase_rad: 0.0,
        }
    }
}

/// The sum of [`sine`]s with these amplitudes, frequencies and phases.
///
/// # Errors
/// As [`sine`], for the first tone that is refused.
pub fn tones(grid: &Grid, tones: &[Tone]) -> Result<Reference, ReferenceError> {
    let mut sum = Reference {
        sample_time_s: grid.sample_time_s,
        samples: vec![0.0; grid.len],
    };
    for tone in tones {
        let line = sine(grid, tone.amplitude, tone.frequency_hz, tone.phase_rad)?;
        sum.samples
            .iter_mut()
            .zip(&line.samples)
            .for_each(|(sum, line)| *sum += line);
    }
    Ok(sum)
}

/// `22 sin(2 pi f t) + 25 sin(6 pi f t)` V: the worked example of Al Janaideh and Krejci (2013),
/// section F, with minor loops inside a major one; f was 10 and 60 Hz.
///
/// # Errors
/// Names `frequency_hz` if three times it is not below half the sample rate.
pub fn example_f(grid: &Grid, fundamental_hz: f64) -> Result<Reference, ReferenceError> {
    tones(
        grid,
        &[
            Tone::new(22.0, fundamental_hz),
            Tone::new(25.0, 3.0 * fundamental_hz),
        ],
    )
}

/// Equal lines at `harmonics` times `fundamental_hz` with random phases from `seed`, scaled so that
/// the sample of largest magnitude has magnitude `peak`.
///
/// The signal repeats after 1/`fundamental_hz`. A seed means the same phases on every platform.
///
/// # Errors
/// Names `peak` if it is not finite, `harmonics` if the range is empty or starts at 0, or
/// `fundamental_hz` if it is not positive or the highest line is not below half the sample rate.
pub fn multisine(
    grid: &Grid,
    peak: f64,
    fundamental_hz: f64,
    harmonics: RangeInclusive<u32>,
    seed: u64,
) -> Result<Reference, ReferenceError> {
    require_finite("peak", peak)?;
    let first = *harmonics.start();
    require(
        first > 0 && !harmonics.is_empty(),
        "harmonics",
        f64::from(first),
        "must be a range that starts at 1 or above and is not empty",
    )?;
    let highest_hz = fundamental_hz * f64::from(*harmonics.end());
    require_frequency("fundamental_hz", highest_hz, grid.sample_time_s)?;

    let mut generator = Pcg64::seed_from_u64(seed);
    let lines: Vec<Tone> = harmonics
        .map(|k| {
            let turn: f64 = StandardUniform.sample(&mut generator);
            Tone {
                phase_rad: TAU * turn,
                ..Tone::new(1.0, fundamental_hz * f64::from(k))
            }
        })
        .collect();
    let mut signal = tones(grid, &lines)?;
    let largest = signal
        .samples
        .iter()
        .fold(0.0, |largest: f64, x| largest.max(x.abs()));
    require(
        largest > 0.0,
        "harmonics",
        f64::from(first),
        "must not cancel at every sample",
    )?;
    signal.samples.iter_mut().for_each(|x| *x *= peak / largest);
    Ok(signal)
}

/// A raster scan with both axes' references, which have the same samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster {
    /// Trace and retrace of every line: a triangle from 0 to the width and back.
    pub fast: Reference,
    /// Position of the line: constant during a trace, a ramp to the next line during a retrace.
    pub slow: Reference,
}

/// A scan of `lines` lines, `line_rate_hz` of them a second, over `width` by `height`.
///
/// The slow axis reaches `height` at the last line and stays there.
///
/// # Errors
/// Names `width` or `height` if it is not finite, `lines` if below 2 or too many samples, or
/// `line_rate_hz` if not below half the sample rate.
pub fn raster(
    sample_time_s: f64,
    width: f64,
    height: f64,
    lines: u32,
    line_rate_hz: f64,
) -> Result<Raster, ReferenceError> {
    require_finite("width", width)?;
    require_finite("height", height)?;
    require(lines >= 2, "lines", f64::from(lines), "must be at least 2")?;
    require_sample_time(sample_time_s)?;
    require_frequency("line_rate_hz", line_rate_hz, sample_time_s)?;
    let count = f64::from(lines);
    let len = whole_samples("lines", count, count / line_rate_hz / sample_time_s)?;
    let grid = Grid { sample_time_s, len };
    let intervals = f64::from(lines - 1);
    Ok(Raster {
        fast: grid.sample(line_rate_hz, 0.0, |_, at| {
            width * (1.0 - (2.0 * at - 1.0).abs())
        }),
        slow: grid.sample(line_rate_hz, 0.0, |line, at| {
            let position = line + (2.0 * at - 1.0).max(0.0);
            height * (position / intervals).min(1.0)
        }),
    })
}
