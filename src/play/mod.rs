//! Play operators with envelopes, one or a bank of them.
//!
//! A play of threshold `r` keeps its output until the input pushes it. With a lower and an upper
//! envelope `lo <= hi` of the input its step is
//!
//! ```text
//! z = max(lo - r, min(hi + r, z_previous))
//! ```
//!
//! `lo = hi = u` is the classic play (J 4); the laws that open the envelope are in [`crate::rate`].
//!
//! A [`PlayBank`] holds `n <= N` plays with increasing thresholds and their weights, and yields
//! `sum w_i z_i`. Its state comes in forms that are equal to rounding:
//!
//! - [`PlainState`] stores every `z_i` and touches all of them in each sample;
//! - [`PrefixState`] stores them too, but moves and sums anew only what is captured, for models that
//!   need every `z_i`;
//! - [`StackState`] stores only where the followed front changes, so that a sample costs what it
//!   changes, not what the bank holds.
//!
//! [`PlayState`] is the plain or the stack form, whichever is the faster for the size of the bank.

mod plain;
mod prefix;
mod stack;

pub use plain::PlainState;
pub use prefix::PrefixState;
pub use stack::StackState;

use crate::error::{Field, ParameterError};
use crate::math::{Real, max, min};

/// Lower and upper envelope of an input sample, `lo <= hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Envelope<T> {
    /// What pushes plays up.
    pub lo: T,
    /// What pushes plays down.
    pub hi: T,
}

impl<T: Real> Envelope<T> {
    /// The closed envelope of a rate-independent play.
    #[inline(always)]
    pub fn closed(input: T) -> Self {
        Self {
            lo: input,
            hi: input,
        }
    }
}

/// One step of a single play of threshold `r >= 0` from its previous output `z` (J 4).
///
/// ```
/// use hysteron::play::{Envelope, play};
///
/// let z = play(0.0, Envelope::closed(5.0), 2.0);
/// assert_eq!(z, 3.0); // pushed up: the input less the threshold
/// assert_eq!(play(z, Envelope::closed(2.0), 2.0), 3.0); // within the gap: remembered
/// ```
#[inline(always)]
pub fn play<T: Real>(z: T, envelope: Envelope<T>, r: T) -> T {
    max(min(z, envelope.hi + r), envelope.lo - r)
}

/// Number of plays from which [`PlayState`] takes the stack form.
///
/// One number for host and target: the forms are equal to rounding only, and the two must agree bit
/// for bit. From 8 plays on the stack is the faster in the mean of a smooth input, on the host and, by
/// instructions, on a Cortex-M4F, there for white noise, too. A sample that merges a segment for each
/// play costs up to 1.5 times what the plain form does. Below 8, constant time is worth more than a
/// lower mean. Figures: `docs/performance.md`.
pub const STACK_FROM: usize = 8;

/// Thresholds and weights of up to `N` plays: `sum w_i z_i` for an envelope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlayBank<T, const N: usize> {
    len: usize,
    /// Infinite beyond `len`, so that nothing moves a play that is not there.
    thresholds: [T; N],
    /// Zero beyond `len`.
    weights: [T; N],
    /// `sums[i]` is over the plays `0..=i`.
    sums: [Sums<T>; N],
}

/// Sums over the first plays of a bank.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sums<T> {
    /// Of the weights.
    weight: T,
    /// Of each weight times its threshold.
    moment: T,
    /// The threshold of the play that follows them, infinite when none does: wanted where the sums are.
    next_threshold: T,
}

impl<T: Real> Sums<T> {
    const ZERO: Self = Self {
        weight: T::ZERO,
        moment: T::ZERO,
        next_threshold: T::INFINITY,
    };
}

impl<T: Real, const N: usize> PlayBank<T, N> {
    /// A bank of `thresholds.len()` plays, `1..=N`.
    ///
    /// # Errors
    /// Names the field: no play or more than `N`, unequal lengths, thresholds that are not positive
    /// and strictly increasing, entries or sums that are not finite. Weights may have any sign: an
    /// inverse has negative ones.
    pub fn new(thresholds: &[T], weights: &[T]) -> Result<Self, ParameterError> {
        const { assert!(N > 0, "a bank needs room for one play") };
        let len = thresholds.len();
        if len == 0 || len > N {
            return Err(ParameterError::Length(Field::Thresholds));
        }
        if weights.len() != len {
            return Err(ParameterError::Length(Field::Weights));
        }
        let mut bank = Self {
            len,
            thresholds: [T::INFINITY; N],
            weights: [T::ZERO; N],
            sums: [Sums::ZERO; N],
        };
        let (mut before, mut sum) = (T::ZERO, Sums::<T>::ZERO);
        let rows = bank.thresholds.iter_mut().zip(&mut bank.weights);
        for (i, (((r, w), to), (&threshold, &weight))) in rows
            .zip(&mut bank.sums)
            .zip(thresholds.iter().zip(weights))
            .enumerate()
        {
            if !threshold.is_finite() {
                return Err(ParameterError::NotFinite(Field::Thresholds, i));
            }
            if threshold <= before {
                return Err(ParameterError::NotIncreasing(Field::Thresholds, i));
            }
            before = threshold;
            sum.weight = sum.weight + weight;
            sum.moment = sum.moment + weight * threshold;
            if !(sum.weight.is_finite() && sum.moment.is_finite()) {
                return Err(ParameterError::NotFinite(Field::Weights, i));
            }
            sum.next_threshold = thresholds.get(i + 1).copied().unwrap_or(T::INFINITY);
            (*r, *w, *to) = (threshold, weight, sum);
        }
        Ok(bank)
    }

