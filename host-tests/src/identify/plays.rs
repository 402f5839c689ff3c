//! Regressors: outputs of plays along a run, with their derivatives by threshold and beta.

use hysteron::play::{Envelope, play};

use super::run::Run;
use super::start::Start;

/// What the plays of a fit are, apart from their weights.
#[derive(Clone, Debug, PartialEq)]
pub struct Plays {
    /// `alpha_i` in volts, increasing.
    pub thresholds: Vec<f64>,
    /// Rate coefficient in seconds.
    pub beta: f64,
}

/// Where each play stands while a run is passed through.
#[derive(Clone, Debug)]
pub struct Walk {
    /// Outputs in volts.
    pub outputs: Vec<f64>,
    /// Derivative of each output by its threshold.
    pub by_threshold: Vec<f64>,
    /// Derivative of each output by beta, in V/s.
    pub by_beta: Vec<f64>,
}

impl Walk {
    /// The state before the run's first sample.
    pub fn new(plays: &Plays, run: &Run) -> Self {
        let (outputs, by_threshold): (Vec<f64>, Vec<f64>) = plays
            .thresholds
            .iter()
            .map(|&r| run.start.play(run.drive[0], r))
            .unzip();
        let by_beta = vec![0.0; outputs.len()];
        let mut walk = Self {
            outputs,
            by_threshold,
            by_beta,
        };
        if run.start == Start::Periodic {
            (0..run.drive.len()).for_each(|k| walk.step(plays, run, k));
        }
        walk
    }

    /// Moves the plays to sample `k` of the run.
    pub fn step(&mut self, plays: &Plays, run: &Run, k: usize) {
        let (u, rate) = (run.drive[k], run.rate(k));
        let half_width = plays.beta * rate;
        let envelope = Envelope {
            lo: u - half_width,
            hi: u + half_width,
        };
        for (i, &r) in plays.thresholds.iter().enumerate() {
            let before = self.outputs[i];
            let after = play(before, envelope, r);
            self.outputs[i] = after;
            // A push upwards comes from u - beta |u'| - r, one downwards from u + beta |u'| + r.
            if after != before {
                let sign = if after > before { -1.0 } else { 1.0 };
                self.by_threshold[i] = sign;
                self.by_beta[i] = sign * rate;
            }
        }
    }
}
