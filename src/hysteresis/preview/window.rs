//! One window of reference samples: plays forward, steps backward.

use crate::math::{Real, max, min};

use super::{Corrector, PreviewInverse};

/// State of a preview inverse.
#[derive(Clone, Copy, Debug)]
pub struct PreviewState<T, const N: usize, const WINDOW: usize, const STAGES: usize> {
    pub(super) windows: [Window<T, N, WINDOW>; STAGES],
    pub(super) correctors: [Corrector<T, N>; STAGES],
}

/// The samples that a stage looks at, oldest first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window<T, const N: usize, const WINDOW: usize> {
    wanted: [T; WINDOW],
    reference: [T; WINDOW],
    /// `d_k`, the steps of the drive; that of the newest sample is a guess.
    steps: [T; WINDOW],
    /// Outputs of the inverse plays before each sample.
    plays: [[T; N]; WINDOW],
}

impl<T: Real, const N: usize, const WINDOW: usize> Window<T, N, WINDOW> {
    /// A reference at rest, plays at zero.
    pub(super) fn new(reference: T) -> Self {
        Self {
            wanted: [reference; WINDOW],
            reference: [reference; WINDOW],
            steps: [T::ZERO; WINDOW],
            plays: [[T::ZERO; N]; WINDOW],
        }
    }
}

impl<T: Real, const N: usize, const WINDOW: usize, const STAGES: usize>
    PreviewInverse<T, N, WINDOW, STAGES>
{
    /// Takes in one sample; wanted value and reference of the oldest one, and the drive for it.
    pub(super) fn advance(
        &self,
        window: &mut Window<T, N, WINDOW>,
        wanted: T,
        reference: T,
    ) -> ((T, T), T) {
        let Window {
            wanted: wanteds,
            reference: references,
            steps,
            plays,
        } = window;
        let len = self.window;
        push(wanteds, len, wanted);
        push(references, len, reference);
        // The last step is taken to continue.
        let guess = steps.get(len - 1).copied().unwrap_or(T::ZERO);
        push(steps, len, guess);
        // `plays[0]` moved on when the drive of the sample that has just left was emitted.
        for _ in 0..self.sweeps {
            self.follow(references, steps, plays);
            self.sweep(references, steps, plays);
        }
        let oldest = (
            wanteds.first().copied().unwrap_or(T::ZERO),
            references.first().copied().unwrap_or(T::ZERO),
        );
        let mut drive = self.inverse.weight_0() * oldest.1;
        let half_width = self.widening * steps.first().copied().unwrap_or(T::ZERO).abs();
        if let Some(plays) = plays.first_mut() {
            self.push_plays(plays, oldest.1, half_width);
            for (&y, &b) in plays.iter().zip(self.inverse.bank().weights()) {
                drive = drive + b * y;
            }
        }
        (oldest, drive)
    }

    /// Play outputs before each sample, from those before the oldest one.
    fn follow(&self, references: &[T], steps: &[T], plays: &mut [[T; N]]) {
        let mut samples = references.iter().zip(steps).take(self.window);
        let Some((mut before, rest)) = plays.split_first_mut().map(|(p, r)| (*p, r)) else {
            return;
        };
        for to in rest.iter_mut().take(self.window - 1) {
            let Some((&v, &d)) = samples.next() else {
                return;
            };
            self.push_plays(&mut before, v, self.widening * d.abs());
            *to = before;
        }
    }

    #[inline(always)]
    fn push_plays(&self, plays: &mut [T; N], v: T, half_width: T) {
        let (lo, hi) = (v - half_width, v + half_width);
        for (y, &s) in plays.iter_mut().zip(self.inverse.bank().thresholds()) {
            *y = max(min(*y, hi + s), lo - s);
        }
    }

    /// Solves (P 2) for every step, newest first.
    fn sweep(&self, references: &[T], steps: &mut [T], plays: &[[T; N]]) {
        let count = self.window;
        let (Some(references), Some(steps), Some(plays)) = (
            references.get(..count),
            steps.get_mut(..count),
            plays.get(..count),
        ) else {
            return;
        };
        let Some(mut next) = steps.last().copied() else {
            return;
        };
        let pairs = references.windows(2).zip(steps).zip(plays);
        for ((pair, step), plays) in pairs.rev() {
            if let &[v, v_next] = pair {
                *step = self.solve(plays, v, v_next, self.widening * next.abs());
                next = *step;
            }
        }
    }

    /// The step of the drive from reference `v` to `v_next`, where the envelope has `half_width`;
    /// `plays` stand before `v`.
    fn solve(&self, plays: &[T; N], v: T, v_next: T, half_width: T) -> T {
        let p = v_next - v;
        if p < T::ZERO {
            // A falling reference is a rising one seen in a mirror.
            -self.solve_rising(plays, -T::ONE, -v_next, -p, half_width)
        } else {
            self.solve_rising(plays, T::ONE, v_next, p, half_width)
        }
    }

    #[inline(always)]
    fn solve_rising(&self, plays: &[T; N], sign: T, v_next: T, p: T, half_width: T) -> T {
        let direct = self.inverse.weight_0() * p;
        let bank = self.inverse.bank();
        let q = p - half_width;
        let lo = v_next - half_width;
        // Plays that are pushed at the next sample at the latest, and what they then travel.
        let mut pushed = 0;
        let mut travel = T::ZERO;
        let rows = plays.iter().zip(bank.thresholds()).zip(bank.weights());
        for ((&y, &s), &b) in rows {
            let e = lo - s - sign * y;
            if e <= T::ZERO {
                break;
            }
            pushed += 1;
            travel = travel + b * e;
        }
        // (P 3) from no sliding play upward: each takes its travel out of the rest.
        let mut step = direct + travel;
        let rows = plays.iter().zip(bank.thresholds()).zip(bank.weights());
        let sliding = rows.zip(self.sums.iter().zip(&self.gains));
        for (((&y, &s), &b), (&sum, &gain)) in sliding.take(pushed) {
            let e = lo - s - sign * y;
            if q + self.widening * step >= e {
                break;
            }
            travel = travel - b * e;
            step = gain * (direct + sum * q + travel);
        }
        // No play slides through both samples: those with e_i > 0 then need q + b d <= 0.
        if q + self.widening * step <= T::ZERO {
            step = direct;
        }
        // Beyond this step the envelope that closes would push plays back.
        let turned = plays
            .first()
            .zip(bank.thresholds().first())
            .is_some_and(|(&y, &s)| sign * y - s - v_next - half_width > T::ZERO);
        if turned {
            step = min(step, (p + half_width) * self.per_widening);
        }
        step
    }
}

/// Shifts the first `len` entries by one towards the front and puts `newest` behind them.
fn push<T: Copy>(entries: &mut [T], len: usize, newest: T) {
    if let Some(entries) = entries.get_mut(..len) {
        entries.rotate_left(1);
        if let Some(last) = entries.last_mut() {
            *last = newest;
        }
    }
}
