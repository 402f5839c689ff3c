//! Sine and cosine of a steadily growing angle, by rotation: no sine in the interrupt.
//!
//! A sample turns the pair (sin, cos) by the angle `d = 2 pi f h` and pulls its length back to one:
//!
//! ```text
//! e = (1 - sin^2 - cos^2) / 2
//! p = e - (1 + e) k,   q = (1 + e) sin d,          k = 1 - cos d
//! sin <- sin + (sin p + cos q)
//! cos <- cos + (cos p - sin q)
//! ```
//!
//! Without rounding the length `a` becomes `a (3 - a^2) / 2`, and an error `x = a - 1` becomes
//! `-(3/2) x^2 - (1/2) x^3`: what an error of the length was, is gone in the next sample. So the
//! length is off by the roundings of one sample, whatever the number of samples before, in single
//! precision by less than 5e-7. The angle is not pulled back: each sample adds the rounding of
//! `sin d` and of its own sums. `k` is kept in place of `cos d`, which near one would round the angle
//! away at low frequencies.

use crate::error::{Field, ParameterError};
use crate::math::{Real, quarter_turn};

/// The turn of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<T> {
    sine: T,
    /// 1 less the cosine.
    versine: T,
}

/// Sine and cosine of the angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phasor<T> {
    /// Sine.
    pub sine: T,
    /// Cosine.
    pub cosine: T,
}

impl<T: Real> Phasor<T> {
    /// Angle zero.
    pub fn zero() -> Self {
        Self {
            sine: T::ZERO,
            cosine: T::ONE,
        }
    }
}

impl<T: Real> Rotation<T> {
    /// The turn of `sample_time` seconds at `frequency` Hz.
    ///
    /// # Errors
    /// A frequency that is not finite, below zero or above half the sample rate.
    pub fn new(frequency: T, sample_time: T) -> Result<Self, ParameterError> {
        if !frequency.is_finite() {
            return Err(ParameterError::NotFinite(Field::Frequency, 0));
        }
        if frequency < T::ZERO {
            return Err(ParameterError::Negative(Field::Frequency));
        }
        // In double precision and once: the constants are right to the last bit of T = f32.
        let turns = frequency.to_f64() * sample_time.to_f64();
        if !(0.0..=0.5).contains(&turns) {
            return Err(ParameterError::TooLarge(Field::Frequency));
        }
        let (sine, cosine) = quarter_turn(core::f64::consts::PI * turns);
        Ok(Self {
            sine: T::from_f64(2.0 * sine * cosine),
            versine: T::from_f64(2.0 * sine * sine),
        })
    }

    /// Angle of the sample before angle zero.
    pub fn before_zero(&self) -> Phasor<T> {
        Phasor {
            sine: -self.sine,
            cosine: T::ONE - self.versine,
        }
    }

    /// Turns `phasor` by one sample.
    #[inline(always)]
    pub fn step(&self, phasor: &mut Phasor<T>) {
        let Phasor { sine, cosine } = *phasor;
        let half = T::from_f64(0.5);
        let excess = half - half * (sine * sine + cosine * cosine);
        let scale = T::ONE + excess;
        let (along, across) = (excess - scale * self.versine, scale * self.sine);
        phasor.sine = sine + (sine * along + cosine * across);
        phasor.cosine = cosine + (cosine * along - sine * across);
    }
}
