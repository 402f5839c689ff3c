//! The modified play model against a plain transcription of paper M's equations.

mod paper_m;

use hysteron::hysteresis::modified_play::{
    Basis, BasisParameters, ClampedPlane, Harmonics, LinearPlane, ModifiedPlay, OUTPUT_BOUND,
    Plane, Terms,
};
use paper_m::{DT, Textbook};
use proptest::prelude::*;

const N: usize = 16;
#[derive(Clone, Debug)]
struct Case {
    n: usize,
    u_max: f64,
    alpha: f64,
    beta: f64,
    frequency: f64,
    gain: f64,
    weights: Vec<f64>,
    terms: Terms<f64>,
}

impl Case {
    fn basis(&self) -> Basis<f64, N> {
        BasisParameters {
            u_max: self.u_max,
            divisions: self.n,
            alpha: self.alpha,
            beta: self.beta,
            harmonics: Harmonics::Printed,
            frequency: self.frequency,
        }
        .build(DT)
        .unwrap()
    }

    fn textbook(&self, clamped: bool) -> Textbook {
        let mut weights = self.weights.iter().copied();
        let omega = (0..self.n)
            .map(|i| match i {
                0 => vec![],
                _ => weights.by_ref().take(self.n - i).collect(),
            })
            .collect();
        Textbook {
            n: self.n,
            u_max: self.u_max,
            alpha: self.alpha,
            beta: self.beta,
            frequency: self.frequency,
            clamped,
            gain: self.gain,
            omega,
            terms: self.terms,
            q: vec![0.0; self.n],
            u: vec![],
            y: vec![],
        }
    }

    /// The weights with a row 0 that sums up to `2A u` in front of them.
    fn all_weights(&self) -> Vec<f64> {
        let row_0 = vec![self.gain * self.u_max / self.n as f64; self.n];
        row_0.into_iter().chain(self.weights.clone()).collect()
    }

    fn linear(&self) -> ModifiedPlay<f64, N, LinearPlane<f64, N>> {
        let basis = self.basis();
        let plane = LinearPlane::collapse(basis.grid(), &self.all_weights()).unwrap();
        ModifiedPlay::new(&basis, plane, self.terms).unwrap()
    }

    fn clamped(&self) -> ModifiedPlay<f64, N, ClampedPlane<f64, N>> {
        let basis = self.basis();
        let plane = ClampedPlane::new(basis.grid(), self.gain, &self.weights).unwrap();
        ModifiedPlay::new(&basis, plane, self.terms).unwrap()
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let signed = || -0.2f64..0.2;
    let plane = (
        2..=N,
        0.5f64..2.0,
        0.0f64..1e-3,
        0.0f64..1e-3,
        1.0f64..110.0,
    );
    plane.prop_flat_map(move |(n, u_max, alpha, beta, frequency)| {
        (
            signed(),
            prop::collection::vec(signed(), n * (n - 1) / 2),
            prop::array::uniform10(signed()),
        )
            .prop_map(move |(gain, weights, others)| Case {
                n,
                u_max,
                alpha,
                beta,
                frequency,
                gain,
                weights,
                terms: Terms::from_list(&others),
            })
    })
}

/// Inputs with corners, in parts of the range, and a rate of any kind.
fn drives() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((-1.0f64..1.0, -500.0f64..500.0), 1..150)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn both_planes_are_the_printed_sums(case in cases(), drives in drives()) {
        let linear = case.linear();
        let clamped = case.clamped();
        let mut books = [case.textbook(false), case.textbook(true)];
        let mut states = [linear.start(), clamped.start()];
        for (u, rate) in drives {
            let u = u * case.u_max;
            let exact = linear.step_with_rate(&mut states[0], u, rate);
            let printed = books[0].step(u, rate);
            // The feedback may amplify: weigh with what has been reached.
            let size = 1.0 + printed.abs();
            prop_assert!((exact - printed).abs() < 1e-12 * size, "{exact} {printed}");
            let exact = clamped.step_with_rate(&mut states[1], u, rate);
            let printed = books[1].step(u, rate);
            prop_assert!((exact - printed).abs() < 1e-12 * size.max(1.0 + printed.abs()));
        }
    }

    #[test]
    fn the_backward_difference_is_the_rate_of_a_plain_step(case in cases(), drives in drives()) {
        let model = case.linear();
        let (mut one, mut other) = (model.start(), model.start());
        let mut before = 0.0;
        for (u, _) in drives {
            let y = model.step(&mut one, u);
            let rate = (u - before) / DT;
            let expected = model.step_with_rate(&mut other, u, rate);
            prop_assert!((y - expected).abs() < 1e-12);
            before = u;
        }
    }

