//! Drift of the measured displacement (`drift`), towards an end at `D`:
//!
//! ```text
//! d(t) = D (1 - e^(-t / tau)),     tau > 0
//! ```
//!
//! For `tau` far beyond the record it is the line `D t / tau`. It hangs on the clock alone, so nothing
//! on the target undoes it.

use crate::error::{Field, ParameterError};
use crate::math::{Real, exp_m1};

/// Drift to one side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift<T> {
    amplitude: T,
    tau: f64,
}

impl<T: Real> Drift<T> {
    /// Drift by `amplitude` um in the end, with the time constant `tau` in seconds.
    ///
    /// # Errors
    /// An amplitude that is not finite, a time constant that is not positive or not finite.
    pub fn new(amplitude: T, tau: T) -> Result<Self, ParameterError> {
        if !amplitude.is_finite() {
            return Err(ParameterError::NotFinite(Field::Amplitude, 0));
        }
        super::check_positive(tau, Field::TimeConstant)?;
        Ok(Self {
            amplitude,
            tau: tau.to_f64(),
        })
    }

    /// What has been added (um) at `time` seconds.
    pub fn at(&self, time: f64) -> T {
        self.amplitude * T::from_f64(-exp_m1(-time / self.tau))
    }
}
