//! The records of a session as a stage answers them, and what an effect changes in them.

use crate::dataset::Role;

use super::chain::HiddenPlant;
use super::protocol::Plan;
use super::truth::Roles;

/// Turning points of the record before that a record still knows, besides the extremes so far.
const REMEMBERED: usize = 40;
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

/// The drive's extremes in all records before, the last turning points of the record before, and the
/// way to the next record, in small parts.
fn history(before: &[Plan], next: &Plan) -> Vec<f64> {
    let (Some(last), Some(&to)) = (before.last(), next.drive_v.first()) else {
        return Vec::new();
    };
    let all = || before.iter().flat_map(|plan| plan.drive_v.iter().copied());
    let mut corners = vec![
        0.0,
        all().fold(f64::MIN, f64::max),
        all().fold(f64::MAX, f64::min),
    ];
    let turns: Vec<f64> = last
        .drive_v
        .windows(3)
        .filter(|three| (three[1] - three[0]) * (three[2] - three[1]) < 0.0)
        .map(|three| three[1])
        .collect();
    corners.extend(&turns[turns.len().saturating_sub(REMEMBERED)..]);
    corners.extend(last.drive_v.last());
    corners.push(to);
    super::parts::refine(&corners, PARTS)
}
