//! Paper M's equations transcribed, an independent truth for the core's model and compensator.

#![allow(dead_code, reason = "each test file uses a part of it")]

pub mod cases;

use hysteron::hysteresis::modified_play::Terms;
use std::f64::consts::TAU;

/// Time between samples.
pub const DT: f64 = 2e-4;

/// Paper M's model as its equations stand, with arrays and loops over `i` and `j`.
pub struct Textbook {
    pub n: usize,
    pub u_max: f64,
    pub alpha: f64,
    pub beta: f64,
    pub frequency: f64,
    pub clamped: bool,
    pub gain: f64,
    /// `omega[i][j]`; row 0 is not used.
    pub omega: Vec<Vec<f64>>,
    pub terms: Terms<f64>,
    pub q: Vec<f64>,
    pub u: Vec<f64>,
    pub y: Vec<f64>,
}

impl Textbook {
    /// `r_i`.
    pub fn r(&self, i: usize) -> f64 {
        i as f64 * self.u_max / self.n as f64
    }

    fn x(&self, i: usize, j: usize, p: f64) -> f64 {
        let n = self.n as f64;
        let (i_, j_) = (i as f64, j as f64);
        let reach = self.u_max - self.r(i);
        let p_ij = (2.0 * j_ - n + 1.0 + i_) * reach / (n - i_);
        if self.clamped {
            ((p - p_ij) * (n - i_) / reach).clamp(-1.0, 1.0)
        } else {
            (p - p_ij) / reach
        }
    }

    /// `y[k]` for `u[k]` and a rate, in free run.
    pub fn step(&mut self, u: f64, rate: f64) -> f64 {
        let past = self.past();
        let (h_r, h_l) = (u + self.beta * rate.abs(), u - self.alpha * rate.abs());
        for i in 1..self.n {
            let r = self.r(i);
            self.q[i] = self.q[i].min(h_r + r).max(h_l - r);
        }
        let y = self.gain * u + self.memory() + past;
        self.u.push(u);
        self.y.push(y);
        y
    }

    /// `H` where the plays are.
    pub fn memory(&self) -> f64 {
        (1..self.n)
            .flat_map(|i| (0..self.n - i).map(move |j| (i, j)))
            .map(|(i, j)| self.omega[i][j] * self.x(i, j, self.q[i]))
            .sum()
    }

    /// What the next output holds of the samples before, besides the plays.
    pub fn past(&self) -> f64 {
        let mut y = 0.0;
        // Sample k = 1 comes first.
        let k = self.u.len() + 1;
        let before = |list: &[f64], steps: usize| {
            list.len()
                .checked_sub(steps)
                .map_or(0.0, |index| list[index])
        };
        let (u1, y1) = (before(&self.u, 1), before(&self.y, 1));
        y += self.terms.interleaving * y1 * u1;
        for steps in 1..=3 {
            y += self.terms.feedback[steps - 1] * before(&self.y, steps);
        }
        let angle = TAU * self.frequency * (k - 1) as f64 * DT;
        for (power, (a, b)) in [1, 3, 5]
            .into_iter()
            .zip(self.terms.sine.into_iter().zip(self.terms.cosine))
        {
            y += u1.powi(power) * (a * angle.sin() + b * angle.cos());
        }
        y
    }
}
