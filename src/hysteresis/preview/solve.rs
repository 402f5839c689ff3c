//! The equation of one step of the drive.

use crate::math::Real;

use super::PreviewInverse;

/// What (P 1) is about at one sample.
pub(super) struct Sample<'a, T, const N: usize> {
    /// Outputs of the inverse plays where they last came to rest.
    pub(super) plays: &'a [T; N],
    /// The reference at the next sample, and its rise to there.
    pub(super) v_next: T,
    pub(super) p: T,
    /// `b c_k`: what the envelope at `v` is wider than `b |d|`.
    pub(super) wider: T,
    /// Half width of the envelope at `v_next`.
    pub(super) next_width: T,
}

/// How many plays the later of two samples pushes, up and down: near that of the sample behind it.
#[derive(Clone, Copy, Default)]
pub(super) struct Pushed {
    up: usize,
    down: usize,
}

impl<T: Real, const N: usize, const WINDOW: usize> PreviewInverse<T, N, WINDOW> {
    /// The step of the drive that (P 1) asks for.
    #[inline(always)]
    pub(super) fn solve(&self, sample: &Sample<'_, T, N>, pushed: &mut Pushed) -> T {
        // A falling reference is a rising one seen in a mirror.
        if sample.p < T::ZERO {
            -self.solve_rising(sample, -T::ONE, &mut pushed.down)
        } else {
            self.solve_rising(sample, T::ONE, &mut pushed.up)
        }
    }

    #[inline(always)]
    fn solve_rising(&self, sample: &Sample<'_, T, N>, sign: T, pushed: &mut usize) -> T {
        let v_next = sign * sample.v_next;
        let p = sign * sample.p;
        let direct = self.inverse.weight_0() * p;
        let q = p - sample.next_width + sample.wider;
        let hi = v_next + sample.next_width;
        let closing = p + sample.next_width - sample.wider;
        let bank = self.inverse.bank();
        let mut step = direct;
        // With q + b d <= 0 no play moves.
        if q + self.widening * direct > T::ZERO {
            step = self.solve_sliding(sample, sign, q, direct, pushed);
        }
        let pushed_back = sample
            .plays
            .first()
            .zip(bank.thresholds().first())
            .is_some_and(|(&y, &s)| sign * y - s > hi);
        if pushed_back && self.widening * step > closing {
            let rows = sample.plays.iter().zip(bank.thresholds());
            step = self.solve_closing(rows.zip(bank.weights()), sign, hi, closing, direct);
        }
        step
    }

    /// (P 3): those that are pushed at the next sample all slide, but for the last ones, which it
    /// captures.
    #[inline(always)]
    fn solve_sliding(
        &self,
        sample: &Sample<'_, T, N>,
        sign: T,
        q: T,
        direct: T,
        pushed: &mut usize,
    ) -> T {
        let lo = sign * sample.v_next - sample.next_width;
        let bank = self.inverse.bank();
        let (thresholds, weights) = (bank.thresholds(), bank.weights());
        let travel_of = |i: usize| {
            let play = sample.plays.get(i).zip(thresholds.get(i));
            play.map(|(&y, &s)| lo - s - sign * y)
        };
        while travel_of(*pushed).is_some_and(|e| e > T::ZERO) {
            *pushed += 1;
        }
        while let Some(last) = pushed.checked_sub(1)
            && travel_of(last).is_none_or(|e| e <= T::ZERO)
        {
            *pushed = last;
        }
        let mut sliding = *pushed;
        let mut captured = direct;
        while let Some(last) = sliding.checked_sub(1) {
            let row = self.sums.get(last).zip(self.gains.get(last));
            let (Some((&sum, &gain)), Some(e), Some(&b)) =
                (row, travel_of(last), weights.get(last))
            else {
                break;
            };
            let step = gain * (sum * q + captured);
            if q + self.widening * step < e {
                return step;
            }
            captured = captured + b * e;
            sliding = last;
        }
        captured
    }

    /// (P 5): the envelope that closes behind a turning point pushes plays back, and this step has
    /// to make up for it.
    #[cold]
    fn solve_closing<'a>(
        &self,
        rows: impl Iterator<Item = ((&'a T, &'a T), &'a T)> + Clone,
        sign: T,
        hi: T,
        closing: T,
        direct: T,
    ) -> T
    where
        T: 'a,
    {
        let pushed = rows
            .map(|((&y, &s), &b)| (sign * y - s - hi, b))
            .take_while(|&(back, _)| back > T::ZERO);
        let mut travel = T::ZERO;
        for (back, b) in pushed.clone() {
            travel = travel - b * back;
        }
        // From all of them held at the first sample downward: the one pushed furthest slides first.
        let mut step = direct + travel;
        let gains = self.sums.iter().zip(&self.closing_gains);
        for ((back, b), (&sum, &gain)) in pushed.zip(gains) {
            if self.widening * step - closing >= back || gain <= T::ZERO {
                break;
            }
            travel = travel + b * back;
            step = gain * (direct + travel + sum * closing);
        }
        step
    }
}
