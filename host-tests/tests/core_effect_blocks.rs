//! Limits, rate law, congruency, backlash, interleaving and what the sensor adds: against closed forms
//! and against the equations written out.

use hysteron::chain::{Chain, Effects};
use hysteron::effect::backlash::{Backlash, TURN};
use hysteron::effect::congruency::Congruency;
use hysteron::effect::drift::Drift;
use hysteron::effect::interleaving::Interleaving;
use hysteron::effect::lag::Lag;
use hysteron::effect::mains_hum::{Line, MainsHum};
use hysteron::effect::quantisation::Quantisation;
use hysteron::effect::rate_power::RatePower;
use hysteron::effect::saturation::Saturation;
use hysteron::effect::slew_limit::SlewLimit;
use hysteron::error::{Field, ParameterError};
use hysteron::hysteresis::{Parameters, RateDependentPi};
use hysteron::model::Model;
use proptest::prelude::*;

const H: f64 = 1e-4;
const WEIGHTS: [f64; 4] = [0.8, 0.2, 0.1, 0.15];
const THRESHOLDS: [f64; 3] = [4.0, 9.0, 15.0];

fn operator(beta: f64) -> RateDependentPi<f64, 3> {
    let parameters = Parameters {
        weights: &WEIGHTS,
        thresholds: &THRESHOLDS,
        beta,
    };
    parameters.build(H).unwrap()
}

fn chain(beta: f64, gain: f64, offset: f64, effects: Effects<f64>) -> Chain<f64, 3, 1> {
    Chain::new(
        Model::new(operator(beta), None, gain, offset).unwrap(),
        effects,
    )
}

/// A drive that moves by bounded steps, from zero.
fn drive() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-3.0f64..3.0, 2..200).prop_map(|steps| {
        let mut u = 0.0f64;
        let along = steps.into_iter().map(|step| {
            u = (u + step).clamp(-30.0, 30.0);
            u
        });
        std::iter::once(0.0).chain(along).collect()
    })
}

