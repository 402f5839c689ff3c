//! First-order lag: an amplifier before the hysteresis (`amplifier-lag`), a sensor behind everything
//! (`sensor-lag`).
//!
//! ```text
//! tau y' + y = x,       tau >= 0
//! ```
//!
//! The forward step is exact for an input joined by straight lines, with `e = e^(-h/tau)`:
//!
//! ```text
//! y_k = y_(k-1) + (1 - e) (x_(k-1) - y_(k-1)) + (1 - (1 - e) tau / h) (x_k - x_(k-1))
//! ```
//!
//! What rounding takes from the sum is carried to the next one: in single precision a slow lag would
//! stand still. The inverse is the equation itself, `x = y + tau y'`, with the derivative from two
//! samples to come.

use crate::error::{Field, ParameterError};
use crate::math::{Real, exp_m1};

use super::derivative::{self, Samples};

/// A first-order lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lag<T> {
    /// 1 - e
    approach: T,
    /// 1 - (1 - e) tau / h
    direct: T,
    /// tau / (12 h)
    twelfth: T,
}

/// State of the forward step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagState<T> {
    input: T,
    output: T,
    /// What rounding took from the output.
    carry: T,
}

impl<T: Real> LagState<T> {
    pub(super) fn at_rest(input: T) -> Self {
        Self {
            input,
            output: input,
            carry: T::ZERO,
        }
    }
}

impl<T: Real> Lag<T> {
    /// Samples that the inverse looks ahead.
    pub const LATENCY: usize = derivative::LATENCY;

    /// A lag of `tau` seconds for samples `sample_time` seconds apart.
    ///
    /// # Errors
    /// A time constant that is negative or not finite, a sample time that is not positive.
    pub fn new(tau: T, sample_time: T) -> Result<Self, ParameterError> {
        let samples = super::in_samples(tau, sample_time, Field::TimeConstant)?;
        let approach = if samples > 0.0 {
            -exp_m1(-1.0 / samples)
        } else {
            1.0
        };
        // The difference of two near numbers, for a slow lag as the beginning of its series.
        let direct = if samples > 1e4 {
            (0.5 - 1.0 / (6.0 * samples)) / samples
        } else {
            1.0 - approach * samples
        };
        Ok(Self {
            approach: T::from_f64(approach),
            direct: T::from_f64(direct),
            twelfth: T::from_f64(samples / 12.0),
        })
    }

    /// State after a long rest at `input`.
    pub fn start(&self, input: T) -> LagState<T> {
        LagState::at_rest(input)
    }

    /// How much of a sample's input its output holds at once.
    pub(super) fn direct(&self) -> T {
        self.direct
    }

    /// The next output less what [`Lag::direct`] lets through.
    #[inline(always)]
    pub(super) fn held(&self, state: &LagState<T>) -> T {
        let approach = self.approach * (state.input - state.output);
        state.output + (approach - self.direct * state.input + state.carry)
    }

    /// Output for the next input.
    #[inline(always)]
    pub fn step(&self, state: &mut LagState<T>, input: T) -> T {
        let approach = self.approach * (state.input - state.output);
        let change = approach + self.direct * (input - state.input) + state.carry;
        let output = state.output + change;
        state.carry = change - (output - state.output);
        state.output = output;
        state.input = input;
        output
    }

    /// State of the inverse after a long rest at `output`.
    pub fn start_inverse(&self, output: T) -> Samples<T> {
        Samples::at_rest(output)
    }

    /// Input that belongs to the output of [`Lag::LATENCY`] samples ago.
    #[inline(always)]
    pub fn step_inverse(&self, state: &mut Samples<T>, output: T) -> T {
        let at = state.push(output);
        at.value + self.twelfth * at.twelve_first
    }
}
