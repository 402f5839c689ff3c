//! The records of a session as a stage answers them, and what an effect changes in them.

use crate::dataset::Role;

use super::chain::HiddenPlant;
use super::protocol::Plan;
use super::truth::Roles;

/// A planned session.
#[derive(Clone, Debug)]
pub(super) struct Session {
    pub(super) plans: Vec<Plan>,
}

impl Session {
    /// What a stage answers, record after record, without noise and rounding, um.
    pub(super) fn answers(&self, plant: &HiddenPlant) -> Vec<Vec<f64>> {
        let mut stage = plant.virgin();
        self.plans
            .iter()
            .map(|plan| stage.answer(&plan.drive_v, plan.sample_time_s, plan.start_s))
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