/// The play of the text books, its threshold moving: (J 4) with (J 19).
fn play_of(z: f64, u: f64, r: f64) -> f64 {
    (u - r).max((u + r).min(z))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(50))]

    #[test]
    fn a_rate_law_moves_the_thresholds(u in drive(), p in 0.2f64..3.0) {
        // As wide as the narrowest threshold at the largest rate.
        let beta = 4.0 / (3.0 / H).powf(p);
        let law = RatePower::new(p).unwrap();
        let chain = chain(beta, 1.0, 0.0, Effects { rate_law: Some(law), ..Effects::default() });
        let mut state = chain.start(0.0);
        let (mut z, mut before) = ([0.0; 3], 0.0);
        for u in u {
            let rate = ((u - before) / H).abs();
            before = u;
            let mut w = WEIGHTS[0] * u;
            for i in 0..3 {
                z[i] = play_of(z[i], u, THRESHOLDS[i] + beta * rate.powf(p));
                w += WEIGHTS[i + 1] * z[i];
            }
            prop_assert!((chain.step(&mut state, u) - w).abs() < 1e-9);
        }
    }

    /// The analytic inverse at the rate of the reference, for a plant at that same rate.
    #[test]
    fn a_rate_law_has_the_analytic_inverse(w in drive(), p in 0.2f64..3.0) {
        let beta = 4.0 / (3.0 / H).powf(p);
        let law = RatePower::new(p).unwrap();
        let (model, inverse) = (operator(beta), operator(beta).inverse().unwrap());
        let (mut forward, mut backward) = (model.start(0.0), inverse.start(0.0));
        for w in w {
            let rate = law.step((w - backward.previous()) / H);
            let u = inverse.step_with_rate(&mut backward, w, rate);
            prop_assert!((model.step_with_rate(&mut forward, u, rate) - w).abs() < 1e-9);
        }
    }

    #[test]
    fn congruency_is_its_equation_and_is_undone(
        u in drive(),
        kappa in -0.012f64..0.012,
        gain in prop_oneof![-1.5f64..-0.5, 0.5f64..1.5],
        half_width in 0.0f64..2.0,
    ) {
        let congruency = Congruency::new(kappa, gain).unwrap();
        let operator = operator(0.0);
        congruency.check(&operator).unwrap();
        let chain = chain(0.0, gain, 0.5, Effects { congruency: Some(congruency), ..Effects::default() });
        let mut state = chain.start(0.0);
        let (mut z, mut open, mut solved) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for u in u {
            let sum = |z: &mut [f64; 3], half_width: f64| -> f64 {
                (0..3).map(|i| {
                    z[i] = play_of(z[i], u, THRESHOLDS[i] + half_width);
                    WEIGHTS[i + 1] * z[i]
                }).sum()
            };
            // y = a_0 u + (1 + kappa y) Z with the displacement y less its offset over the gain.
            let plays = sum(&mut z, 0.0);
            let y = chain.step(&mut state, u) - 0.5;
            let left = y / gain - WEIGHTS[0] * u - (1.0 + kappa * y) * plays;
            prop_assert!(left.abs() < 1e-9, "{}", left);
            // An envelope that opens, in both directions.
            let w = congruency.step(WEIGHTS[0] * u, sum(&mut open, half_width));
            let found = congruency.step_inverse(&operator, &mut solved, w, half_width);
            prop_assert!((found - u).abs() < 1e-9, "{} {}", found, u);
        }
    }

    /// Far beyond the law, too, it rises with the drive.
    #[test]
    fn congruency_stays_monotone(
        kappa in -0.5f64..0.5,
        low in -60.0f64..60.0,
        step in 0.0f64..30.0,
        z in -40.0f64..40.0,
    ) {
        let congruency = Congruency::new(kappa, 1.0).unwrap();
        let w = |u: f64| congruency.step(0.8 * u, 0.4 * play_of(z, u, 4.0));
        prop_assert!(w(low) <= w(low + step) + 1e-9);
    }

    #[test]
    fn backlash_is_undone_to_a_share_of_its_width(y in drive(), width in 0.0f64..4.0) {
        let gap = Backlash::new(width).unwrap();
        let (mut forward, mut backward) = (gap.start(y[0]), gap.start_inverse(y[0]));
        for y in y {
            let w = gap.step_inverse(&mut backward, y);
            prop_assert!((gap.step(&mut forward, w) - y).abs() <= TURN * width + 1e-12);
        }
    }

    /// Rounding is no turn: a rest with noise far below the width leaves the inverse where it is.
    #[test]
    fn backlash_does_not_chatter(noise in prop::collection::vec(-1e-4f64..1e-4, 50)) {
        let gap = Backlash::new(0.5).unwrap();
        let mut state = gap.start_inverse(0.0);
        let turned = gap.step_inverse(&mut state, 3.0);
        prop_assert_eq!(turned, 3.25);
        for e in noise {
            prop_assert!((gap.step_inverse(&mut state, 3.0 + e) - turned).abs() < 2.1e-4);
        }
    }

    #[test]
    fn interleaving_is_its_equation_and_is_undone(
        x in drive(),
        u in drive(),
        g in -0.03f64..0.03,
    ) {
        let product = Interleaving::new(g).unwrap();
        let mut forward = product.start(0.0, 0.0);
        let mut backward = product.start_inverse(0.0, 0.0);
        let mut before = 0.0;
        for (x, u) in x.into_iter().zip(u) {
            let y = product.step(&mut forward, x, u);
            prop_assert!((y - x - before).abs() < 1e-12);
            before = g * y * u;
            prop_assert!((product.step_inverse(&backward, y) - x).abs() < 1e-12);
            product.drove(&mut backward, y, u);
        }
    }

    #[test]
    fn quantisation_is_the_nearest_step(x in -100.0f64..100.0, q in 1e-3f64..2.0) {
        let y = Quantisation::new(q).unwrap().step(x);
        prop_assert!((y - x).abs() <= 0.5 * q * (1.0 + 1e-9));
        prop_assert!((y / q - (y / q).round()).abs() < 1e-9);
    }
}

