//! The rate-dependent Prandtl-Ishlinskii model and its inverse against published figures and
//! against the identity.

use hysteron::error::{Field, ParameterError, SampleError};
use hysteron::hysteresis::{Parameters, RateDependentPi};
use hysteron::math::Real;
use hysteron::model::Model;
use proptest::prelude::*;

const N: usize = 8;

/// Weights with positive partial sums but single ones of either sign, thresholds, beta.
fn model_strategy() -> impl Strategy<Value = (Vec<f64>, Vec<f64>, f64)> {
    (
        prop::collection::vec((0.3f64..2.0, 0.5f64..5.0), 1..=N),
        0.3f64..2.0,
        prop_oneof![Just(0.0), 1e-5f64..1e-2],
    )
        .prop_map(|(rows, a_0, beta)| {
            let mut weights = vec![a_0];
            let (mut sum, mut threshold) = (a_0, 0.0);
            let mut thresholds = Vec::new();
            for (partial_sum, gap) in rows {
                weights.push(partial_sum - sum);
                sum = partial_sum;
                threshold += gap;
                thresholds.push(threshold);
            }
            (weights, thresholds, beta)
        })
}

/// Distances `u(0) - z_i(0)` within what (J 8) allows, for shares in -1..1.
fn outputs_at<T: Real>(first: T, thresholds: &[T], shares: &[f64]) -> Vec<T> {
    let (mut x, mut before) = (T::ZERO, T::ZERO);
    thresholds
        .iter()
        .zip(shares)
        .map(|(&r, &share)| {
            x = x + T::from_f64(share) * (r - before);
            before = r;
            first - x
        })
        .collect()
}

fn to<T: Real>(values: &[f64]) -> Vec<T> {
    values.iter().map(|&v| T::from_f64(v)).collect()
}

/// Largest error of inverse after model over the largest input, from the given initial state and
/// with the same given rates on both sides.
fn round_trip_error<T: Real>(
    model: (&[f64], &[f64], f64),
    shares: &[f64],
    first: f64,
    samples: &[(f64, f64)],
) -> f64 {
    let (weights, thresholds) = (to::<T>(model.0), to::<T>(model.1));
    let forward = Parameters {
        weights: &weights,
        thresholds: &thresholds,
        beta: T::from_f64(model.2),
    }
    .build::<N>(T::from_f64(1e-4))
    .unwrap();
    let inverse = forward.inverse().unwrap();
    let first = T::from_f64(first);
    let z = outputs_at(first, &thresholds, shares);
    let (v, d) = forward.inverse_start(first, &z).unwrap();
    let mut state = forward.start_from(first, &z).unwrap();
    let mut inverse_state = inverse.start_from(v, &d[..thresholds.len()]).unwrap();
    let mut largest = 0.0f64;
    for &(u, rate) in samples {
        let (u, rate) = (T::from_f64(u), T::from_f64(rate));
        let v = forward.step_with_rate(&mut state, u, rate);
        let back = inverse.step_with_rate(&mut inverse_state, v, rate);
        largest = largest.max((back - u).abs().to_f64());
    }
    largest / 50.0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn inverse_after_model_is_the_identity(
        (weights, thresholds, beta) in model_strategy(),
        shares in prop::collection::vec(-1.0f64..=1.0, N),
        first in -30.0f64..30.0,
        samples in prop::collection::vec((-50.0f64..50.0, 0.0f64..3e4), 1..100),
    ) {
        let model = (&weights[..], &thresholds[..], beta);
        // At the first sample after the start the rate may already be anything.
        let error = round_trip_error::<f64>(model, &shares, first, &samples);
        prop_assert!(error * 50.0 <= 1e-9, "f64: {error:e}");
        let error = round_trip_error::<f32>(model, &shares, first, &samples);
        prop_assert!(error <= 1e-4, "f32: {error:e}");
    }

    #[test]
    fn the_inverse_of_the_inverse_is_the_model((weights, thresholds, beta) in model_strategy()) {
        let model = Parameters { weights: &weights, thresholds: &thresholds, beta }
            .build::<N>(1e-4)
            .unwrap();
        let back = model.inverse().unwrap().inverse().unwrap();
        prop_assert!((back.weight_0() - model.weight_0()).abs() < 1e-12);
        prop_assert!((back.beta() - model.beta()).abs() < 1e-12);
        for (a, b) in back.bank().weights().iter().zip(model.bank().weights()) {
            prop_assert!((a - b).abs() < 1e-11);
        }
        for (a, b) in back.bank().thresholds().iter().zip(model.bank().thresholds()) {
            prop_assert!((a - b).abs() < 1e-10);
        }
    }

    #[test]
    fn without_beta_repeated_samples_change_nothing(
        (weights, thresholds, _) in model_strategy(),
        samples in prop::collection::vec((-50.0f64..50.0, 1usize..4), 1..100),
    ) {
        let model =
            Parameters { weights: &weights, thresholds: &thresholds, beta: 0.0 }.build::<N>(1e-4).unwrap();
        let (mut once, mut often) = (model.start(0.0), model.start(0.0));
        for (u, times) in samples {
            let a = model.step(&mut once, u);
            let b = (0..times).map(|_| model.step(&mut often, u)).last().unwrap();
            prop_assert_eq!(a, b);
        }
    }

    #[test]
    fn the_compensator_turns_bad_samples_away(
        before in prop::collection::vec(-40.0f64..40.0, 0..20),
        after in prop::collection::vec(-40.0f64..40.0, 1..20),
        bad in prop_oneof![Just(f64::NAN), Just(f64::INFINITY), Just(f64::NEG_INFINITY)],
    ) {
        let compensator = Model::<f64, 3, 1>::new(p753(), None, 1.0, 0.0).unwrap().compensator().unwrap();
        let mut state = compensator.start(0.0).unwrap();
        let mut untouched = compensator.start(0.0).unwrap();
        for &v in &before {
            prop_assert_eq!(compensator.step(&mut state, v), compensator.step(&mut untouched, v));
        }
        prop_assert_eq!(compensator.step(&mut state, bad), Err(SampleError::NotFinite));
        for &v in &after {
            prop_assert_eq!(compensator.step(&mut state, v), compensator.step(&mut untouched, v));
        }
    }
}

