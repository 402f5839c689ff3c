//! Rate-dependent Prandtl-Ishlinskii (RDPI) model and its analytic inverse.
//!
//! ```text
//! v = a_0 u + sum a_i z_i,   z_i = max(u - r_i, min(u + r_i, z_i_previous))   (J 38, 37)
//! r_i = alpha_i + beta |u'|,  u'(k) = (u(k) - u(k-1)) / h                     (J 36, 34)
//! ```
//!
//! The inverse is an operator of the same kind. With the partial sums `A_i = a_0 + ... + a_i`:
//!
//! ```text
//! b_0 = 1 / a_0,     b_i = 1 / A_i - 1 / A_(i-1)                              (J 15)
//! s_1 = a_0 r_1,     s_(i+1) - s_i = A_i (r_(i+1) - r_i)                      (J 14)
//! y_1 = a_0 x_1,     y_(i+1) - y_i = A_i (x_(i+1) - x_i)                      (J 16, corrected)
//! ```
//!
//! where `x_i = u(0) - z_i(0)` and `y_i = v(0) - d_i(0)` are the distances of the plays from the
//! input at the start. (J 16) prints `y_1 = a_1 x_1`, which does not invert the model; (J 18) has it
//! right for n = 1. A common `beta` shifts all `s_i` by `a_0 beta |u'|`.
//!
//! The inversion is exact when every `A_i` is positive and the distances between thresholds never
//! shrink in time (J 11), and when model and inverse see the same rate. An actuator widens its
//! thresholds with the rate of its own input instead, of which a compensator only knows the
//! reference; the remaining error is that difference.

use crate::error::{Field, ParameterError};
use crate::math::Real;
use crate::play::{Envelope, PlayBank, PlayState};
use crate::rate::RateLaw;

/// Parameters of the model as they are identified and stored, to be validated by
/// [`Parameters::build`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters<'a, T> {
    /// `a_0..a_n`, output unit over input unit: `n + 1` entries, `a_0` belonging to the input itself.
    pub weights: &'a [T],
    /// `alpha_1..alpha_n`, input unit, positive and increasing: `n >= 1` entries.
    pub thresholds: &'a [T],
    /// Rate coefficient in seconds; zero gives the rate-independent Prandtl-Ishlinskii model.
    pub beta: T,
}

impl<T: Real> Parameters<'_, T> {
    /// A model for samples that are `sample_time` seconds apart.
    ///
    /// # Errors
    /// Names what is wrong: non-finite entries, unequal lengths or more than `N` plays, thresholds
    /// that do not increase, a partial sum `A_i <= 0`, a negative `beta`, a sample time that is not
    /// positive.
    pub fn build<const N: usize>(
        &self,
        sample_time: T,
    ) -> Result<RateDependentPi<T, N>, ParameterError> {
        if !sample_time.is_finite() {
            return Err(ParameterError::NotFinite(Field::SampleTime, 0));
        }
        if sample_time <= T::ZERO {
            return Err(ParameterError::NotPositive(Field::SampleTime));
        }
        if !(self.beta.is_finite() && (self.beta / sample_time).is_finite()) {
            return Err(ParameterError::NotFinite(Field::Beta, 0));
        }
        if self.beta < T::ZERO {
            return Err(ParameterError::ShrinkingGap(Field::Beta));
        }
        let mut partial_sum = T::ZERO;
        for (i, &weight) in self.weights.iter().enumerate() {
            partial_sum = partial_sum + weight;
            if !(partial_sum.is_finite() && (T::ONE / partial_sum).is_finite()) {
                return Err(if partial_sum == T::ZERO {
                    ParameterError::PartialSum(Field::Weights, i)
                } else {
                    ParameterError::NotFinite(Field::Weights, i)
                });
            }
            if partial_sum <= T::ZERO {
                return Err(ParameterError::PartialSum(Field::Weights, i));
            }
        }
        let Some((&weight_0, weights)) = self.weights.split_first() else {
            return Err(ParameterError::Length(Field::Weights));
        };
        Ok(RateDependentPi {
            weight_0,
            bank: PlayBank::new(self.thresholds, weights)?,
            rate: RateLaw::new(self.beta, sample_time),
            sample_time,
        })
    }
}

/// A rate-dependent Prandtl-Ishlinskii operator of up to `N` plays; its inverse is one, too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateDependentPi<T, const N: usize> {
    weight_0: T,
    bank: PlayBank<T, N>,
    rate: RateLaw<T>,
    sample_time: T,
}

/// Where the plays stand, and the previous input.
#[derive(Clone, Copy, Debug)]
pub struct State<T, const N: usize> {
    plays: PlayState<T, N>,
    previous: T,
}

impl<T, const N: usize> State<T, N> {
    /// A state of the given form of the bank, for a first input to come.
    pub fn new(plays: PlayState<T, N>, first: T) -> Self {
        Self {
            plays,
            previous: first,
        }
    }

    /// Takes the input as if it had stood at `input` before: the rate of a next sample there is zero.
    #[inline(always)]
    pub fn rest_at(&mut self, input: T) {
        self.previous = input;
    }

    /// The plays.
    pub fn plays(&self) -> &PlayState<T, N> {
        &self.plays
    }
}

