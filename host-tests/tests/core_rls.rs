//! Recursive least squares against the batch solution, the textbook recursion, and time.

use hysteron::error::{Field, ParameterError, SampleError};
use hysteron::hysteresis::modified_play::{Basis, BasisParameters, Harmonics};
use hysteron::rls::{Estimate, Rls};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use proptest::prelude::*;

/// A sequence of numbers evenly spread over -1..1.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Weighted least squares by singular values.
fn batch<const K: usize>(rows: &[([f64; K], f64)], forgetting: f64) -> Vec<f64> {
    let weight = |k: usize| forgetting.powi((rows.len() - 1 - k) as i32).sqrt();
    let matrix = DMatrix::from_fn(rows.len(), K, |k, i| weight(k) * rows[k].0[i]);
    let right = DVector::from_fn(rows.len(), |k, _| weight(k) * rows[k].1);
    let solution = matrix.svd(true, true).solve(&right, 1e-14).unwrap();
    solution.iter().copied().collect()
}

fn recursive<const K: usize>(rows: &[([f64; K], f64)], forgetting: f64) -> Estimate<f64, K> {
    let rls = Rls::new(forgetting, 1e10, 1e14).unwrap();
    let mut estimate = rls.start([0.0; K]);
    for (x, y) in rows {
        rls.update(&mut estimate, x, *y).unwrap();
    }
    estimate
}

/// Terms and measured outputs of a bimorph-like plant that is not of the model's kind, alpha and beta
/// given, under a rich drive.
fn plant(samples: usize) -> Vec<([f64; 21], f64)> {
    let basis: Basis<f64, 10> = BasisParameters {
        u_max: 1.0,
        divisions: 10,
        alpha: 1e-4,
        beta: 2e-4,
        harmonics: Harmonics::Printed,
        frequency: 25.0,
    }
    .build(2e-4)
    .unwrap();
    let mut noise = Noise(7);
    let mut state = basis.start();
    let (mut y, mut speed) = (0.0, 0.0);
    (0..samples)
        .map(|k| {
            let t = k as f64 * 2e-4;
            let u = 0.5 * (158.0 * t).sin() + 0.3 * (431.0 * t).sin() + 0.2 * noise.next();
            let rate = basis.backward_rate(&state, u);
            let signals = basis.advance(&mut state, u, rate);
            speed += 0.01 * (u + 0.1 * u * u - y) - 0.02 * speed;
            y += speed;
            state.remember(u, y);
            let terms: Vec<f64> = basis
                .linear_terms(&signals)
                .chain(signals.other_terms())
                .collect();
            (terms.try_into().unwrap(), y + 1e-4 * noise.next())
        })
        .collect()
}