fn p753<const N: usize>() -> RateDependentPi<f64, N> {
    Parameters {
        weights: &[0.7236, 0.2906, 0.0416, 0.1512],
        thresholds: &[9.715, 2.0 * 9.715, 3.0 * 9.715],
        beta: 8.572e-4,
    }
    .build(1e-4)
    .unwrap()
}

/// The inverse that paper J prints (section V), but for its b_0, which contradicts the rest.
#[test]
fn published_inverse_constants() {
    let inverse = p753::<3>().inverse().unwrap();
    let close = |a: f64, b: f64, tolerance: f64| assert!((a - b).abs() <= tolerance, "{a} {b}");
    close(inverse.weight_0(), 1.3820, 5e-5);
    for (b, printed) in inverse
        .bank()
        .weights()
        .iter()
        .zip([-0.3961, -0.038, -0.1187])
    {
        close(*b, printed, 1e-3);
    }
    for (s, printed) in inverse
        .bank()
        .thresholds()
        .iter()
        .zip([7.0293, 16.8823, 27.1395])
    {
        close(*s, printed, 1.5e-3);
    }
    close(inverse.beta(), 6.2024e-4, 1.5e-7);
}

/// (J 16) prints y_1 = a_1 x_1. Started from that, the inverse is wrong by micrometres.
#[test]
fn the_printed_initial_state_fails() {
    let model = p753::<3>();
    let inverse = model.inverse().unwrap();
    let (first, x) = (0.0, [9.715, 12.0, 15.0]);
    let z = x.map(|x| first - x);
    let (v, corrected) = model.inverse_start(first, &z).unwrap();
    let y_1_correction = (0.2906 - 0.7236) * x[0]; // a_1 x_1 in place of a_0 x_1
    let printed = corrected.map(|d| d - y_1_correction);
    let largest_error = |d: &[f64]| {
        let mut state = model.start_from(first, &z).unwrap();
        // What is printed need not even be admissible; the plain bank takes it as it stands.
        let mut inverse_state = inverse.start_from(v, d).unwrap();
        (0..400)
            .map(|k| {
                let u = 8.0 * (k as f64 * 0.05).sin();
                let v = model.step_with_rate(&mut state, u, 0.0);
                (inverse.step_with_rate(&mut inverse_state, v, 0.0) - u).abs()
            })
            .fold(0.0, f64::max)
    };
    assert!(largest_error(&corrected) < 1e-12);
    assert!(largest_error(&printed) > 0.5, "{}", largest_error(&printed));
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let build = |weights: &[f64], thresholds: &[f64], beta: f64, h: f64| {
        Parameters {
            weights,
            thresholds,
            beta,
        }
        .build::<3>(h)
        .unwrap_err()
    };
    use Field::*;
    use ParameterError::*;
    let (w, r, b, h) = (&[0.5, 0.2, 0.1][..], &[1.0, 2.0][..], 1e-4, 1e-4);
    assert_eq!(build(&[0.5, f64::NAN, 0.1], r, b, h), NotFinite(Weights, 1));
    assert_eq!(build(&[0.5, -0.7, 0.9], r, b, h), PartialSum(Weights, 1));
    assert_eq!(build(&[0.0, 0.7, 0.9], r, b, h), PartialSum(Weights, 0));
    assert_eq!(build(&[0.5, 0.2], r, b, h), Length(Weights));
    assert_eq!(build(&[], &[], b, h), Length(Weights));
    assert_eq!(build(&[1.0], &[], b, h), Length(Thresholds));
    assert_eq!(
        build(&[0.1; 5], &[1.0, 2.0, 3.0, 4.0], b, h),
        Length(Thresholds)
    );
    assert_eq!(
        build(w, &[1.0, f64::INFINITY], b, h),
        NotFinite(Thresholds, 1)
    );
    assert_eq!(build(w, &[2.0, 2.0], b, h), NotIncreasing(Thresholds, 1));
    assert_eq!(build(w, &[0.0, 2.0], b, h), NotIncreasing(Thresholds, 0));
    assert_eq!(build(w, r, -1e-9, h), ShrinkingGap(Beta));
    assert_eq!(build(w, r, f64::NAN, h), NotFinite(Beta, 0));
    assert_eq!(build(w, r, b, 0.0), NotPositive(SampleTime));
    assert_eq!(build(w, r, b, f64::NAN), NotFinite(SampleTime, 0));
    let model = |gain, offset| Model::<f64, 3, 1>::new(p753(), None, gain, offset).unwrap_err();
    assert_eq!(model(0.0, 0.0), Zero(Gain));
    assert_eq!(model(f64::NAN, 0.0), NotFinite(Gain, 0));
    assert_eq!(model(1.0, f64::NAN), NotFinite(Offset, 0));
    assert_eq!(
        p753::<3>().start_from(0.0, &[0.0, 0.0]).unwrap_err(),
        Length(InitialState)
    );
    assert_eq!(
        p753::<3>().start_from(0.0, &[0.0, 10.0, 0.0]).unwrap_err(),
        Inadmissible(1)
    );
}