#[test]
fn limits_of_the_amplifier() {
    let saturation = Saturation::new(5.0).unwrap();
    assert_eq!(
        [-7.0, -5.0, 3.0, 5.5].map(|u| saturation.step(u)),
        [-5.0, -5.0, 3.0, 5.0]
    );
    // 1 V in a sample towards a step of 2.5 V, which it then keeps; back past it at once.
    let slew = SlewLimit::new(1e4, H).unwrap();
    let mut state = slew.start(0.0);
    let out = [2.5, 2.5, 2.5, 2.5, 2.0, -4.0].map(|u| slew.step(&mut state, u));
    assert_eq!(out, [1.0, 2.0, 2.5, 2.5, 2.0, 1.0]);
}

#[test]
fn backlash_under_a_triangle() {
    let (width, top) = (1.0, 4.0);
    let gap = Backlash::new(width).unwrap();
    let mut state = gap.start(0.0);
    for k in 0..=400 {
        // Up to the top and back to zero.
        let w = top - (f64::from(k) / 50.0 - top).abs();
        let y = gap.step(&mut state, w);
        let truth: f64 = if k <= 200 {
            (w - width / 2.0).max(0.0)
        } else {
            (top - width / 2.0).min(w + width / 2.0)
        };
        assert!((y - truth).abs() < 1e-12, "{y} {truth}");
    }
}

#[test]
fn interleaving_settles_on_a_geometric_series() {
    let product = Interleaving::new(0.02f64).unwrap();
    let mut state = product.start(0.0, 0.0);
    let mut y = 0.0;
    for _ in 0..200 {
        y = product.step(&mut state, 3.0, 10.0);
    }
    assert!((y - 3.0 / (1.0 - 0.2)).abs() < 1e-12);
    // At rest there already.
    let mut rest = product.start(3.0, 10.0);
    assert!((product.step(&mut rest, 3.0, 10.0) - y).abs() < 1e-12);
    // A factor beyond one would grow without bound.
    let mut wild = product.start(0.0, 0.0);
    let last = (0..10_000)
        .map(|_| product.step(&mut wild, 1.0, 1e3))
        .last();
    assert!(last.unwrap() <= 1.0 / (1.0 - 0.95) + 1e-9);
}

#[test]
fn drift_and_hum_follow_the_clock() {
    let drift = Drift::new(2.0, 50.0).unwrap();
    assert_eq!(drift.at(0.0), 0.0);
    assert!((drift.at(50.0) - 2.0 * (1.0 - (-1.0f64).exp())).abs() < 1e-12);
    // A line of 3e-3 um/s.
    let line = Drift::new(3e9f64, 1e12).unwrap();
    assert!((line.at(1e3) - 3.0).abs() < 1e-6);
    let first = Line {
        amplitude: 0.3,
        phase: 0.0,
    };
    let third = Line {
        amplitude: 0.1,
        phase: 0.5,
    };
    let hum = MainsHum::new(50.0, first, third).unwrap();
    // A quarter of a turn of the line is three of the third, after a day, too.
    let truth = 0.3 - 0.1 * 0.5f64.cos();
    for day in [0.0, 86_400.0] {
        assert!(
            (hum.at(day + 0.005) - truth).abs() < 1e-8,
            "{}",
            hum.at(day + 0.005)
        );
    }
}