#[test]
fn the_models_own_terms_are_fitted_as_in_a_batch() {
    let rows = plant(6_000);
    for forgetting in [1.0, 0.9995] {
        let expected = batch(&rows, forgetting);
        let found = recursive(&rows, forgetting);
        let worst = found
            .parameters()
            .iter()
            .zip(&expected)
            .map(|(a, b)| (a - b).abs() / b.abs().max(1.0))
            .fold(0.0, f64::max);
        println!("forgetting {forgetting}: {worst:e}");
        assert!(worst < 1e-6, "{worst:e}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_regression_is_fitted_as_in_a_batch(
        seed in any::<u64>(),
        samples in 40usize..400,
        forgetting in prop::sample::select(vec![1.0, 0.99, 0.9]),
    ) {
        let mut noise = Noise(seed);
        let truth: [f64; 6] = std::array::from_fn(|_| noise.next());
        let rows: Vec<([f64; 6], f64)> = (0..samples)
            .map(|_| {
                let x: [f64; 6] = std::array::from_fn(|_| noise.next());
                let y: f64 = x.iter().zip(&truth).map(|(x, t)| x * t).sum();
                (x, y + 0.1 * noise.next())
            })
            .collect();
        let found = recursive(&rows, forgetting);
        for (a, b) in found.parameters().iter().zip(batch(&rows, forgetting)) {
            prop_assert!((a - b).abs() < 1e-6, "{a} {b}");
        }
    }

    /// The recursion as every textbook has it, with the whole covariance.
    #[test]
    fn the_factored_recursion_is_the_textbooks(seed in any::<u64>(), forgetting in 0.9f64..1.0) {
        let mut noise = Noise(seed);
        let rls = Rls::new(forgetting, 100.0, 1e6).unwrap();
        let mut estimate = rls.start([0.0; 5]);
        let mut p = SMatrix::<f64, 5, 5>::identity() * 100.0;
        let mut theta = SVector::<f64, 5>::zeros();
        for _ in 0..60 {
            let x: [f64; 5] = std::array::from_fn(|_| noise.next());
            let y = noise.next();
            let column = SVector::from(x);
            let error = y - column.dot(&theta);
            let gain = p * column / (forgetting + column.dot(&(p * column)));
            theta += gain * error;
            p = (p - gain * column.transpose() * p) / forgetting;
            let told = rls.update(&mut estimate, &x, y).unwrap();
            prop_assert!((told - error).abs() < 1e-9);
        }
        let covariance = estimate.covariance();
        for i in 0..5 {
            prop_assert!((estimate.parameters()[i] - theta[i]).abs() < 1e-9);
            for j in 0..5 {
                prop_assert!((covariance[i][j] - p[(i, j)]).abs() < 1e-9 * p.norm().max(1.0));
            }
        }
    }
}

fn trace<const K: usize>(estimate: &Estimate<f32, K>) -> f32 {
    let covariance = estimate.covariance();
    for i in 0..K {
        assert!(covariance[i][i] > 0.0);
        for j in 0..K {
            // Symmetric to the bit, and no pair is more than fully correlated.
            assert_eq!(covariance[i][j].to_bits(), covariance[j][i].to_bits());
            let limit = (covariance[i][i] * covariance[j][j]).sqrt();
            assert!(covariance[i][j].abs() <= 1.001 * limit);
        }
    }
    (0..K).map(|i| covariance[i][i]).sum()
}

/// 10^7 samples in single precision with forgetting, 10^6 without: rich ones, ones that excite a single direction,
/// and silence, in turn.
#[test]
fn ten_million_samples_do_not_diverge() {
    const BOUND: f32 = 1e4;
    let truth = [0.7f32, -0.3, 0.05, 1.2];
    let mut noise = Noise(3);
    for (forgetting, samples) in [(1.0f32, 1_000_000u32), (0.999, 10_000_000)] {
        let rls = Rls::new(forgetting, 100.0, BOUND).unwrap();
        let mut estimate = rls.start([0.0f32; 4]);
        let mut worst = 0.0f32;
        for k in 0..samples {
            let x = match k / 50_000 % 3 {
                0 => std::array::from_fn(|_| noise.next() as f32),
                1 => [noise.next() as f32, 0.0, 0.0, 0.0],
                _ => [0.0; 4],
            };
            let y: f32 = x.iter().zip(&truth).map(|(x, t)| x * t).sum();
            let measured = y + 1e-3 * noise.next() as f32;
            rls.update(&mut estimate, &x, measured).unwrap();
            if k % 50_000 == 49_999 {
                assert!(trace(&estimate) <= 1.001 * BOUND);
                for (found, truth) in estimate.parameters().iter().zip(truth) {
                    worst = worst.max((found - truth).abs());
                }
            }
        }
        println!("forgetting {forgetting}: worst {worst:e}");
        assert!(worst < 2e-3, "{worst:e}");
    }
}

/// The terms of the whole model, 21 of them, in single precision, in the phases that a stage sees.
#[test]
fn the_models_own_terms_do_not_diverge_in_single_precision() {
    let rows = plant(40_000);
    let rls = Rls::new(0.9998f32, 1e3, 1e6).unwrap();
    let mut estimate = rls.start([0.0f32; 21]);
    let mut late = 0.0f32;
    for (k, (x, y)) in rows.iter().enumerate() {
        let x = x.map(|x| x as f32);
        let error = rls.update(&mut estimate, &x, *y as f32).unwrap();
        if k > 20_000 {
            late = late.max(error.abs());
        }
    }
    assert!(trace(&estimate) <= 1.001e6);
    println!("largest late error {late:e}");
    // The noise is 1e-4, and the plant's own motion about one.
    assert!(late < 2e-3, "{late:e}");
}

#[test]
fn silence_teaches_nothing_and_does_no_harm() {
    let rls = Rls::new(0.99f64, 10.0, 1e3).unwrap();
    let mut estimate = rls.start([0.5, -0.25]);
    for _ in 0..1_000_000 {
        assert_eq!(rls.update(&mut estimate, &[0.0, 0.0], 1.0), Ok(1.0));
    }
    assert_eq!(estimate.parameters(), &[0.5, -0.25]);
    let covariance = estimate.covariance();
    assert!((covariance[0][0] + covariance[1][1] - 1e3).abs() < 1e-9);
    // It still learns.
    for k in 0..2_000 {
        let x = [(k as f64).sin(), (k as f64 * 0.7).cos()];
        rls.update(&mut estimate, &x, 2.0 * x[0] + 3.0 * x[1])
            .unwrap();
    }
    assert!((estimate.parameters()[0] - 2.0).abs() < 1e-6);
    assert!((estimate.parameters()[1] - 3.0).abs() < 1e-6);
}

#[test]
fn samples_that_are_no_numbers_are_turned_away() {
    let rls = Rls::new(0.99f32, 1e3, 1e6).unwrap();
    let mut estimate = rls.start([0.5f32, -0.25]);
    let bad = [
        ([f32::NAN, 1.0], 1.0),
        ([1.0, f32::INFINITY], 1.0),
        ([1.0, 1.0], f32::NAN),
        ([1e30, 1.0], 1.0),
        ([1.0, 1.0], f32::NEG_INFINITY),
    ];
    for (x, y) in bad {
        let before = estimate;
        assert_eq!(
            rls.update(&mut estimate, &x, y),
            Err(SampleError::NotFinite)
        );
        assert_eq!(estimate, before);
    }
    // Large ones that are numbers leave numbers.
    let mut noise = Noise(11);
    for k in 0..100_000 {
        let size = 10f64.powf(18.0 * noise.next());
        let x = [(size * noise.next()) as f32, (size * noise.next()) as f32];
        let _ = rls.update(&mut estimate, &x, (noise.next() * 1e3) as f32);
        assert!(estimate.parameters().iter().all(|p| p.is_finite()), "{k}");
        assert!(
            estimate
                .covariance()
                .iter()
                .flatten()
                .all(|p| p.is_finite()),
            "{k}"
        );
    }
}

#[test]
fn bad_settings_are_refused_by_name() {
    use Field::*;
    use ParameterError::*;
    let refused = |l: f64, p: f64, t: f64| Rls::new(l, p, t).unwrap_err();
    assert_eq!(refused(0.0, 1.0, 1.0), NotPositive(Forgetting));
    assert_eq!(refused(1.1, 1.0, 1.0), TooLarge(Forgetting));
    assert_eq!(refused(f64::NAN, 1.0, 1.0), NotFinite(Forgetting, 0));
    assert_eq!(refused(1.0, -1.0, 1.0), NotPositive(Covariance));
    assert_eq!(refused(1.0, 1.0, 0.0), NotPositive(TraceBound));
    assert_eq!(refused(1.0, 1.0, f64::INFINITY), NotFinite(TraceBound, 0));
}
