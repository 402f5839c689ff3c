//! The stack form: only the places where the followed front changes.
//!
//! With increasing thresholds and an admissible state, the plays that a sample captures are always
//! the first ones: `z_i + r_i` never falls and `z_i - r_i` never rises with `i`. All of them follow
//! the same front `c`, `z_i = c - r_i` when the lower envelope pushed last and `c + r_i` when the
//! upper one did. So the state is a stack of segments of neighbouring plays, the first plays on top,
//! and with prefix sums of `w_i` and `w_i r_i` a segment adds one product each to the output.
//! What lies below a segment is stored with it, so nothing is accumulated and nothing drifts.
//!
//! The comparisons are those of the plain form on the same rounded numbers.

use super::{Envelope, PlayBank, Sums};
use crate::error::ParameterError;
use crate::math::Real;

/// Neighbouring plays that follow one front: `z_i = front + sign r_i`.
#[derive(Clone, Copy, Debug)]
struct Segment<T> {
    front: T,
    /// -1 behind the lower envelope, +1 behind the upper one, 0 where a start put plays at `front`.
    sign: T,
    /// Index of the segment's last play; its first one follows the last of the segment above it.
    last: usize,
    /// Weighted outputs of all plays beyond `last`.
    below: T,
    /// With this segment on top the bank's output is `constant + weight front`.
    constant: T,
    /// Sum of the weights of the plays `0..=last`.
    weight: T,
    /// Sum of their weights times thresholds.
    moment: T,
    /// Threshold and output of the play beyond `last`, which stays where it is as long as the segment
    /// lives. NaN where there is none: nothing passes it.
    next_r: T,
    next_z: T,
}

impl<T: Real> Segment<T> {
    #[inline(always)]
    fn output(&self, r: T) -> T {
        self.front + self.sign * r
    }

    /// Output of the bank with this segment on top.
    #[inline(always)]
    fn total(&self) -> T {
        self.constant + self.weight * self.front
    }
}

/// Segments of a bank's plays: a sample costs what it changes.
#[derive(Clone, Copy, Debug)]
pub struct StackState<T, const N: usize> {
    /// `segments[..=top]`, the one with the largest thresholds first.
    segments: [Segment<T>; N],
    top: usize,
}

// Indices are always in range; `get` keeps a panic path out of the interrupt.
#[inline(always)]
fn at<T: Real>(values: &[T], index: usize) -> T {
    values.get(index).copied().unwrap_or(T::ZERO)
}

#[inline(always)]
fn sums_at<T: Real>(sums: &[Sums<T>], index: usize) -> Sums<T> {
    sums.get(index).copied().unwrap_or(Sums::ZERO)
}

/// Whether an envelope passes a play of threshold `r` and output `z` and thus captures it: the lower
/// one when `RISING`, else the upper one.
#[inline(always)]
fn passes<const RISING: bool, T: Real>(front: T, r: T, z: T) -> bool {
    if RISING { front - r > z } else { front + r < z }
}

/// Whether a segment of this `sign` follows the lower envelope when `RISING`, else the upper one.
#[inline(always)]
fn follows<const RISING: bool, T: Real>(sign: T) -> bool {
    if RISING {
        sign < T::ZERO
    } else {
        sign > T::ZERO
    }
}

#[inline(always)]
fn sign<const RISING: bool, T: Real>() -> T {
    if RISING { -T::ONE } else { T::ONE }
}

impl<T: Real, const N: usize> StackState<T, N> {
    /// Every play of `bank` at zero.
    pub fn zero(bank: &PlayBank<T, N>) -> Self {
        Self::seed(bank, core::iter::once((bank.len - 1, T::ZERO)))
    }

    /// The plays of `bank` at the outputs `z`.
    ///
    /// # Errors
    /// As [`PlayBank::check_outputs`].
    pub fn new(bank: &PlayBank<T, N>, z: &[T]) -> Result<Self, ParameterError> {
        bank.check_outputs(z)?;
        Ok(Self::seed(bank, z.iter().copied().enumerate().rev()))
    }

    /// Segments of resting plays, from the largest thresholds on: the last play and the output of
    /// each; the first captures merge them.
    fn seed(bank: &PlayBank<T, N>, plays: impl Iterator<Item = (usize, T)>) -> Self {
        let mut lowest = Segment {
            front: T::ZERO,
            sign: T::ZERO,
            last: 0,
            below: T::ZERO,
            constant: T::ZERO,
            weight: T::ZERO,
            moment: T::ZERO,
            next_r: T::NAN,
            next_z: T::NAN,
        };
        let mut state = Self {
            segments: [lowest; N],
            top: 0,
        };
        for (slot, (i, (last, z))) in state.segments.iter_mut().zip(plays.enumerate()) {
            let Sums { weight, moment, .. } = sums_at(&bank.sums, last);
            *slot = Segment {
                front: z,
                last,
                constant: lowest.below,
                weight,
                moment,
                ..lowest
            };
            lowest.below = lowest.below + at(&bank.weights, last) * z;
            (lowest.next_r, lowest.next_z) = (at(&bank.thresholds, last), z);
            state.top = i;
        }
        state
    }

