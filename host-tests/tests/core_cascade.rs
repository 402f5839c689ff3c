//! Chain and cascade: every combination of the effects that have an inverse is undone.

use std::f64::consts::TAU;

use hysteron::cascade::Cascade;
use hysteron::chain::{Chain, DELAY_SPAN, Effects};
use hysteron::effect::asymmetry::{Asymmetry, Side};
use hysteron::effect::backlash::Backlash;
use hysteron::effect::congruency::Congruency;
use hysteron::effect::creep::Creep;
use hysteron::effect::cubic::Cubic;
use hysteron::effect::delay::Delay;
use hysteron::effect::interleaving::Interleaving;
use hysteron::effect::lag::Lag;
use hysteron::effect::quadratic::Quadratic;
use hysteron::effect::rate_power::RatePower;
use hysteron::effect::resonance::Resonance;
use hysteron::hysteresis::{Parameters, RateDependentPi};
use hysteron::model::Model;

const H: f64 = 1e-4;
const GAIN: f64 = 0.9;
const OFFSET: f64 = 2.0;
const WIDTH: f64 = 0.5;

/// A smooth reference: starts and stops at rest, with all derivatives that a mode asks for.
fn reference(samples: usize) -> Vec<f64> {
    (0..samples)
        .map(|k| {
            let t = k as f64 / samples as f64;
            let window = (TAU * t / 2.0).sin().powi(4);
            30.0 * window * ((TAU * 2.0 * t).sin() + 0.3 * (TAU * 5.0 * t).cos())
        })
        .collect()
}

fn operator(beta: f64) -> RateDependentPi<f64, 3> {
    Parameters {
        weights: &[0.8, 0.2, 0.1, 0.15],
        thresholds: &[4.0, 9.0, 15.0],
        beta,
    }
    .build(H)
    .unwrap()
}

fn asymmetry() -> Asymmetry<f64, 2> {
    Asymmetry::new(
        Side {
            slopes: &[1.0, -0.1],
            thresholds: &[5.0],
        },
        Side {
            slopes: &[1.05, 0.1],
            thresholds: &[7.0],
        },
    )
    .unwrap()
}

/// Bits of a combination.
const LAG: u32 = 1;
const DELAY: u32 = 1 << 1;
const QUADRATIC: u32 = 1 << 2;
const CUBIC: u32 = 1 << 3;
const MODE: u32 = 1 << 4;
const CREEP: u32 = 1 << 5;
const ASYMMETRY: u32 = 1 << 6;
const OUTPUT_QUADRATIC: u32 = 1 << 7;
const CONGRUENCY: u32 = 1 << 8;
const BACKLASH: u32 = 1 << 9;
const INTERLEAVING: u32 = 1 << 10;
const RATE_LAW: u32 = 1 << 11;
const COMBINATIONS: u32 = 1 << 12;

fn chain(choice: u32) -> Chain<f64, 3, 2> {
    let chosen = |bit: u32| choice & bit != 0;
    let effects = Effects {
        amplifier_lag: chosen(LAG).then(|| Lag::new(3e-4, H).unwrap()),
        transport_delay: chosen(DELAY).then(|| Delay::<f64, DELAY_SPAN>::new(3.7e-4, H).unwrap()),
        rate_law: chosen(RATE_LAW).then(|| RatePower::new(0.5).unwrap()),
        congruency: chosen(CONGRUENCY).then(|| Congruency::new(4e-3, GAIN).unwrap()),
        quadratic: chosen(QUADRATIC).then(|| Quadratic::new(2e-3).unwrap()),
        cubic: chosen(CUBIC).then(|| Cubic::new(-3e-5).unwrap()),
        backlash: chosen(BACKLASH).then(|| Backlash::new(WIDTH).unwrap()),
        resonances: [
            chosen(MODE).then(|| Resonance::new(310.0, 0.03, H).unwrap()),
            None,
            None,
        ],
        creep: chosen(CREEP).then(|| Creep::new(0.02, 1e-2, 10.0, H).unwrap()),
        output_quadratic: chosen(OUTPUT_QUADRATIC).then(|| Quadratic::new(-1e-3).unwrap()),
        interleaving: chosen(INTERLEAVING).then(|| Interleaving::new(2e-3).unwrap()),
        ..Effects::default()
    };
    let beta = if chosen(RATE_LAW) { 5e-3 } else { 0.0 };
    let map = chosen(ASYMMETRY).then(asymmetry);
    Chain::new(
        Model::new(operator(beta), map, GAIN, OFFSET).unwrap(),
        effects,
    )
}

/// Largest and rms error in um of a chain that follows the reference by the cascade of `known`.
fn errors(chain: &Chain<f64, 3, 2>, known: &Chain<f64, 3, 2>, reference: &[f64]) -> (f64, f64) {
    let cascade = Cascade::<f64, 3, 2, 2, true>::new(known, None).unwrap();
    let latency = cascade.latency();
    let mut state = cascade.start(OFFSET).unwrap();
    // Applied as it comes: a reference sample is reached `latency` samples after it went in, the
    // samples of its own delay among them.
    let mut plant = chain.start(0.0);
    let (mut worst, mut squares) = (0.0f64, 0.0);
    for (k, v) in reference.iter().enumerate() {
        let drive = cascade.step(&mut state, OFFSET + v).unwrap();
        let y = chain.step(&mut plant, drive);
        if k >= latency {
            let error = y - OFFSET - reference[k - latency];
            worst = worst.max(error.abs());
            squares += error * error;
        }
    }
    (worst, (squares / reference.len() as f64).sqrt())
}

