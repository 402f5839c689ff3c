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

impl<T: Real, const N: usize, const WINDOW: usize> PreviewInverse<T, N, WINDOW> {
    /// The step of the drive that (P 1) asks for.
    #[inline(always)]
    pub(super) fn solve(&self, sample: &Sample<'_, T, N>) -> T {
        // A falling reference is a rising one seen in a mirror.
        if sample.p < T::ZERO {
            -self.solve_rising(sample, -T::ONE)
        } else {
            self.solve_rising(sample, T::ONE)
        }
    }

    #[inline(always)]
    fn solve_rising(&self, sample: &Sample<'_, T, N>, sign: T) -> T {
        let v_next = sign * sample.v_next;
        let p = sign * sample.p;
        let direct = self.inverse.weight_0() * p;
        let q = p - sample.next_width + sample.wider;
        let lo = v_next - sample.next_width;
        let hi = v_next + sample.next_width;
        let bank = self.inverse.bank();
        let rows = || {
            let rows = sample.plays.iter().zip(bank.thresholds());
            rows.zip(bank.weights())
        };
        // What plays travel that are pushed at the next sample at the latest: a prefix.
        let mut step = direct;
        let mut travel = T::ZERO;
        for ((&y, &s), &b) in rows() {
            let e = lo - s - sign * y;
            if e <= T::ZERO {
                break;
            }
            travel = travel + b * e;
        }
        step = step + travel;
        // (P 3) from no sliding play upward: each takes its travel out of the rest.
        for (((&y, &s), &b), (&sum, &gain)) in rows().zip(self.sums.iter().zip(&self.gains)) {
            let e = lo - s - sign * y;
            if e <= T::ZERO || q + self.widening * step >= e {
                break;
            }
            travel = travel - b * e;
            step = gain * (direct + sum * q + travel);
        }
        // Plays with e_i > 0 then all slide, and with q + b d <= 0 they do not move.
        if q + self.widening * step <= T::ZERO {
            step = direct;
        }
        let closing = p + sample.next_width - sample.wider;
        let pushed_back = sample
            .plays
            .first()
            .zip(bank.thresholds().first())
            .is_some_and(|(&y, &s)| sign * y - s > hi);
        if pushed_back && self.widening * step > closing {
            step = self.solve_closing(rows(), sign, hi, closing, direct);
        }
        step
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
