//! A mechanical mode (`resonance`), one entry a mode.
//!
//! ```text
//! y'' + 2 zeta w_n y' + w_n^2 y = w_n^2 x,     w_n = 2 pi f_n,   0 <= zeta < 1
//! ```
//!
//! The forward step is exact for an input joined by straight lines. With `D = x_k - x_(k-1)` the
//! motion that follows the line is `p(t) = x + D t / h - 2 zeta D / (w_n h)`, and what is left rings
//! freely: `[y - p, h (y' - p')]_k = Phi [y - p, h (y' - p')]_(k-1)`. The inverse is the equation
//! itself, `x = y + (2 zeta / w_n) y' + y'' / w_n^2`, with derivatives from two samples to come.

use crate::error::{Field, ParameterError};
use crate::math::{Real, exp, quarter_turn, sqrt};

use super::derivative::{self, Samples};

/// A mechanical mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Resonance<T> {
    /// 2 zeta / (w_n h)
    behind: T,
    phi: [[T; 2]; 2],
    /// 2 zeta / (12 w_n h)
    first: T,
    /// 1 / (12 w_n^2 h^2)
    second: T,
}

/// State of the forward step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResonanceState<T> {
    input: T,
    output: T,
    /// Sample time times the velocity.
    velocity: T,
}

impl<T: Real> Resonance<T> {
    /// Samples that the inverse looks ahead.
    pub const LATENCY: usize = derivative::LATENCY;

    /// A mode of `f_n` Hz with the damping ratio `zeta`, for samples `sample_time` seconds apart.
    ///
    /// # Errors
    /// A frequency that is not positive or above half the sample rate, a damping ratio outside
    /// `0..1`, a sample time that is not positive.
    pub fn new(f_n: T, zeta: T, sample_time: T) -> Result<Self, ParameterError> {
        super::check_sample_time(sample_time)?;
        if !f_n.is_finite() {
            return Err(ParameterError::NotFinite(Field::NaturalFrequency, 0));
        }
        if f_n <= T::ZERO {
            return Err(ParameterError::NotPositive(Field::NaturalFrequency));
        }
        if !zeta.is_finite() {
            return Err(ParameterError::NotFinite(Field::DampingRatio, 0));
        }
        if zeta < T::ZERO {
            return Err(ParameterError::Negative(Field::DampingRatio));
        }
        if zeta >= T::ONE {
            return Err(ParameterError::TooLarge(Field::DampingRatio));
        }
        let turns = f_n.to_f64() * sample_time.to_f64();
        if turns > 0.5 {
            return Err(ParameterError::TooLarge(Field::NaturalFrequency));
        }
        let zeta = zeta.to_f64();
        // Angle of a sample: undamped, and as the damped mode rings.
        let angle = 2.0 * core::f64::consts::PI * turns;
        let root = sqrt(1.0 - zeta * zeta);
        // Half of it, which is at most a quarter of a turn.
        let (half_sine, half_cosine) = quarter_turn(0.5 * angle * root);
        let sine = 2.0 * half_sine * half_cosine;
        let cosine = 1.0 - 2.0 * half_sine * half_sine;
        let decay = exp(-zeta * angle);
        let (along, across) = (decay * cosine, decay * sine / root);
        let phi = [
            [along + zeta * across, across / angle],
            [-angle * across, along - zeta * across],
        ];
        let behind = 2.0 * zeta / angle;
        Ok(Self {
            behind: T::from_f64(behind),
            phi: phi.map(|row| row.map(T::from_f64)),
            first: T::from_f64(behind / 12.0),
            second: T::from_f64(1.0 / (12.0 * angle * angle)),
        })
    }

    /// State after a long rest at `input`.
    pub fn start(&self, input: T) -> ResonanceState<T> {
        ResonanceState {
            input,
            output: input,
            velocity: T::ZERO,
        }
    }

    /// Output for the next input.
    #[inline(always)]
    pub fn step(&self, state: &mut ResonanceState<T>, input: T) -> T {
        let slope = input - state.input;
        let behind = self.behind * slope;
        let free = state.output - state.input + behind;
        let free_velocity = state.velocity - slope;
        let [[a, b], [c, d]] = self.phi;
        state.output = input - behind + (a * free + b * free_velocity);
        state.velocity = slope + (c * free + d * free_velocity);
        state.input = input;
        state.output
    }

    /// State of the inverse after a long rest at `output`.
    pub fn start_inverse(&self, output: T) -> Samples<T> {
        Samples::at_rest(output)
    }

    /// Input that belongs to the output of [`Resonance::LATENCY`] samples ago.
    #[inline(always)]
    pub fn step_inverse(&self, state: &mut Samples<T>, output: T) -> T {
        let at = state.push(output);
        at.value + (self.first * at.twelve_first + self.second * at.twelve_second)
    }
}