/// What may be left in um: nothing where every inverse is exact.
fn allowed(choice: u32) -> f64 {
    let chosen = |bits: u32| choice & bits != 0;
    let ahead = chosen(LAG | DELAY | MODE);
    let mut allowed = 1e-10;
    if ahead {
        // Corners of the inverse hysteresis, seen by derivatives from five samples.
        allowed += 0.01;
    }
    if chosen(RATE_LAW) {
        // The plant sees the rate of its own drive.
        allowed += 0.03;
    }
    if chosen(BACKLASH) {
        // It waits at a turn; the leap that follows is a corner of its own.
        allowed += GAIN * WIDTH / if ahead { 8.0 } else { 128.0 };
    }
    if chosen(INTERLEAVING) && ahead {
        // The static gain in place of the drive: the share of the hysteresis in it.
        allowed += 0.5;
    }
    allowed
}

#[test]
fn every_combination_of_effects_is_undone() {
    let reference = reference(2_000);
    let mut found: std::collections::BTreeMap<u64, (u32, f64)> = Default::default();
    for choice in 0..COMBINATIONS {
        let (worst, _) = errors(&chain(choice), &chain(choice), &reference);
        let allowed = allowed(choice);
        assert!(worst < allowed, "combination {choice:#014b}: {worst} um");
        let at = found.entry(allowed.to_bits()).or_default();
        *at = (at.0 + 1, at.1.max(worst));
    }
    for (allowed, (count, worst)) in found {
        let allowed = f64::from_bits(allowed);
        println!("{count:4} combinations: at most {worst:.1e} um, allowed {allowed:.1e} um");
    }
}

#[test]
fn each_effect_alone_needs_its_inverse() {
    let reference = reference(2_000);
    let of = |choice| {
        // That of a rate law has no rate term at all.
        errors(&chain(choice), &chain(0), &reference).1
    };
    for bit in (0..12).map(|bit| 1 << bit) {
        let (left, with) = (of(bit), errors(&chain(bit), &chain(bit), &reference).1);
        println!("{bit:#014b}: rms {left:.2e} um without its inverse, {with:.1e} um with it");
        assert!(left > 0.03 && left > 8.0 * with, "{bit:#b}: {left}, {with}");
    }
}

#[test]
fn what_has_no_inverse_is_passed_over() {
    use hysteron::effect::drift::Drift;
    use hysteron::effect::quantisation::Quantisation;
    use hysteron::effect::saturation::Saturation;
    use hysteron::effect::slew_limit::SlewLimit;
    let plain = chain(QUADRATIC);
    let effects = Effects {
        saturation: Some(Saturation::new(60.0).unwrap()),
        slew_limit: Some(SlewLimit::new(1e5, H).unwrap()),
        sensor_lag: Some(Lag::new(3e-4, H).unwrap()),
        drift: Some(Drift::new(1.0, 0.1).unwrap()),
        quantisation: Some(Quantisation::new(0.01).unwrap()),
        ..*plain.effects()
    };
    let with = Chain::new(*plain.model(), effects);
    let cascades =
        [&plain, &with].map(|chain| Cascade::<f64, 3, 2, 2, true>::new(chain, None).unwrap());
    assert_eq!(cascades[1].latency(), 0);
    let mut states = [0, 1].map(|i| cascades[i].start(OFFSET).unwrap());
    for v in reference(500) {
        let drives = [0, 1].map(|i| cascades[i].step(&mut states[i], OFFSET + v).unwrap());
        assert_eq!(drives[0], drives[1]);
    }
    // Within its limits the motion is that of the chain without them.
    let moved = Chain::new(*plain.model(), effects.of_motion());
    let (mut a, mut b) = (plain.start(0.0), moved.start(0.0));
    for u in reference(500) {
        assert_eq!(plain.step(&mut a, u), moved.step(&mut b, u));
    }
}

#[test]
fn a_congruency_that_plays_could_turn_over_is_refused() {
    use hysteron::error::{Field, ParameterError};
    let operator = Parameters {
        weights: &[0.8, -0.3, 0.5],
        thresholds: &[4.0, 9.0],
        beta: 0.0,
    }
    .build::<3>(H)
    .unwrap();
    let effects = Effects {
        congruency: Some(Congruency::new(1e-3, 1.0).unwrap()),
        ..Effects::default()
    };
    let model = Model::<f64, 3, 2>::new(operator, None, 1.0, 0.0).unwrap();
    let refused =
        Cascade::<f64, 3, 2, 2, true>::new(&Chain::new(model, effects), None).unwrap_err();
    assert_eq!(refused, ParameterError::PartialSum(Field::Weights, 1));
}

#[test]
fn laws_are_refused_by_a_cascade_without_them() {
    use hysteron::error::{Field, ParameterError};
    for (choice, field) in [(RATE_LAW, Field::Exponent), (CONGRUENCY, Field::Kappa)] {
        let refused = Cascade::<f64, 3, 2, 2>::new(&chain(choice), None).unwrap_err();
        assert_eq!(refused, ParameterError::NotSupported(field));
    }
}