    /// Number of plays, at least one.
    #[allow(clippy::len_without_is_empty, reason = "a bank is never empty")]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Thresholds, increasing, in the unit of the input.
    pub fn thresholds(&self) -> &[T] {
        self.thresholds.get(..self.len).unwrap_or(&[])
    }

    /// Thresholds, infinite beyond the bank's length: a loop over all of them ends at the first play
    /// that is not captured, whatever the length.
    #[inline(always)]
    pub(crate) fn padded_thresholds(&self) -> &[T; N] {
        &self.thresholds
    }

    /// Weights, output unit over input unit.
    pub fn weights(&self) -> &[T] {
        self.weights.get(..self.len).unwrap_or(&[])
    }

    /// State with every play at zero, in the form that suits the size of the bank.
    ///
    /// The first step takes it to the nearest admissible state of its envelope.
    pub fn start(&self) -> PlayState<T, N> {
        if N < STACK_FROM || self.len < STACK_FROM {
            PlayState::Plain(PlainState::zero())
        } else {
            PlayState::Stack(StackState::zero(self))
        }
    }

    /// State from the play outputs `z`, one a play, in the form that suits the size of the bank.
    ///
    /// # Errors
    /// As [`PlayBank::check_outputs`].
    pub fn start_from(&self, z: &[T]) -> Result<PlayState<T, N>, ParameterError> {
        Ok(if N < STACK_FROM || self.len < STACK_FROM {
            PlayState::Plain(PlainState::new(self, z)?)
        } else {
            PlayState::Stack(StackState::new(self, z)?)
        })
    }

    /// Whether `z` can be the outputs of this bank's plays at any input (J 8):
    /// `|z_(i+1) - z_i| <= r_(i+1) - r_i`, to rounding.
    ///
    /// # Errors
    /// The wrong number of outputs, one that is not finite, or the first inadmissible one.
    pub fn check_outputs(&self, z: &[T]) -> Result<(), ParameterError> {
        if z.len() != self.len {
            return Err(ParameterError::Length(Field::InitialState));
        }
        let mut before: Option<(T, T)> = None;
        for (i, (&z, &r)) in z.iter().zip(self.thresholds()).enumerate() {
            if !z.is_finite() {
                return Err(ParameterError::NotFinite(Field::InitialState, i));
            }
            if let Some((z_before, r_before)) = before {
                let slack = (z.abs() + z_before.abs() + r) * T::from_f64(8.0) * T::EPSILON;
                if (z - z_before).abs() > r - r_before + slack {
                    return Err(ParameterError::Inadmissible(i));
                }
            }
            before = Some((z, r));
        }
        Ok(())
    }
}

/// State of a bank in the form that suits its size; see [`PlayBank::start`].
#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub enum PlayState<T, const N: usize> {
    /// Every output stored.
    Plain(PlainState<T, N>),
    /// Only changes of the followed front stored.
    Stack(StackState<T, N>),
}

impl<T: Real, const N: usize> PlayState<T, N> {
    /// Moves the plays to the envelope of the next sample and returns `sum w_i z_i`.
    ///
    /// `bank` is the one that the state was started from; the envelope is finite.
    #[inline(always)]
    pub fn step(&mut self, bank: &PlayBank<T, N>, envelope: Envelope<T>) -> T {
        self.step_onto(bank, envelope, -T::ZERO)
    }

    /// `direct` plus what [`PlayState::step`] returns.
    #[inline(always)]
    pub(crate) fn step_onto(
        &mut self,
        bank: &PlayBank<T, N>,
        envelope: Envelope<T>,
        direct: T,
    ) -> T {
        match self {
            Self::Plain(state) => state.step_onto(bank, envelope, direct),
            Self::Stack(state) if N < STACK_FROM => state.step_apart(bank, envelope, direct),
            Self::Stack(state) => state.step_onto(bank, envelope, direct),
        }
    }

    /// Output of each play; entries beyond the bank's length are zero.
    pub fn outputs(&self, bank: &PlayBank<T, N>) -> [T; N] {
        match self {
            Self::Plain(state) => state.outputs(),
            Self::Stack(state) => state.outputs(bank),
        }
    }
}
