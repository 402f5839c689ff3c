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

use super::{Envelope, PlayBank};
use crate::error::ParameterError;
use crate::math::Real;

/// Neighbouring plays that follow one front: `z_i = front + sign r_i`.
#[derive(Clone, Copy, Debug)]
struct Segment<T> {
    front: T,
    /// -1 behind the lower envelope, +1 behind the upper one, 0 where a start put plays at `front`.
    sign: T,
    /// Weighted outputs of all plays beyond `last`.
    below: T,
    /// Index of the segment's last play; its first one follows the last of the segment above it.
    last: usize,
}

impl<T: Real> Segment<T> {
    #[inline(always)]
    fn output(&self, r: T) -> T {
        self.front + self.sign * r
    }
}

/// Segments of a bank's plays: a sample costs what it changes.
#[derive(Clone, Copy, Debug)]
pub struct StackState<T, const N: usize> {
    /// `segments[..depth]`, the one with the largest thresholds first.
    segments: [Segment<T>; N],
    depth: usize,
}

#[inline(always)]
fn at<T: Real>(values: &[T], index: usize) -> T {
    // Always in range; `get` keeps a panic path out of the interrupt.
    values.get(index).copied().unwrap_or(T::ZERO)
}

impl<T: Real, const N: usize> StackState<T, N> {
    fn empty() -> Self {
        let nothing = Segment {
            front: T::ZERO,
            sign: T::ONE,
            below: T::ZERO,
            last: 0,
        };
        Self {
            segments: [nothing; N],
            depth: 0,
        }
    }

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
    fn seed(bank: &PlayBank<T, N>, segments: impl Iterator<Item = (usize, T)>) -> Self {
        let mut state = Self::empty();
        let mut below = T::ZERO;
        for (slot, (last, z)) in state.segments.iter_mut().zip(segments) {
            *slot = Segment {
                front: z,
                sign: T::ZERO,
                below,
                last,
            };
            below = below + at(&bank.weights, last) * z;
            state.depth += 1;
        }
        state
    }

    /// Moves the plays to the envelope of the next sample and returns `sum w_i z_i`.
    #[inline(always)]
    pub fn step(&mut self, bank: &PlayBank<T, N>, envelope: Envelope<T>) -> T {
        let Some(top) = self.top() else {
            return T::ZERO;
        };
        // An envelope that does not capture the first play captures none, and with `lo <= hi` only
        // one of them can.
        let r = at(&bank.thresholds, 0);
        let z = top.output(r);
        if envelope.lo - r > z {
            self.capture::<true>(bank, envelope.lo);
        } else if envelope.hi + r < z {
            self.capture::<false>(bank, envelope.hi);
        }
        self.top().map_or(T::ZERO, |top| {
            top.below
                + (top.front * at(&bank.weight_sums, top.last)
                    + top.sign * at(&bank.moment_sums, top.last))
        })
    }

    #[inline(always)]
    fn top(&self) -> Option<&Segment<T>> {
        self.segments.get(self.depth.wrapping_sub(1))
    }

    /// Lets an envelope capture the first play and all others that it passes: the lower envelope
    /// when `RISING`, else the upper one.
    #[inline(always)]
    fn capture<const RISING: bool>(&mut self, bank: &PlayBank<T, N>, front: T) {
        let passes = |segment: &Segment<T>, play: usize| {
            let r = at(&bank.thresholds, play);
            let z = segment.output(r);
            if RISING { front - r > z } else { front + r < z }
        };
        let mut depth = self.depth;
        let mut captured = 1;
        let mut below = T::ZERO;
        while let Some(segment) = self.segments.get(depth.wrapping_sub(1)) {
            if passes(segment, segment.last) {
                captured = segment.last + 1;
                depth -= 1;
                continue;
            }
            captured = first_not(captured, segment.last, |play| passes(segment, play));
            let before = captured - 1;
            let weight = at(&bank.weight_sums, segment.last) - at(&bank.weight_sums, before);
            let moment = at(&bank.moment_sums, segment.last) - at(&bank.moment_sums, before);
            below = segment.below + (segment.front * weight + segment.sign * moment);
            break;
        }
        if let Some(slot) = self.segments.get_mut(depth) {
            *slot = Segment {
                front,
                sign: if RISING { -T::ONE } else { T::ONE },
                below,
                last: captured - 1,
            };
            self.depth = depth + 1;
        }
    }

    /// Output of each play; entries beyond the bank's length are zero.
    pub fn outputs(&self, bank: &PlayBank<T, N>) -> [T; N] {
        let mut z = [T::ZERO; N];
        let mut rows = z.iter_mut().zip(bank.thresholds()).enumerate().peekable();
        for segment in self.segments.iter().take(self.depth).rev() {
            while let Some((_, (z, &r))) = rows.next_if(|(play, _)| *play <= segment.last) {
                *z = segment.output(r);
            }
        }
        z
    }

    /// Number of segments: the memory that the input's history has left in the plays.
    pub fn depth(&self) -> usize {
        self.depth
    }
}

/// The first index in `from..last` that `holds` is false for, or `last`, where it is known to be;
/// `holds` is true up to some index and false from there on. Doubling strides first: in a smooth
/// motion the answer is near.
#[inline(always)]
fn first_not(from: usize, last: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high, mut stride) = (from, last, 1);
    while low < high {
        let probe = low + (stride - 1);
        if probe >= high {
            break;
        }
        if holds(probe) {
            low = probe + 1;
            stride *= 2;
        } else {
            high = probe;
        }
    }
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}
