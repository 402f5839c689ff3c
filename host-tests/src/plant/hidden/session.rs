//! The records of a session as a stage answers them, and what an effect changes in them.

use crate::dataset::Role;

use super::chain::HiddenPlant;
use super::protocol::Plan;
use super::truth::Roles;

/// Parts that a slow move between two turning points is made in.
const PARTS: usize = 16;

/// A planned session with the slow moves before each record.
#[derive(Clone, Debug)]
pub(super) struct Session {
    pub(super) plans: Vec<Plan>,
    histories: Vec<Vec<f64>>,
}

impl Session {
    pub(super) fn new(plans: Vec<Plan>) -> Self {
        let histories = (0..plans.len())
            .map(|k| history(&plans[..k], &plans[k]))
            .collect();
        Self { plans, histories }
    }

    /// What a stage answers, without noise and rounding, um.
    pub(super) fn answers(&self, plant: &HiddenPlant) -> Vec<Vec<f64>> {
        self.plans
            .iter()
            .zip(&self.histories)
            .map(|(plan, history)| {
                plant.displacement(history, &plan.drive_v, plan.sample_time_s, plan.start_s)
            })
            .collect()
    }

    /// Rms of the difference of two sets of answers by role, um.
    pub(super) fn moved(&self, with: &[Vec<f64>], without: &[Vec<f64>]) -> Roles {
        self.by_role(with, without, |_| 0.0)
    }

    /// The same after the best offset and gain on `without`, over all records; and over all of
    /// them together.
    pub(super) fn left(&self, with: &[Vec<f64>], without: &[Vec<f64>]) -> (Roles, f64) {
        let (offset, gain) = affine(with, without);
        let more = |y: f64| offset + (gain - 1.0) * y;
        let squares: Vec<f64> = with
            .iter()
            .zip(without)
            .map(|(with, without)| mean_square(with, without, more))
            .collect();
        let total = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
        (self.by_role(with, without, more), total)
    }

    fn by_role(&self, with: &[Vec<f64>], without: &[Vec<f64>], more: impl Fn(f64) -> f64) -> Roles {
        let rms = |role: Role| {
            let squares: Vec<f64> = self
                .plans
                .iter()
                .zip(with.iter().zip(without))
                .filter(|(plan, _)| plan.role == role)
                .map(|(_, (with, without))| mean_square(with, without, &more))
                .collect();
            (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
        };
        Roles {
            fit: rms(Role::Fit),
            select: rms(Role::Select),
            report: rms(Role::Report),
        }
    }
}

fn mean_square(with: &[f64], without: &[f64], more: impl Fn(f64) -> f64) -> f64 {
    let squares = with
        .iter()
        .zip(without)
        .map(|(a, b)| (a - b - more(*b)).powi(2));
    squares.sum::<f64>() / with.len().max(1) as f64
}

/// Offset and gain that take `without` nearest to `with`, each record with the same weight.
fn affine(with: &[Vec<f64>], without: &[Vec<f64>]) -> (f64, f64) {
    let mean = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        let of_record = |(a, b): (&Vec<f64>, &Vec<f64>)| {
            a.iter().zip(b).map(|(&y, &x)| f(y, x)).sum::<f64>() / a.len().max(1) as f64
        };
        with.iter().zip(without).map(of_record).sum::<f64>() / with.len().max(1) as f64
    };
    let (y, x) = (mean(&|y, _| y), mean(&|_, x| x));
    let spread = mean(&|_, b| (b - x).powi(2));
    let gain = if spread > 0.0 {
        mean(&|a, b| (a - y) * (b - x)) / spread
    } else {
        1.0
    };
    (y - gain * x, gain)
}

/// What a stage of nested loops still knows of all records before, and the way to the next record, in
/// small parts.
fn history(before: &[Plan], next: &Plan) -> Vec<f64> {
    let Some(&to) = next.drive_v.first() else {
        return Vec::new();
    };
    if before.is_empty() {
        return Vec::new();
    }
    let all = || before.iter().flat_map(|plan| plan.drive_v.iter().copied());
    let mut corners = vec![0.0];
    corners.extend(remembered(&all().collect::<Vec<f64>>()));
    corners.push(to);
    super::parts::refine(&corners, PARTS)
}

/// The samples that no later one wipes out: seen from the end, each extreme beyond all that followed, the
/// end first of them.
fn remembered(drive: &[f64]) -> Vec<f64> {
    let Some(&end) = drive.last() else {
        return Vec::new();
    };
    let (mut low, mut high) = (end, end);
    let mut kept = vec![end];
    let mut rising = None;
    for &u in drive.iter().rev() {
        let beyond = if u > high {
            high = u;
            Some(true)
        } else if u < low {
            low = u;
            Some(false)
        } else {
            None
        };
        match beyond {
            // Farther out on the same side: that is the extreme.
            Some(up) if rising == Some(up) => {
                kept.pop();
                kept.push(u);
            }
            Some(up) => {
                rising = Some(up);
                kept.push(u);
            }
            None => {}
        }
    }
    kept.reverse();
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A play at the end of the whole drive is where it is after what is remembered of it.
    #[test]
    fn what_is_remembered_sets_every_play() {
        let drive: Vec<f64> = (0..4000)
            .map(|k| {
                let t = f64::from(k) * 0.01;
                (1.0 + 0.4 * (0.13 * t).cos()) * (t.sin() + 0.6 * (2.7 * t).sin())
            })
            .collect();
        let play =
            |drive: &[f64], r: f64| drive.iter().fold(0.0f64, |z, u| z.min(u + r).max(u - r));
        for end in [17, 900, 2345, 4000] {
            let kept = remembered(&drive[..end]);
            for r in [0.0, 0.05, 0.3, 0.8, 1.5] {
                assert_eq!(play(&kept, r), play(&drive[..end], r), "{end} {r}");
            }
        }
    }
}