/// Effects without memory one after the other, written out: their order and their units.
#[test]
fn the_chain_keeps_its_order() {
    let line = |amplitude| Line {
        amplitude,
        phase: 1.0,
    };
    let effects = Effects {
        saturation: Some(Saturation::new(8.0).unwrap()),
        slew_limit: Some(SlewLimit::new(3e4, H).unwrap()),
        congruency: Some(Congruency::new(5e-3, 2.0).unwrap()),
        backlash: Some(Backlash::new(0.6).unwrap()),
        interleaving: Some(Interleaving::new(4e-3).unwrap()),
        sensor_lag: Some(Lag::new(2e-4, H).unwrap()),
        drift: Some(Drift::new(0.7, 1e-2).unwrap()),
        mains_hum: Some(MainsHum::new(60.0, line(0.2), line(0.1)).unwrap()),
        quantisation: Some(Quantisation::new(0.05).unwrap()),
        ..Effects::default()
    };
    let (gain, offset, began) = (2.0, 3.0, 12.5);
    let chain = chain(0.0, gain, offset, effects);
    let mut state = chain.start(0.0);
    state.set_time(began);
    let (mut slewed, mut z, mut gap, mut product) = (0.0f64, [0.0; 3], 0.0f64, 0.0);
    let e = (-0.5f64).exp();
    let (mut sensor, mut before) = (offset, offset);
    for k in 0..300 {
        let t = f64::from(k) * H;
        let u = 12.0 * (2.0 * std::f64::consts::PI * 80.0 * t).sin();
        slewed += (u.clamp(-8.0, 8.0) - slewed).clamp(-3.0, 3.0);
        let mut plays = 0.0;
        for i in 0..3 {
            z[i] = play_of(z[i], slewed, THRESHOLDS[i]);
            plays += WEIGHTS[i + 1] * z[i];
        }
        let w = (WEIGHTS[0] * slewed + plays) / (1.0 - 5e-3 * gain * plays);
        gap = gap.clamp(w - 0.3, w + 0.3);
        let x = gain * gap + product;
        // The drive as commanded, beyond the limits.
        product = 4e-3 * x * u;
        let y = x + offset;
        // Exact for a line from sample to sample: tau = 2 h.
        sensor += (1.0 - e) * (before - sensor) + (1.0 - 2.0 * (1.0 - e)) * (y - before);
        before = y;
        let clock = began + t;
        let angle = 2.0 * std::f64::consts::PI * 60.0 * clock;
        let hum = 0.2 * (angle + 1.0).sin() + 0.1 * (3.0 * angle + 1.0).sin();
        let shown = sensor + 0.7 * (1.0 - (-clock / 1e-2).exp()) + hum;
        let found = chain.step(&mut state, u);
        // Half a step, where rounding decides between two of them.
        assert!(
            (found - shown).abs() <= 0.025 + 1e-9,
            "{k}: {found} {shown}"
        );
        assert!((found / 0.05 - (found / 0.05).round()).abs() < 1e-9);
    }
}

#[test]
fn parameters_are_refused_by_name() {
    use ParameterError::{Negative, NotFinite, NotPositive, TooLarge};
    let nan = f64::NAN;
    let line = |amplitude, phase| Line { amplitude, phase };
    let refused = [
        (
            Saturation::new(0.0).err(),
            NotPositive(Field::SaturationLimit),
        ),
        (SlewLimit::new(-1.0, H).err(), NotPositive(Field::SlewLimit)),
        (
            SlewLimit::new(1.0, 0.0).err(),
            NotPositive(Field::SampleTime),
        ),
        (RatePower::new(0.0).err(), NotPositive(Field::Exponent)),
        (RatePower::new(4.1).err(), TooLarge(Field::Exponent)),
        (Congruency::new(nan, 1.0).err(), NotFinite(Field::Kappa, 0)),
        (Backlash::new(-1.0).err(), Negative(Field::Width)),
        (
            Interleaving::new(nan).err(),
            NotFinite(Field::InterleavingGain, 0),
        ),
        (Drift::new(1.0, 0.0).err(), NotPositive(Field::TimeConstant)),
        (Drift::new(nan, 1.0).err(), NotFinite(Field::Amplitude, 0)),
        (
            MainsHum::new(0.0, line(1.0, 0.0), line(0.0, 0.0)).err(),
            NotPositive(Field::Frequency),
        ),
        (
            MainsHum::new(50.0, line(1.0, nan), line(0.0, 0.0)).err(),
            NotFinite(Field::Phase, 0),
        ),
        (
            MainsHum::new(50.0, line(1.0, 0.0), line(nan, 0.0)).err(),
            NotFinite(Field::ThirdAmplitude, 0),
        ),
        (Quantisation::new(0.0).err(), NotPositive(Field::Step)),
    ];
    for (found, expected) in refused {
        assert_eq!(found, Some(expected));
    }
}
