//! Transport delay, whole and fractional (`transport-delay`).
//!
//! ```text
//! y(t) = x(t - D),      0 <= D
//! ```
//!
//! Between samples the signal is a cubic through four of them (Lagrange), exact for cubics, with an
//! error of `(3/128) h^4 x''''` at most where two of the four lie on either side. The inverse is an
//! advance: the signal is taken in ahead of time and delayed by what is too much.

use crate::error::{Field, ParameterError};
use crate::math::Real;

/// A delay of up to `SPAN - 3` samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Delay<T, const SPAN: usize> {
    /// Age of the newest of the four samples.
    first: usize,
    taps: [T; 4],
    /// Samples that an advance looks ahead.
    ahead: usize,
    advance_taps: [T; 4],
}

/// The newest samples, newest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DelayState<T, const SPAN: usize>([T; SPAN]);

/// The four newest samples, newest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdvanceState<T>([T; 4]);

impl<T: Real, const SPAN: usize> Delay<T, SPAN> {
    /// A delay of `delay` seconds for samples `sample_time` seconds apart.
    ///
    /// # Errors
    /// A delay that is negative, not finite or beyond `SPAN - 3` samples, a sample time that is not
    /// positive.
    pub fn new(delay: T, sample_time: T) -> Result<Self, ParameterError> {
        const { assert!(SPAN >= 4, "a delay is made of four samples") };
        let samples = super::in_samples(delay, sample_time, Field::Delay)?;
        if samples > (SPAN - 3) as f64 {
            return Err(ParameterError::TooLarge(Field::Delay));
        }
        let whole = samples as usize;
        let first = if whole == 0 { 0 } else { whole - 1 };
        // The advance: two samples more than the delay, less what is too much.
        let ahead = whole + 2;
        Ok(Self {
            first,
            taps: lagrange(samples - first as f64),
            ahead,
            advance_taps: lagrange(ahead as f64 - samples),
        })
    }

    /// State after a long rest at `input`.
    pub fn start(&self, input: T) -> DelayState<T, SPAN> {
        DelayState([input; SPAN])
    }

    /// Output for the next input.
    #[inline(always)]
    pub fn step(&self, state: &mut DelayState<T, SPAN>, input: T) -> T {
        let samples = &mut state.0;
        samples.rotate_right(1);
        if let Some(newest) = samples.first_mut() {
            *newest = input;
        }
        let four = samples.iter().skip(self.first);
        weigh(&self.taps, four)
    }

    /// Samples that the inverse looks ahead.
    pub fn latency(&self) -> usize {
        self.ahead
    }

    /// State of the inverse after a long rest at `output`.
    pub fn start_inverse(&self, output: T) -> AdvanceState<T> {
        AdvanceState([output; 4])
    }

    /// Input for the time of the sample that came [`Delay::latency`] samples ago: the delay makes it
    /// that sample's output.
    #[inline(always)]
    pub fn step_inverse(&self, state: &mut AdvanceState<T>, output: T) -> T {
        let [a, b, c, _] = state.0;
        state.0 = [output, a, b, c];
        weigh(&self.advance_taps, state.0.iter())
    }
}

#[inline(always)]
fn weigh<'a, T: Real>(taps: &[T; 4], samples: impl Iterator<Item = &'a T>) -> T {
    taps.iter()
        .zip(samples)
        .fold(T::ZERO, |sum, (&tap, &sample)| sum + tap * sample)
}

/// Weights of four samples at ages 0 to 3 for the value at `age` between them.
fn lagrange<T: Real>(age: f64) -> [T; 4] {
    let (a, b, c, d) = (age, age - 1.0, age - 2.0, age - 3.0);
    [
        -b * c * d / 6.0,
        a * c * d / 2.0,
        -a * b * d / 2.0,
        a * b * c / 6.0,
    ]
    .map(T::from_f64)
}