impl<T: Real, const N: usize> State<T, N> {
    /// The input before.
    #[inline(always)]
    pub fn previous(&self) -> T {
        self.previous
    }
}

impl<T: Real, const N: usize> RateDependentPi<T, N> {
    /// State before the first input `first`: plays at zero, from where the first step takes them to
    /// the nearest admissible state; the rate at that step is zero.
    pub fn start(&self, first: T) -> State<T, N> {
        State::new(self.bank.start(), first)
    }

    /// State before the first input `first` with the play outputs `z`, one a play, input unit.
    ///
    /// # Errors
    /// Outputs that no input can have led to (J 8).
    pub fn start_from(&self, first: T, z: &[T]) -> Result<State<T, N>, ParameterError> {
        Ok(State::new(self.bank.start_from(z)?, first))
    }

    /// Output for the next input; its rate is the backward difference (J 34).
    ///
    /// Trusts a finite input: the entry of a [`crate::compensator::Compensator`] checks it.
    #[inline(always)]
    pub fn step(&self, state: &mut State<T, N>, input: T) -> T {
        let envelope = self.rate.from_samples(input, state.previous);
        state.previous = input;
        let direct = self.weight_0 * input;
        state.plays.step_onto(&self.bank, envelope, direct)
    }

    /// Output for the next input at a `rate` known from elsewhere, in input units a second; its
    /// sign does not matter.
    #[inline(always)]
    pub fn step_with_rate(&self, state: &mut State<T, N>, input: T, rate: T) -> T {
        let envelope = self.rate.from_rate(input, rate);
        state.previous = input;
        let direct = self.weight_0 * input;
        state.plays.step_onto(&self.bank, envelope, direct)
    }

    /// The envelope of the next input, before it is stepped to, at the rate of the backward difference or
    /// one known from elsewhere.
    #[inline(always)]
    pub fn envelope(&self, state: &State<T, N>, input: T, rate: Option<T>) -> Envelope<T> {
        match rate {
            Some(rate) => self.rate.from_rate(input, rate),
            None => self.rate.from_samples(input, state.previous),
        }
    }

    /// The analytic inverse (J 12, 14, 15), an operator of the same kind.
    ///
    /// # Errors
    /// An inverse threshold or weight that leaves the range of `T`.
    pub fn inverse(&self) -> Result<Self, ParameterError> {
        let mut weights = [T::ZERO; N];
        let mut thresholds = [T::ZERO; N];
        let mut partial_sum = self.weight_0;
        let (mut r_before, mut s_before) = (T::ZERO, T::ZERO);
        let rows = self.bank.thresholds().iter().zip(self.bank.weights());
        for ((b, s), (&r, &a)) in weights.iter_mut().zip(&mut thresholds).zip(rows) {
            *s = s_before + partial_sum * (r - r_before);
            (r_before, s_before) = (r, *s);
            let next = partial_sum + a;
            // 1/A_i - 1/A_(i-1) without the cancellation of two near numbers.
            *b = -a / (next * partial_sum);
            partial_sum = next;
        }
        let len = self.bank.len();
        let (thresholds, weights) = (
            thresholds.get(..len).unwrap_or(&[]),
            weights.get(..len).unwrap_or(&[]),
        );
        Ok(Self {
            weight_0: T::ONE / self.weight_0,
            bank: PlayBank::new(thresholds, weights)?,
            rate: RateLaw::new(self.weight_0 * self.rate.beta(), self.sample_time),
            sample_time: self.sample_time,
        })
    }

    /// What the inverse starts from when this operator starts at `input` with the play outputs `z`:
    /// the output there, and the play outputs of the inverse (J 16, corrected; see the module).
    ///
    /// # Errors
    /// Outputs `z` that no input can have led to (J 8).
    pub fn inverse_start(&self, input: T, z: &[T]) -> Result<(T, [T; N]), ParameterError> {
        self.bank.check_outputs(z)?;
        let weighted = z
            .iter()
            .zip(self.bank.weights())
            .fold(T::ZERO, |sum, (&z, &a)| sum + a * z);
        let output = self.weight_0 * input + weighted;
        let mut inverse_outputs = [T::ZERO; N];
        let mut partial_sum = self.weight_0;
        let (mut x_before, mut y) = (T::ZERO, T::ZERO);
        for (d, (&z, &a)) in inverse_outputs
            .iter_mut()
            .zip(z.iter().zip(self.bank.weights()))
        {
            let x = input - z;
            y = y + partial_sum * (x - x_before);
            x_before = x;
            partial_sum = partial_sum + a;
            *d = output - y;
        }
        Ok((output, inverse_outputs))
    }

    /// The same operator without its rate term, beta = 0.
    pub fn rate_independent(&self) -> Self {
        Self {
            rate: RateLaw::new(T::ZERO, self.sample_time),
            ..*self
        }
    }

    /// `a_0`, the weight of the input itself.
    pub fn weight_0(&self) -> T {
        self.weight_0
    }

    /// The plays with their thresholds and weights.
    pub fn bank(&self) -> &PlayBank<T, N> {
        &self.bank
    }

    /// The rate coefficient in seconds.
    pub fn beta(&self) -> T {
        self.rate.beta()
    }

    /// Time between two samples in seconds.
    pub fn sample_time(&self) -> T {
        self.sample_time
    }
}