    #[test]
    fn weighted_terms_make_the_output(case in cases(), drives in drives()) {
        let (linear, clamped, basis) = (case.linear(), case.clamped(), case.basis());
        let (mut one, mut two, mut own) = (linear.start(), clamped.start(), basis.start());
        let slopes: Vec<f64> = std::iter::once(linear.plane().gain())
            .chain(linear.plane().slopes().iter().copied())
            .chain([linear.plane().offset()])
            .collect();
        let weights: Vec<f64> =
            std::iter::once(case.gain).chain(case.weights.iter().copied()).collect();
        let t = case.terms;
        let others = [
            t.interleaving, t.feedback[0], t.feedback[1], t.feedback[2],
            t.sine[0], t.cosine[0], t.sine[1], t.cosine[1], t.sine[2], t.cosine[2],
        ];
        let dot = |a: &[f64], b: &[f64]| -> f64 {
            assert_eq!(a.len(), b.len());
            a.iter().zip(b).map(|(a, b)| a * b).sum()
        };
        for (k, (u, rate)) in drives.into_iter().enumerate() {
            // Measured outputs of any kind: the prediction is from them.
            let measured = (k as f64 * 0.3).sin();
            let signals = basis.advance(&mut own, u, rate);
            own.remember(u, measured);
            let rest = dot(&signals.other_terms(), &others);
            let terms: Vec<f64> = basis.linear_terms(&signals).collect();
            let y = linear.predict(&mut one, u, rate, measured);
            prop_assert!((dot(&terms, &slopes) + rest - y).abs() < 1e-12);
            let terms: Vec<f64> = basis.clamped_terms(&signals).collect();
            let y = clamped.predict(&mut two, u, rate, measured);
            prop_assert!((dot(&terms, &weights) + rest - y).abs() < 1e-12);
        }
    }

    /// (M 11) to (M 16): with the slopes of the plays known, alpha and beta enter linearly, but for
    /// the plays that nothing holds.
    #[test]
    fn the_terms_of_the_rate_add_up(case in cases(), drives in drives()) {
        let (model, basis) = (case.linear(), case.basis());
        let mut state = basis.start();
        for (u, rate) in drives {
            let signals = basis.advance(&mut state, u * case.u_max, rate);
            let slopes = model.plane().local_slopes(&signals.plays);
            let terms = basis.rate_terms(&signals, &slopes);
            let sum = |plays: &[f64; N]| -> f64 {
                plays.iter().zip(model.plane().slopes()).map(|(p, s)| p * s).sum()
            };
            let split = sum(&terms.plays) + case.alpha * terms.alpha + case.beta * terms.beta;
            prop_assert!((split - sum(&signals.plays)).abs() < 1e-12);
            // A play that is held sits at its threshold from the input itself.
            for (i, (&bare, &p)) in terms.plays.iter().zip(&signals.plays).enumerate().take(case.n - 1) {
                let r = case.textbook(false).r(i + 1);
                let distance = (bare - signals.input).abs();
                prop_assert!(bare == p || (distance - r).abs() < 1e-12);
            }
            state.remember(u, 0.0);
        }
    }

    /// The derivative of the memory by a play is its local slope.
    #[test]
    fn local_slopes_are_differences(case in cases(), shares in prop::array::uniform16(-1.0f64..1.0)) {
        let model = case.clamped();
        let plane = model.plane();
        let grid = *model.grid();
        let mut plays = [0.0; N];
        for (i, (p, share)) in plays.iter_mut().zip(shares).enumerate() {
            *p = share * case.u_max * (1.0 - (i + 1) as f64 / N as f64);
        }
        let slopes = plane.local_slopes(&plays);
        let cell = 2.0 * case.u_max / case.n as f64;
        for i in 0..case.n - 1 {
            // Away from the corner between two cells.
            let within = ((plays[i] - grid.point(i + 1, 0)) / cell + 0.5).rem_euclid(1.0);
            prop_assume!((1e-3..0.999).contains(&within));
            let mut moved = plays;
            let h = 1e-5 * cell;
            moved[i] += h;
            let difference = (plane.memory(0.0, &moved) - plane.memory(0.0, &plays)) / h;
            prop_assert!((difference - slopes[i]).abs() < 1e-6, "{difference} {}", slopes[i]);
        }
    }
}

#[test]
fn nothing_that_runs_away_is_remembered_as_infinite() {
    let basis: Basis<f32, 4> = BasisParameters {
        u_max: 1.0,
        divisions: 4,
        alpha: 0.0,
        beta: 0.0,
        harmonics: Harmonics::Printed,
        frequency: 10.0,
    }
    .build(2e-4)
    .unwrap();
    let plane = LinearPlane::new(basis.grid(), &[1.0, 0.1, 0.1, 0.1], 0.0).unwrap();
    let terms = Terms {
        interleaving: 3e38,
        feedback: [3e38, -3e38, 3e38],
        ..Terms::none()
    };
    let model = ModifiedPlay::new(&basis, plane, terms).unwrap();
    let mut state = model.start();
    for k in 0..1000 {
        let y = model.step(&mut state, (k as f32 * 0.1).sin());
        assert!(y.abs() <= OUTPUT_BOUND as f32, "{k}: {y}");
        assert!(state.outputs().iter().all(|y| y.is_finite()));
    }
}