    /// Moves the plays to the envelope of the next sample and returns `sum w_i z_i`.
    #[inline(always)]
    pub fn step(&mut self, bank: &PlayBank<T, N>, envelope: Envelope<T>) -> T {
        self.step_onto(bank, envelope, -T::ZERO)
    }

    /// `direct` plus what [`StackState::step`] returns.
    #[inline(always)]
    pub(super) fn step_onto(
        &mut self,
        bank: &PlayBank<T, N>,
        envelope: Envelope<T>,
        direct: T,
    ) -> T {
        let Some(top) = self.segments.get(self.top) else {
            return direct;
        };
        // An envelope that does not capture the first play captures none, and with `lo <= hi` only
        // one of them can.
        let r = at(&bank.thresholds, 0);
        let z = top.output(r);
        if passes::<true, T>(envelope.lo, r, z) {
            self.capture::<true>(bank, envelope.lo, direct)
        } else if passes::<false, T>(envelope.hi, r, z) {
            self.capture::<false>(bank, envelope.hi, direct)
        } else {
            direct + top.total()
        }
    }

    /// As [`StackState::step_onto`], where it is the exception.
    #[inline(never)]
    pub(super) fn step_apart(
        &mut self,
        bank: &PlayBank<T, N>,
        envelope: Envelope<T>,
        direct: T,
    ) -> T {
        self.step_onto(bank, envelope, direct)
    }

    /// Lets an envelope that passes the first play capture it and all others that it passes.
    #[inline(always)]
    fn capture<const RISING: bool>(&mut self, bank: &PlayBank<T, N>, front: T, direct: T) -> T {
        let mut first = 0;
        // A segment ends when the play beyond it is captured, too.
        while let Some(top) = self.segments.get(self.top)
            && passes::<RISING, T>(front, top.next_r, top.next_z)
        {
            first = top.last + 1;
            self.top = self.top.wrapping_sub(1);
        }
        match self.segments.get_mut(self.top) {
            // In most samples the top segment just moves on.
            Some(top) if follows::<RISING, T>(top.sign) => {
                top.front = front;
                direct + top.total()
            }
            _ => self.turn::<RISING>(bank, front, first, direct),
        }
    }

    /// Lets an envelope capture the `first` play and others of the top segment, which followed another
    /// one, but none beyond.
    #[inline(always)]
    fn turn<const RISING: bool>(
        &mut self,
        bank: &PlayBank<T, N>,
        front: T,
        first: usize,
        direct: T,
    ) -> T {
        let Some(&old) = self.segments.get(self.top) else {
            return direct;
        };
        let captured = |r: T| passes::<RISING, T>(front, r, old.output(r));
        let last = last_captured(&bank.thresholds, first, old.last, captured);
        let mut new = Segment {
            front,
            sign: sign::<RISING, T>(),
            ..old
        };
        if last < old.last {
            let sums = sums_at(&bank.sums, last);
            new.last = last;
            (new.weight, new.moment) = (sums.weight, sums.moment);
            let (weight, moment) = (old.weight - new.weight, old.moment - new.moment);
            new.below = old.below + (old.front * weight + old.sign * moment);
            new.next_r = sums.next_threshold;
            new.next_z = old.output(new.next_r);
            self.top += 1;
        }
        new.constant = new.below + new.sign * new.moment;
        if let Some(top) = self.segments.get_mut(self.top) {
            *top = new;
        }
        direct + new.total()
    }

    /// Output of each play; entries beyond the bank's length are zero.
    pub fn outputs(&self, bank: &PlayBank<T, N>) -> [T; N] {
        let mut z = [T::ZERO; N];
        let mut rows = z.iter_mut().zip(bank.thresholds()).enumerate().peekable();
        for segment in self.segments.iter().take(self.depth()).rev() {
            while let Some((_, (z, &r))) = rows.next_if(|(play, _)| *play <= segment.last) {
                *z = segment.output(r);
            }
        }
        z
    }

    /// Number of segments: the memory that the input's history has left in the plays.
    pub fn depth(&self) -> usize {
        self.top + 1
    }
}

/// The last of the plays `first..=last` that is `captured`: `first` is, and beyond some play none is.
/// In a smooth motion it is near, so the next play is looked at first; then by doubling strides, in a
/// small bank by halving at once.
#[inline(always)]
fn last_captured<T: Real, const N: usize>(
    thresholds: &[T; N],
    first: usize,
    last: usize,
    captured: impl Fn(T) -> bool,
) -> usize {
    const SMALL: usize = 16;
    let (mut low, mut high) = (first, last.min(N - 1));
    let mut stride = 1;
    while low + stride <= high {
        if !captured(at(thresholds, low + stride)) {
            high = low + stride - 1;
            break;
        }
        low += stride;
        stride = if N <= SMALL { N } else { 2 * stride };
    }
    while low < high {
        let middle = high - (high - low) / 2;
        if captured(at(thresholds, middle)) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    low
}
