//! Models for DIM.

use hysteron::hysteresis::modified_play::{
    Basis, BasisParameters, Harmonics, LinearPlane, ModifiedPlay, Terms,
};
use proptest::prelude::*;

use super::{DT, Textbook};

/// Capacity of the models.
pub const N: usize = 16;

/// A model with the collapsed plane, in numbers.
#[derive(Clone, Debug)]
pub struct Case {
    pub n: usize,
    pub u_max: f64,
    pub alpha: f64,
    pub beta: f64,
    pub frequency: f64,
    /// `2A`, then those of the plays.
    pub slopes: Vec<f64>,
    pub terms: Terms<f64>,
}

impl Case {
    /// As the core has it.
    pub fn model(&self) -> ModifiedPlay<f64, N, LinearPlane<f64, N>> {
        let basis: Basis<f64, N> = BasisParameters {
            u_max: self.u_max,
            divisions: self.n,
            alpha: self.alpha,
            beta: self.beta,
            harmonics: Harmonics::Printed,
            frequency: self.frequency,
        }
        .build(DT)
        .unwrap();
        let plane = LinearPlane::new(basis.grid(), &self.slopes, 0.0).unwrap();
        ModifiedPlay::new(&basis, plane, self.terms).unwrap()
    }

    /// Weights that lie symmetric in their row: they have the slopes and no offset.
    pub fn textbook(&self) -> Textbook {
        let omega = (0..self.n).map(|i| {
            let reach = self.u_max * (1.0 - i as f64 / self.n as f64);
            vec![self.slopes[i] * reach / (self.n - i) as f64; self.n - i]
        });
        Textbook {
            n: self.n,
            u_max: self.u_max,
            alpha: self.alpha,
            beta: self.beta,
            frequency: self.frequency,
            clamped: false,
            gain: self.slopes[0],
            omega: omega.collect(),
            terms: self.terms,
            q: vec![0.0; self.n],
            u: vec![],
            y: vec![],
        }
    }

    /// Sum of all slopes.
    pub fn total(&self) -> f64 {
        self.slopes.iter().sum()
    }
}

/// Models whose map is monotone, rising or falling, single slopes of any sign, with terms that do not
/// make the simulated output run away.
pub fn cases() -> impl Strategy<Value = Case> {
    (
        2..=N,
        0.5f64..5.0,
        0.0f64..1e-3,
        0.0f64..1e-3,
        1.0f64..110.0,
        any::<bool>(),
    )
        .prop_flat_map(|(n, u_max, alpha, beta, frequency, falling)| {
            let sums = prop::collection::vec(0.2f64..2.0, n);
            let others = prop::array::uniform10(-0.1f64..0.1);
            (sums, others).prop_map(move |(sums, others)| {
                let sign = if falling { -1.0 } else { 1.0 };
                let mut before = 0.0;
                let slopes = sums.into_iter().map(|sum| {
                    let slope = sign * (sum - before);
                    before = sum;
                    slope
                });
                let mut terms = Terms::from_list(&others);
                // Powers of u up to the fifth.
                for i in 0..3 {
                    let size = u_max.powi(2 * i as i32);
                    terms.sine[i] /= size;
                    terms.cosine[i] /= size;
                }
                terms.interleaving /= u_max;
                Case {
                    n,
                    u_max,
                    alpha,
                    beta,
                    frequency,
                    slopes: slopes.collect(),
                    terms,
                }
            })
        })
}

/// References within what the stage reaches, mostly, and rates.
pub fn references() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((-0.3f64..0.3, -400.0f64..400.0), 1..200)
}

/// Ten divisions, memory `share` of the gain, 25 Hz, nothing but plays.
pub fn plays_only(share: f64) -> Case {
    let mut slopes = vec![1.0];
    slopes.extend([share / 9.0; 9]);
    Case {
        n: 10,
        u_max: 1.0,
        alpha: 0.0,
        beta: 0.0,
        frequency: 25.0,
        slopes,
        terms: Terms::none(),
    }
}
