//! Which rate the plant sees, and the way back to the plan where that rate jumps.

use serde::{Deserialize, Serialize};

use crate::math::{Real, max, min};

use super::window::Entry;
use super::{PreviewInverse, PreviewState};

/// Which rate of its drive a plant sees at a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum PlantRate {
    /// That of the step to come: inverted exactly.
    Forward,
    /// Something between the two: a drive for a plant of which no more is known.
    Midpoint,
    /// That of the step that led there, the drive joined by straight lines.
    Backward,
}

impl PlantRate {
    /// `g`, the share of the step that led there.
    ///
    /// That of the midpoint keeps the largest error on both kinds of plant low; at 1/2 that of the
    /// first is the larger for the published stage.
    pub(super) const fn share(self) -> f64 {
        match self {
            Self::Forward => 0.0,
            Self::Midpoint => 0.46,
            Self::Backward => 1.0,
        }
    }
}

/// The plant that a preview inverse simulates with what it emits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plant<T, const N: usize> {
    plays: [T; N],
    drive: T,
}

/// What the simulated plant does with a drive.
pub(super) struct Response<T, const N: usize> {
    output: T,
    pub(super) plant: Plant<T, N>,
    /// How many plays slide at the end of the step.
    sliding: usize,
}

/// Gains of the way back to the plan (P 7), for `m` plays that slide at a sample and `m'` that will
/// at the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Return<T, const N: usize> {
    /// `m = 0`, `m' = 0`.
    resting: T,
    /// `m = 0`, by `m' - 1`.
    catching: [T; N],
    /// `m' = 0`, by `m - 1`.
    leaving: [T; N],
    /// By `m - 1` and `m' - 1`.
    sliding: [[T; N]; N],
}

impl<T: Real, const N: usize> Return<T, N> {
    /// For the weight `a_0`, the partial sums `A_1..A_n` and `ratio = beta / h`.
    #[inline(never)]
    pub(super) fn new(a_0: T, sums: &[T], ratio: T) -> Self {
        let slope = |sum: T| sum - (sum - a_0) * ratio;
        let cost = |sum: T| {
            let (alpha, gamma) = (slope(sum), (sum - a_0) * ratio);
            max(gamma * gamma - alpha * alpha, T::ZERO)
        };
        let gain = |alpha: T, cost: T| {
            let gain = alpha / (alpha * alpha + cost);
            if gain.is_finite() { gain } else { T::ZERO }
        };
        let mut gains = Self {
            resting: gain(a_0, T::ZERO),
            catching: [T::ZERO; N],
            leaving: [T::ZERO; N],
            sliding: [[T::ZERO; N]; N],
        };
        for (to, &sum) in gains.catching.iter_mut().zip(sums) {
            *to = gain(a_0, cost(sum));
        }
        for (to, &sum) in gains.leaving.iter_mut().zip(sums) {
            *to = gain(slope(sum), T::ZERO);
        }
        for (row, &now) in gains.sliding.iter_mut().zip(sums) {
            for (to, &next) in row.iter_mut().zip(sums) {
                *to = gain(slope(now), cost(next));
            }
        }
        gains
    }

    fn gain(&self, now: usize, next: usize) -> T {
        let gain = match (now.checked_sub(1), next.checked_sub(1)) {
            (None, None) => Some(&self.resting),
            (None, Some(next)) => self.catching.get(next),
            (Some(now), None) => self.leaving.get(now),
            (Some(now), Some(next)) => self.sliding.get(now).and_then(|row| row.get(next)),
        };
        gain.copied().unwrap_or(T::ZERO)
    }
}

impl<T: Real, const N: usize> Plant<T, N> {
    pub(super) fn new(drive: T) -> Self {
        Self {
            plays: [T::ZERO; N],
            drive,
        }
    }
}

impl<T: Real, const N: usize, const WINDOW: usize> PreviewInverse<T, N, WINDOW> {
    /// The drive for the oldest sample; the plays before the next one take its place.
    pub(super) fn emit(&self, state: &mut PreviewState<T, N, WINDOW>) -> T {
        let (entry, plays) = state.window.oldest();
        let half_width = self.half_width(&entry);
        let (lo, hi) = (entry.reference - half_width, entry.reference + half_width);
        let mut drive = self.inverse.weight_0() * entry.reference;
        let bank = self.inverse.bank();
        let rows = plays.iter_mut().zip(bank.thresholds()).zip(bank.weights());
        for ((y, &s), &b) in rows {
            *y = max(min(*y, hi + s), lo - s);
            drive = drive + b * *y;
        }
        if self.share > T::ZERO {
            let response = self.aim(&state.plant, &entry, drive);
            state.plant = response.plant;
            self.take_over(&response, plays);
            drive = response.plant.drive;
        }
        drive
    }

