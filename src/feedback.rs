//! Feedback around a compensator: PID on what the compensator leaves over, for stages with a sensor.
//!
//! ```text
//! drive_k = clamp(feedforward_k + p_k + i_k + d_k, low, high)
//! p_k = K_p e_k,   i_k = i_(k-1) + K_i h (e_k + e_(k-1)) / 2,   e = reference - measured
//! d_k = d_(k-1) + (h / (T_f + h)) (-K_d (measured_k - measured_(k-1)) / h - d_(k-1))
//! ```
//!
//! The feedforward is the drive of a compensator for the same reference. The derivative is that of the
//! measurement, behind a filter, so that a step of the reference does not kick. Anti-windup: after
//! every sample the integral is pulled back to where the sum stays within the limits, so it never
//! stores what the converter cannot put out, and the drive leaves a limit in the sample in which the
//! rest of the sum does.

use crate::error::{Field, ParameterError, SampleError};
use crate::math::{Real, max, min};

/// Gains as they are tuned and stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gains<T> {
    /// `K_p` in V/um.
    pub proportional: T,
    /// `K_i` in V/(um s).
    pub integral: T,
    /// `K_d` in V s/um.
    pub derivative: T,
    /// `T_f`, time constant of the derivative's filter in s.
    pub filter: T,
}

/// PID with feedforward and anti-windup, built for one sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback<T> {
    proportional: T,
    /// `K_i h / 2`
    integral: T,
    /// `K_d / h`
    derivative: T,
    /// `h / (T_f + h)`
    filter: T,
    low: T,
    high: T,
}

/// What the controller remembers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T> {
    integral: T,
    derivative: T,
    error: T,
    measured: T,
}

impl<T: Real> State<T> {
    /// A stage at rest at `measured` (um), with nothing left over.
    pub fn at_rest(measured: T) -> Self {
        Self {
            integral: T::ZERO,
            derivative: T::ZERO,
            error: T::ZERO,
            measured,
        }
    }
}

impl<T: Real> Feedback<T> {
    /// The controller for samples `sample_time` seconds apart and drives from `low` to `high` volts.
    ///
    /// # Errors
    /// Gains or limits that are not finite, a negative filter time, limits in the wrong order, a
    /// sample time that is not positive.
    pub fn new(gains: Gains<T>, sample_time: T, low: T, high: T) -> Result<Self, ParameterError> {
        if !sample_time.is_finite() {
            return Err(ParameterError::NotFinite(Field::SampleTime, 0));
        }
        if sample_time <= T::ZERO {
            return Err(ParameterError::NotPositive(Field::SampleTime));
        }
        let half = T::from_f64(0.5);
        let integral = half * gains.integral * sample_time;
        let derivative = gains.derivative / sample_time;
        for (index, gain) in [gains.proportional, integral, derivative]
            .iter()
            .enumerate()
        {
            if !gain.is_finite() {
                return Err(ParameterError::NotFinite(Field::FeedbackGains, index));
            }
        }
        if !gains.filter.is_finite() {
            return Err(ParameterError::NotFinite(Field::TimeConstant, 0));
        }
        if gains.filter < T::ZERO {
            return Err(ParameterError::Negative(Field::TimeConstant));
        }
        if !(low.is_finite() && high.is_finite() && low < high) {
            return Err(ParameterError::NotIncreasing(Field::InputRange, 1));
        }
        Ok(Self {
            proportional: gains.proportional,
            integral,
            derivative,
            filter: sample_time / (gains.filter + sample_time),
            low,
            high,
        })
    }

    /// Drive (V) for the next sample: `feedforward` (V) is the compensator's, `reference` and
    /// `measured` in um.
    ///
    /// # Errors
    /// An input that is infinite or NaN, or so large that the sum is; the state is unchanged.
    #[inline(always)]
    pub fn step(
        &self,
        state: &mut State<T>,
        reference: T,
        measured: T,
        feedforward: T,
    ) -> Result<T, SampleError> {
        let error = reference - measured;
        let slope = self.derivative * (state.measured - measured);
        let derivative = state.derivative + self.filter * (slope - state.derivative);
        let rest = feedforward + self.proportional * error + derivative;
        let integral = state.integral + self.integral * (error + state.error);
        let sum = rest + integral;
        if !sum.is_finite() {
            return Err(SampleError::NotFinite);
        }
        // What the limits cut off comes out of the integral, but never pushes it past zero: a
        // feedforward beyond a limit is not the integral's to undo.
        let cut = if sum > self.high {
            min(sum - self.high, max(integral, T::ZERO))
        } else if sum < self.low {
            max(sum - self.low, min(integral, T::ZERO))
        } else {
            T::ZERO
        };
        *state = State {
            integral: integral - cut,
            derivative,
            error,
            measured,
        };
        Ok(max(min(sum, self.high), self.low))
    }
}
