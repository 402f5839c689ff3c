//! Creep (`creep`): first-order states whose time constants lie a decade apart.
//!
//! ```text
//! y = x + sum c (x_j - x(0)),   tau_j x_j' + x_j = x,   tau_j = tau_min, 10 tau_min, ... tau_max
//! ```
//!
//! With one state a decade and the same weight `c` on each, the step response grows by `c` a decade
//! between `tau_min` and `tau_max`: logarithmic creep, `c` its gain per decade. Before the start the
//! input has rested at its first value. Every state is a [`super::lag::Lag`]; the sum is solved for
//! `x`, so the inverse is exact and needs no preview.

use crate::error::{Field, ParameterError};
use crate::math::Real;

use super::lag::{Lag, LagState};

/// Creep over up to `DECADES` states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Creep<T, const DECADES: usize> {
    len: usize,
    gain: T,
    lags: [Lag<T>; DECADES],
    /// 1 / (1 + c times the sum of what a lag lets through at once)
    per_direct: T,
}

/// State of creep, forward and inverse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CreepState<T, const DECADES: usize> {
    first: T,
    lags: [LagState<T>; DECADES],
}

impl<T: Real, const DECADES: usize> Creep<T, DECADES> {
    /// Creep with `gain_per_decade` from `tau_min` to `tau_max` seconds; there is one state for each
    /// decade begun.
    ///
    /// # Errors
    /// A gain that is not finite or so negative that the direct part vanishes, time constants that
    /// are not positive or in the wrong order, more than `DECADES` states.
    pub fn new(
        gain_per_decade: T,
        tau_min: T,
        tau_max: T,
        sample_time: T,
    ) -> Result<Self, ParameterError> {
        if !gain_per_decade.is_finite() {
            return Err(ParameterError::NotFinite(Field::CreepGain, 0));
        }
        for (tau, field) in [
            (tau_min, Field::CreepShortest),
            (tau_max, Field::CreepLongest),
        ] {
            if !tau.is_finite() {
                return Err(ParameterError::NotFinite(field, 0));
            }
            if tau <= T::ZERO {
                return Err(ParameterError::NotPositive(field));
            }
        }
        if tau_max < tau_min {
            return Err(ParameterError::TooLarge(Field::CreepShortest));
        }
        let mut lags = [Lag::new(T::ZERO, sample_time)?; DECADES];
        let mut slots = lags.iter_mut();
        let mut direct = T::ZERO;
        let mut len = 0;
        // A hair above the end, for a range of whole decades.
        let end = tau_max.to_f64() * (1.0 + 1e-6);
        let mut tau = tau_min.to_f64();
        while tau <= end {
            let Some(slot) = slots.next() else {
                return Err(ParameterError::TooLarge(Field::CreepLongest));
            };
            *slot = Lag::new(T::from_f64(tau), sample_time)?;
            direct = direct + slot.direct();
            tau *= 10.0;
            len += 1;
        }
        let direct = T::ONE + gain_per_decade * direct;
        if direct <= T::ZERO {
            return Err(ParameterError::TooSmall(Field::CreepGain));
        }
        Ok(Self {
            len,
            gain: gain_per_decade,
            lags,
            per_direct: T::ONE / direct,
        })
    }

    /// State after a long rest at `input`.
    pub fn start(&self, input: T) -> CreepState<T, DECADES> {
        CreepState {
            first: input,
            lags: [LagState::at_rest(input); DECADES],
        }
    }

    /// Output for the next input.
    #[inline(always)]
    pub fn step(&self, state: &mut CreepState<T, DECADES>, input: T) -> T {
        let mut crept = T::ZERO;
        for (lag, at) in self.lags.iter().zip(&mut state.lags).take(self.len) {
            crept = crept + (lag.step(at, input) - state.first);
        }
        input + self.gain * crept
    }

    /// Input for which [`Creep::step`] yields `output`, from a state that started at the same value.
    #[inline(always)]
    pub fn step_inverse(&self, state: &mut CreepState<T, DECADES>, output: T) -> T {
        let mut held = T::ZERO;
        for (lag, at) in self.lags.iter().zip(&state.lags).take(self.len) {
            held = held + (lag.held(at) - state.first);
        }
        let input = (output - self.gain * held) * self.per_direct;
        for (lag, at) in self.lags.iter().zip(&mut state.lags).take(self.len) {
            lag.step(at, input);
        }
        input
    }
}
