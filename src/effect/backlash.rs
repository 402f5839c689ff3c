//! Backlash behind the hysteresis (`backlash`): a play of the joint that `w` moves.
//!
//! ```text
//! y_k = max(w_k - W/2, min(w_k + W/2, y_(k-1)))
//! ```
//!
//! `W >= 0` is the whole width of the gap, in the unit of `w`: the output stays within `w +/- W/2` and
//! rests while `w` crosses the gap. It starts in the middle.
//!
//! The inverse adds the half width on the side that the output moves to, and so leaps by `W` where it
//! turns (G. Tao, P. V. Kokotovic, *Adaptive control of systems with backlash*, Automatica 29(2),
//! 1993). So that rounding is no turn, it waits there until the output has come back by [`TURN`] of
//! the width; that is its error.

use crate::error::{Field, ParameterError};
use crate::math::{Real, max, min};

/// How far the output has to come back for a turn, as a share of the width.
pub const TURN: f64 = 1.0 / 256.0;

/// A gap of one width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Backlash<T> {
    half: T,
    turn: T,
}

/// The output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BacklashState<T>(T);

/// State of the inverse: the output that it follows, and the input beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BacklashInverse<T> {
    output: T,
    side: T,
}

impl<T: Real> Backlash<T> {
    /// A gap that is `width` wide.
    ///
    /// # Errors
    /// A width that is negative or not finite.
    pub fn new(width: T) -> Result<Self, ParameterError> {
        if !width.is_finite() {
            return Err(ParameterError::NotFinite(Field::Width, 0));
        }
        if width < T::ZERO {
            return Err(ParameterError::Negative(Field::Width));
        }
        Ok(Self {
            half: T::from_f64(0.5) * width,
            turn: T::from_f64(TURN) * width,
        })
    }

    /// State in the middle of the gap.
    pub fn start(&self, w: T) -> BacklashState<T> {
        BacklashState(w)
    }

    /// Output for the next input.
    #[inline(always)]
    pub fn step(&self, state: &mut BacklashState<T>, w: T) -> T {
        state.0 = max(min(state.0, w + self.half), w - self.half);
        state.0
    }

    /// State of the inverse in the middle of the gap.
    pub fn start_inverse(&self, output: T) -> BacklashInverse<T> {
        BacklashInverse {
            output,
            side: T::ZERO,
        }
    }

    /// Input for which [`Backlash::step`] yields `output`, or, at a turn, the output where it turned.
    #[inline(always)]
    pub fn step_inverse(&self, state: &mut BacklashInverse<T>, output: T) -> T {
        let moved = output - state.output;
        let rises = moved > self.turn || (moved > T::ZERO && state.side > T::ZERO);
        let falls = moved < -self.turn || (moved < T::ZERO && state.side < T::ZERO);
        if rises {
            *state = BacklashInverse {
                output,
                side: self.half,
            };
        } else if falls {
            *state = BacklashInverse {
                output,
                side: -self.half,
            };
        }
        state.output + state.side
    }
}