    /// The drive for a reference at rest; plays and simulated plant settle there.
    ///
    /// The plays of the plant are those that (J 16, corrected) makes the inverse's of, so that a state
    /// whose inverse plays came from elsewhere has the plant that belongs to them.
    pub(super) fn settle(&self, state: &mut PreviewState<T, N, WINDOW>, reference: T) -> T {
        let PreviewState { window, plant } = state;
        let (_, plays) = window.oldest();
        let bank = self.inverse.bank();
        let weight_0 = self.inverse.weight_0();
        let mut drive = weight_0 * reference;
        let mut distance_before = T::ZERO;
        let mut share = weight_0;
        let mut x = T::ZERO;
        let rows = plays.iter_mut().zip(&mut plant.plays);
        let inverse = bank.thresholds().iter().zip(bank.weights());
        for ((y, z), (&s, &b)) in rows.zip(inverse) {
            *y = max(min(*y, reference + s), reference - s);
            drive = drive + b * *y;
            let distance = reference - *y;
            x = x + share * (distance - distance_before);
            (distance_before, share) = (distance, share + b);
            // Its distance from the drive, which is known in the end.
            *z = x;
        }
        for (z, _) in plant.plays.iter_mut().zip(bank.thresholds()) {
            *z = drive - *z;
        }
        plant.drive = drive;
        drive
    }

    /// The planned drive, moved by (P 7).
    fn aim(&self, plant: &Plant<T, N>, entry: &Entry<T>, planned: T) -> Response<T, N> {
        let response = self.respond(plant, planned);
        let error = response.output - entry.reference;
        let next = self.respond(&response.plant, planned + entry.step);
        let gain = self.returning.gain(response.sliding, next.sliding);
        // Beyond that the step would change its direction, and with it all that (P 7) rests on.
        let limit = (planned - plant.drive).abs();
        let change = self.share * self.share * gain * error;
        let moved = self.respond(plant, planned - max(min(change, limit), -limit));
        if (moved.output - entry.reference).abs() < error.abs() {
            moved
        } else {
            response
        }
    }

    /// The plant at the end of a line from its drive to the next one.
    pub(super) fn respond(&self, plant: &Plant<T, N>, drive: T) -> Response<T, N> {
        let step = drive - plant.drive;
        let half_width = self.ratio * step.abs();
        // The envelope takes its width at once, so the line pushes at both of its ends.
        let rising = step >= T::ZERO;
        let (first, last) = if rising {
            (plant.drive, drive)
        } else {
            (drive, plant.drive)
        };
        let (lo, hi) = (last - half_width, first + half_width);
        let mut plays = plant.plays;
        let mut output = self.model.weight_0() * drive;
        let mut sliding = 0;
        let bank = self.model.bank();
        let rows = plays.iter_mut().zip(bank.thresholds()).zip(bank.weights());
        for ((z, &r), &a) in rows {
            let (floor, ceiling) = (lo - r, hi + r);
            if *z < floor {
                *z = floor;
                sliding += usize::from(rising);
            } else if *z > ceiling {
                *z = ceiling;
                sliding += usize::from(!rising);
            }
            output = output + a * *z;
        }
        Response {
            output,
            plant: Plant { plays, drive },
            sliding,
        }
    }

    /// Takes the inverse plays over from the plant (J 16, corrected), so that no error stays.
    fn take_over(&self, response: &Response<T, N>, plays: &mut [T; N]) {
        let Plant { plays: z, drive } = &response.plant;
        let mut partial_sum = self.model.weight_0();
        let (mut x_before, mut distance) = (T::ZERO, T::ZERO);
        let rows = z.iter().zip(self.model.bank().weights());
        for (y, (&z, &a)) in plays.iter_mut().zip(rows) {
            let x = *drive - z;
            distance = distance + partial_sum * (x - x_before);
            x_before = x;
            partial_sum = partial_sum + a;
            *y = response.output - distance;
        }
    }
}
