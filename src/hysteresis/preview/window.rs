//! The window of reference samples: where plays rest, and the steps of the drive.

use crate::math::{Real, max, min};

use super::PreviewInverse;
use super::aim::Plant;
use super::solve::{Pushed, Sample};

/// State of a preview inverse.
#[derive(Clone, Copy, Debug)]
pub struct PreviewState<T, const N: usize, const WINDOW: usize> {
    pub(super) window: Window<T, N, WINDOW>,
    pub(super) plant: Plant<T, N>,
}

impl<T: Real, const N: usize, const WINDOW: usize> PreviewState<T, N, WINDOW> {
    /// Outputs of the inverse plays at the latest drive.
    pub fn plays(&mut self) -> &mut [T; N] {
        self.window.oldest().1
    }
}

/// What a preview inverse knows of the samples ahead.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window<T, const N: usize, const WINDOW: usize> {
    /// Oldest first.
    entries: [Entry<T>; WINDOW],
    /// Where the inverse plays came to rest; the first row stands before the oldest sample.
    rows: [[T; N]; WINDOW],
    /// The step before the oldest sample.
    step_before: T,
}

/// One sample of the window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry<T> {
    pub(super) reference: T,
    /// Rise of the reference to the next sample; zero for the newest.
    p: T,
    /// `d_k`, the step of the drive to the next sample; a guess for the newest.
    pub(super) step: T,
    /// `c_k`, what the plant sees more than `|d_k|`.
    lag: T,
    /// The row where the plays rest.
    row: usize,
}

/// A front since it last left plays behind.
#[derive(Clone, Copy)]
struct Front<T> {
    furthest: T,
    last: T,
}

impl<T: Real> Entry<T> {
    fn at_rest(reference: T) -> Self {
        Self {
            reference,
            p: T::ZERO,
            step: T::ZERO,
            lag: T::ZERO,
            row: 0,
        }
    }
}

impl<T: Real, const N: usize, const WINDOW: usize> Window<T, N, WINDOW> {
    /// A reference at rest.
    pub(super) fn new(reference: T, plays: [T; N]) -> Self {
        Self {
            entries: [Entry::at_rest(reference); WINDOW],
            rows: [plays; WINDOW],
            step_before: T::ZERO,
        }
    }

    /// A reference at rest, plays where they stand.
    pub(super) fn rest_at(&mut self, reference: T) {
        self.step_before = T::ZERO;
        for entry in &mut self.entries {
            *entry = Entry::at_rest(reference);
        }
    }

    /// The oldest sample, and the inverse plays before it.
    pub(super) fn oldest(&mut self) -> (Entry<T>, &mut [T; N]) {
        const { assert!(WINDOW > 1, "no room for a window") };
        (self.entries[0], &mut self.rows[0])
    }

    /// Takes in the newest of `len` reference samples; the oldest one leaves.
    fn shift(&mut self, len: usize, reference: T) {
        self.step_before = self.entries[0].step;
        let Some(entries) = self.entries.get_mut(..len) else {
            return;
        };
        // The compiler then knows that the copy cannot fail.
        if entries.is_empty() {
            return;
        }
        entries.copy_within(1.., 0);
        if let [.., before, newest] = entries {
            before.p = reference - before.reference;
            // The last step is taken to continue.
            *newest = Entry {
                reference,
                p: T::ZERO,
                lag: T::ZERO,
                ..*before
            };
        }
    }
}

impl<T: Real, const N: usize, const WINDOW: usize> PreviewInverse<T, N, WINDOW> {
    /// Takes in a reference sample and goes through the window with it.
    pub(super) fn advance(&self, window: &mut Window<T, N, WINDOW>, reference: T) {
        window.shift(self.window, reference);
        for _ in 0..self.sweeps {
            if self.share > T::ZERO {
                self.lag(window);
            }
            self.follow(window);
            self.sweep(window);
        }
    }

    /// Half width of the envelope at a sample.
    #[inline(always)]
    pub(super) fn half_width(&self, entry: &Entry<T>) -> T {
        self.widening * max(entry.step.abs() + entry.lag, T::ZERO)
    }

