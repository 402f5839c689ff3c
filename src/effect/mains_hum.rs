//! Hum of the mains on the measured displacement (`mains-hum`), a line and its third harmonic:
//!
//! ```text
//! d(t) = A sin(2 pi f t + phi) + A_3 sin(6 pi f t + phi_3)
//! ```
//!
//! It hangs on the clock alone, so nothing on the target undoes it.

use crate::error::{Field, ParameterError};
use crate::math::{Real, sin};

/// A line of hum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line<T> {
    /// Amplitude in um.
    pub amplitude: T,
    /// Phase at time zero in rad.
    pub phase: T,
}

/// A line and its third harmonic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MainsHum<T> {
    frequency: f64,
    first: Line<T>,
    third: Line<T>,
}

impl<T: Real> MainsHum<T> {
    /// Hum of `frequency` Hz with its `first` and `third` harmonic.
    ///
    /// # Errors
    /// A frequency that is not positive, numbers that are not finite.
    pub fn new(frequency: T, first: Line<T>, third: Line<T>) -> Result<Self, ParameterError> {
        super::check_positive(frequency, Field::Frequency)?;
        for (number, field) in [
            (first.amplitude, Field::Amplitude),
            (first.phase, Field::Phase),
            (third.amplitude, Field::ThirdAmplitude),
            (third.phase, Field::ThirdPhase),
        ] {
            if !number.is_finite() {
                return Err(ParameterError::NotFinite(field, 0));
            }
        }
        Ok(Self {
            frequency: frequency.to_f64(),
            first,
            third,
        })
    }

    /// What is added (um) at `time` seconds.
    pub fn at(&self, time: f64) -> T {
        // Whole turns are taken off first, so that the angle keeps its digits in a long record.
        let turns = self.frequency * time;
        let line = |line: &Line<T>, harmonic: f64| {
            let turns = harmonic * turns;
            let angle = core::f64::consts::TAU * (turns - libm::floor(turns));
            line.amplitude * T::from_f64(sin(angle + line.phase.to_f64()))
        };
        line(&self.first, 1.0) + line(&self.third, 3.0)
    }
}
