//! The effects around the hysteresis: forward steps against closed forms and against a fine
//! integration of the differential equation, inverses against the identity.

use std::f64::consts::TAU;

use hysteron::effect::creep::Creep;
use hysteron::effect::cubic::Cubic;
use hysteron::effect::delay::Delay;
use hysteron::effect::lag::Lag;
use hysteron::effect::quadratic::Quadratic;
use hysteron::effect::resonance::Resonance;
use hysteron::error::{Field, ParameterError};
use proptest::prelude::*;

const H: f64 = 1e-4;

/// A signal joined by lines, as a function of time.
fn joined(samples: &[f64], t: f64) -> f64 {
    let k = ((t / H) as usize).min(samples.len() - 2);
    samples[k] + (samples[k + 1] - samples[k]) * (t / H - k as f64)
}

/// `x' = f(t, x)` by the classical fourth-order method, `fine` steps a sample.
fn integrate<const D: usize>(
    start: [f64; D],
    samples: usize,
    f: impl Fn(f64, [f64; D]) -> [f64; D],
) -> Vec<[f64; D]> {
    const FINE: usize = 40;
    let d = H / FINE as f64;
    let along = |x: [f64; D], k: [f64; D], s: f64| std::array::from_fn(|i| x[i] + s * k[i]);
    let mut x = start;
    let mut out = vec![x];
    for step in 0..(samples - 1) * FINE {
        // A hair inside the step, so that the corner at its end belongs to the next one.
        let t = step as f64 * d;
        let k1 = f(t + 1e-9 * d, x);
        let k2 = f(t + 0.5 * d, along(x, k1, 0.5 * d));
        let k3 = f(t + 0.5 * d, along(x, k2, 0.5 * d));
        let k4 = f(t + (1.0 - 1e-9) * d, along(x, k3, d));
        x = std::array::from_fn(|i| x[i] + d / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        if (step + 1) % FINE == 0 {
            out.push(x);
        }
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn a_lag_is_that_of_its_equation(
        samples in prop::collection::vec(-10.0f64..10.0, 2..60),
        tau in 2e-5f64..1e-2,
    ) {
        let lag = Lag::new(tau, H).unwrap();
        let mut state = lag.start(samples[0]);
        let truth = integrate([samples[0]], samples.len(), |t, [y]| {
            [(joined(&samples, t) - y) / tau]
        });
        for (&x, [y]) in samples.iter().zip(truth) {
            prop_assert!((lag.step(&mut state, x) - y).abs() < 1e-6);
        }
    }

    #[test]
    fn a_mode_is_that_of_its_equation(
        samples in prop::collection::vec(-10.0f64..10.0, 2..60),
        f_n in 50.0f64..1500.0,
        zeta in 0.0f64..0.9,
    ) {
        let mode = Resonance::new(f_n, zeta, H).unwrap();
        let mut state = mode.start(samples[0]);
        let w = TAU * f_n;
        let truth = integrate([samples[0], 0.0], samples.len(), |t, [y, v]| {
            [v, w * w * (joined(&samples, t) - y) - 2.0 * zeta * w * v]
        });
        for (&x, [y, _]) in samples.iter().zip(truth) {
            prop_assert!((mode.step(&mut state, x) - y).abs() < 2e-5);
        }
    }

    #[test]
    fn a_delay_is_exact_for_cubics(
        delay in 0.0f64..29.0,
        c in prop::array::uniform4(-1.0f64..1.0),
    ) {
        let cubic = |t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3]));
        let effect = Delay::<f64, 32>::new(delay * H, H).unwrap();
        let mut state = effect.start(0.0);
        let mut inverse = effect.start_inverse(0.0);
        for k in 0..60 {
            let t = f64::from(k) / 30.0;
            let late = effect.step(&mut state, cubic(t));
            let early = effect.step_inverse(&mut inverse, cubic(t));
            if k > 32 {
                prop_assert!((late - cubic(t - delay / 30.0)).abs() < 1e-9);
                let at = t - effect.latency() as f64 / 30.0;
                prop_assert!((early - cubic(at + delay / 30.0)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn maps_and_their_inverses(w in -20.0f64..20.0, q in -0.01f64..0.01, c in -2e-4f64..2e-4) {
        let quadratic = Quadratic::new(q).unwrap();
        let y = quadratic.step(w);
        prop_assert!((y - (w + q * w * w)).abs() < 1e-12);
        prop_assert!((quadratic.step_inverse(y) - w).abs() < 1e-9);
        // The root in closed form.
        let closed = 2.0 * y / (1.0 + (1.0 + 4.0 * q * y).sqrt());
        prop_assert!((quadratic.step_inverse(y) - closed).abs() < 1e-9);
        let cubic = Cubic::new(c).unwrap();
        prop_assert!((cubic.step_inverse(cubic.step(w)) - w).abs() < 1e-9);
    }

    #[test]
    fn maps_stay_monotone_beyond_their_branch(
        q in -0.2f64..0.2,
        c in -0.05f64..0.05,
        w in prop::collection::vec(-40.0f64..40.0, 2),
    ) {
        let (low, high) = (w[0].min(w[1]), w[0].max(w[1]));
        let (quadratic, cubic) = (Quadratic::new(q).unwrap(), Cubic::new(c).unwrap());
        prop_assert!(quadratic.step(low) <= quadratic.step(high));
        prop_assert!(cubic.step(low) <= cubic.step(high));
    }

    #[test]
    fn creep_is_undone(
        samples in prop::collection::vec(-10.0f64..10.0, 2..100),
        gain in -0.05f64..0.2,
    ) {
        let creep = Creep::<f64, 6>::new(gain, 1e-3, 10.0, H).unwrap();
        let mut forward = creep.start(samples[0]);
        let mut inverse = creep.start(samples[0]);
        for x in samples {
            let y = creep.step(&mut forward, x);
            prop_assert!((creep.step_inverse(&mut inverse, y) - x).abs() < 1e-11);
        }
    }
}

#[test]
fn creep_grows_by_its_gain_a_decade() {
    let creep = Creep::<f64, 6>::new(0.02, 1e-2, 1e2, 1e-3).unwrap();
    let mut state = creep.start(0.0);
    let mut at = Vec::new();
    for k in 1..=30_000u32 {
        let y = creep.step(&mut state, 1.0);
        if [30, 300, 3_000, 30_000].contains(&k) {
            at.push(y);
        }
    }
    // Sum of (1 - exp(-t / tau)) over the decades, in closed form.
    for (y, t) in at.iter().zip([0.03, 0.3, 3.0, 30.0f64]) {
        // The first sample is a ramp, half a sample behind a step.
        let t = t - 0.5e-3;
        let crept: f64 = (-2..=2).map(|d| 1.0 - (-t / 10f64.powi(d)).exp()).sum();
        assert!((y - 1.0 - 0.02 * crept).abs() < 1e-5, "{y} at {t} s");
    }
    assert!((at[2] - at[1] - 0.02).abs() < 0.002);
}

#[test]
fn a_slow_lag_does_not_stand_still_in_single_precision() {
    let creep = Creep::<f32, 6>::new(1.0, 100.0, 100.0, 1e-4).unwrap();
    let mut state = creep.start(0.0);
    let mut y = 0.0;
    for _ in 0..1_000_000 {
        y = creep.step(&mut state, 40.0);
    }
    let truth = 40.0 * (2.0 - (-1.0f64).exp());
    assert!((f64::from(y) - truth).abs() < 1e-3, "{y}, {truth}");
}

#[test]
fn inverses_with_derivatives_on_a_sine() {
    let w = TAU * 110.0;
    let h = 2e-4;
    let sine = |k: f64| (w * h * k).sin();
    let mode = Resonance::new(74.0, 0.02, h).unwrap();
    let lag = Lag::new(5e-4, h).unwrap();
    let mut mode_state = mode.start_inverse(0.0);
    let mut lag_state = lag.start_inverse(0.0);
    let (w_n, zeta, tau) = (TAU * 74.0, 0.02, 5e-4);
    for k in 0..200 {
        let t = f64::from(k) - 2.0;
        let x = mode.step_inverse(&mut mode_state, sine(f64::from(k)));
        let cosine = (w * h * t).cos();
        let u = lag.step_inverse(&mut lag_state, sine(f64::from(k)));
        if k >= 6 {
            let truth = sine(t) * (1.0 - w * w / (w_n * w_n)) + 2.0 * zeta * w / w_n * cosine;
            assert!((x - truth).abs() < 2e-5, "{x} {truth}");
            assert!((u - sine(t) - tau * w * cosine).abs() < 1e-5);
        }
    }
}

#[test]
fn parameters_are_refused_by_name() {
    assert_eq!(
        Lag::new(-1.0, H).unwrap_err(),
        ParameterError::Negative(Field::TimeConstant)
    );
    assert_eq!(
        Lag::new(f32::NAN, 1e-4).unwrap_err(),
        ParameterError::NotFinite(Field::TimeConstant, 0)
    );
    assert_eq!(
        Lag::new(1.0, 0.0).unwrap_err(),
        ParameterError::NotPositive(Field::SampleTime)
    );
    assert_eq!(
        Delay::<f64, 32>::new(30.0 * H, H).unwrap_err(),
        ParameterError::TooLarge(Field::Delay)
    );
    assert_eq!(
        Resonance::new(6e3, 0.1, H).unwrap_err(),
        ParameterError::TooLarge(Field::NaturalFrequency)
    );
    assert_eq!(
        Resonance::new(60.0, 1.0, H).unwrap_err(),
        ParameterError::TooLarge(Field::DampingRatio)
    );
    assert_eq!(
        Creep::<f64, 2>::new(0.1, 1.0, 100.0, H).unwrap_err(),
        ParameterError::TooLarge(Field::CreepLongest)
    );
    assert_eq!(
        Creep::<f64, 2>::new(-3.0, 1e-5, 1e-5, H).unwrap_err(),
        ParameterError::TooSmall(Field::CreepGain)
    );
}