    /// `c_k` (P 6) from the steps of the sweep before.
    fn lag(&self, window: &mut Window<T, N, WINDOW>) {
        let mut step_before = window.step_before;
        let mut waiting: Option<(&mut Entry<T>, T)> = None;
        for entry in window.entries.iter_mut().take(self.window) {
            let fall = match waiting.take() {
                Some((last, fall)) => {
                    let next = last.step.abs() - entry.step.abs();
                    last.lag = self.share * limited(step_before, last.step, fall, next);
                    step_before = last.step;
                    next
                }
                None => step_before.abs() - entry.step.abs(),
            };
            waiting = Some((entry, fall));
        }
        if let Some((last, fall)) = waiting {
            last.lag = self.share * limited(step_before, last.step, fall, fall);
        }
    }

    /// Where the plays rest before each sample, with the steps of the sweep before.
    ///
    /// A play that slides is left where it was until its front turns back: (P 3) then does not hang
    /// on where those steps put it.
    fn follow(&self, window: &mut Window<T, N, WINDOW>) {
        let mut row = 0;
        let [mut lo, mut hi] = [-T::INFINITY, T::INFINITY].map(|far| Front {
            furthest: far,
            last: far,
        });
        let rows = &mut window.rows;
        for entry in window.entries.iter_mut().take(self.window - 1) {
            let rising = entry.p >= T::ZERO;
            if rising || hi.last > hi.furthest {
                row = self.rest(rows, row, -T::ONE, hi.furthest);
                hi.furthest = T::INFINITY;
            }
            if !rising || lo.last < lo.furthest {
                row = self.rest(rows, row, T::ONE, lo.furthest);
                lo.furthest = -T::INFINITY;
            }
            entry.row = row;
            let half_width = self.half_width(entry);
            lo.last = entry.reference - half_width;
            hi.last = entry.reference + half_width;
            lo.furthest = max(lo.furthest, lo.last);
            hi.furthest = min(hi.furthest, hi.last);
        }
    }

    /// Pushes the plays of a row up (`sign` 1) or down (-1) by a front, into a row of their own.
    #[inline(always)]
    fn rest(&self, rows: &mut [[T; N]; WINDOW], row: usize, sign: T, front: T) -> usize {
        let thresholds = self.inverse.bank().thresholds();
        let ahead = |y: T, s: T| sign * (front - y) > s;
        let Some(plays) = rows.get(row) else {
            return row;
        };
        let first = plays.first().zip(thresholds.first());
        if !first.is_some_and(|(&y, &s)| ahead(y, s)) {
            return row;
        }
        let mut plays = *plays;
        for (y, &s) in plays.iter_mut().zip(thresholds) {
            if !ahead(*y, s) {
                break;
            }
            *y = front - sign * s;
        }
        // Both fronts can only push at one sample if one play is between them, so there are rows
        // enough; should rounding say otherwise, the last one is used again.
        let next = if row + 1 < WINDOW { row + 1 } else { row };
        if let Some(to) = rows.get_mut(next) {
            *to = plays;
        }
        next
    }

    /// Solves (P 2) for every step, newest first.
    fn sweep(&self, window: &mut Window<T, N, WINDOW>) {
        let rows = &window.rows;
        let entries = window.entries.get_mut(..self.window);
        let Some((newest, entries)) = entries.and_then(|entries| entries.split_last_mut()) else {
            return;
        };
        let mut v_next = newest.reference;
        let mut next_width = self.half_width(newest);
        let mut pushed = Pushed::default();
        for entry in entries.iter_mut().rev() {
            if let Some(plays) = rows.get(entry.row) {
                let sample = Sample {
                    plays,
                    v_next,
                    p: entry.p,
                    wider: self.widening * entry.lag,
                    next_width,
                };
                entry.step = self.solve(&sample, &mut pushed);
            }
            v_next = entry.reference;
            next_width = self.half_width(entry);
        }
    }
}

/// The fall of `|d|` to a step and the one to the next, whichever is smaller; none where they
/// disagree. At a turning point the narrower envelope counts, for it is the one that pushes.
#[inline(always)]
fn limited<T: Real>(step_before: T, step: T, fall: T, next: T) -> T {
    if step_before * step < T::ZERO {
        min(fall, T::ZERO)
    } else if fall * next <= T::ZERO {
        T::ZERO
    } else if fall.abs() < next.abs() {
        fall
    } else {
        next
    }
}
