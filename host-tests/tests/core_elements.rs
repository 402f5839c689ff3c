//! Elements of Bouc and Wen beside the plays: against small steps of their equation, and the cascade
//! that undoes them.

use std::f64::consts::TAU;

use hysteron::cascade::Cascade;
use hysteron::chain::{Chain, Effects};
use hysteron::effect::congruency::Congruency;
use hysteron::effect::creep::Creep;
use hysteron::effect::rate_power::RatePower;
use hysteron::error::{Field, ParameterError};
use hysteron::hysteresis::Parameters;
use hysteron::hysteresis::bouc_wen::BoucWen;
use hysteron::hysteresis::elements::{ELEMENTS, Elements};
use hysteron::model::Model;

const H: f64 = 1e-4;
const GAIN: f64 = 1.7;
const OFFSET: f64 = -3.0;

fn elements(all: &[(f64, f64, f64)]) -> Elements<f64> {
    let mut elements = Elements::default();
    for &(weight, grow, shape) in all {
        let element = BoucWen::new(weight, grow, shape).unwrap();
        elements.add(element).unwrap();
    }
    elements
}

fn chain(beta: f64, effects: Effects<f64>) -> Chain<f64, 3, 2> {
    let operator = Parameters {
        weights: &[0.5, 0.15, 0.1],
        thresholds: &[1.5, 6.0],
        beta,
    };
    let model = Model::new(operator.build(H).unwrap(), None, GAIN, OFFSET);
    Chain::new(model.unwrap(), effects)
}

/// Loops of two sizes with minor ones on top.
fn signal(samples: usize, size: f64) -> impl Iterator<Item = f64> {
    (0..samples).map(move |k| {
        let t = k as f64 * H;
        size * ((TAU * 7.0 * t).sin() + 0.35 * (TAU * 61.0 * t).sin())
    })
}

/// The chain's displacement against explicit steps of the equations, a hundred a sample.
#[test]
fn a_chain_with_elements_follows_their_equation() {
    let all = [(0.15, 0.12, 0.03), (0.1, 0.3, -0.1)];
    let effects = Effects {
        elements: elements(&all),
        ..Effects::default()
    };
    let chain = chain(0.0, effects);
    let mut state = chain.start(0.0);
    let (mut z, mut plays, mut last) = ([0.0; 2], [0.0_f64; 2], 0.0);
    for u in signal(6_000, 12.0) {
        let y = chain.step(&mut state, u);
        let step = (u - last) / 100.0;
        for _ in 0..100 {
            for (z, (_, grow, shape)) in z.iter_mut().zip(all) {
                *z += step - grow * f64::abs(step) * *z - shape * step * z.abs();
            }
        }
        last = u;
        for (play, r) in plays.iter_mut().zip([1.5, 6.0]) {
            *play = play.clamp(u - r, u + r);
        }
        let lagging: f64 = z.iter().zip(all).map(|(z, (a, ..))| a * (u - z)).sum();
        let w = 0.5 * u + 0.15 * plays[0] + 0.1 * plays[1] + lagging;
        assert!((y - (OFFSET + GAIN * w)).abs() < 2e-3, "{y} {w}");
    }
}

/// Largest error in um of a chain that follows a reference of this size by its cascade.
fn error(chain: &Chain<f64, 3, 2>, size: f64) -> f64 {
    let cascade = Cascade::<f64, 3, 2, 2, true>::new(chain, None).unwrap();
    let mut state = cascade.start(OFFSET).unwrap();
    let mut plant = chain.start(0.0);
    let latency = cascade.latency();
    let reference: Vec<f64> = signal(6_000, size).collect();
    let mut worst = 0.0_f64;
    for (k, v) in reference.iter().enumerate() {
        let drive = cascade.step(&mut state, OFFSET + v).unwrap();
        let y = chain.step(&mut plant, drive) - OFFSET;
        if k >= latency {
            worst = worst.max((y - reference[k - latency]).abs());
        }
    }
    worst
}

#[test]
fn the_cascade_undoes_elements() {
    let effects = Effects {
        elements: elements(&[(0.15, 0.12, 0.03), (0.1, 0.3, -0.1)]),
        ..Effects::default()
    };
    assert!(error(&chain(0.0, effects), 14.0) < 1e-9);
    let with_congruency = Effects {
        congruency: Some(Congruency::new(4e-3, GAIN).unwrap()),
        creep: Some(Creep::new(0.02, 1e-2, 10.0, H).unwrap()),
        elements: elements(&[(0.05, 0.12, 0.03)]),
        ..effects
    };
    assert!(error(&chain(0.0, with_congruency), 14.0) < 1e-9);
    // One that bends much: below zero the output rises more slowly than the plays alone would tell.
    let bent = Effects {
        congruency: Some(Congruency::new(0.1 / GAIN, GAIN).unwrap()),
        elements: elements(&[(0.3, 0.2, 0.2)]),
        ..Effects::default()
    };
    assert!(error(&chain(0.0, bent), 7.0) < 1e-9);
    // The plant sees the rate of its own drive, the inverse that of the reference.
    let of_rate = chain(2e-5, effects);
    let left = error(&of_rate, 14.0);
    assert!(left > 1e-6 && left < 0.05, "{left}");
    let with_law = Effects {
        rate_law: Some(RatePower::new(0.5).unwrap()),
        ..effects
    };
    assert!(error(&chain(1e-3, with_law), 14.0) < 0.05);
}

#[test]
fn what_has_no_inverse_or_no_room_is_refused() {
    let refused = |all: &[(f64, f64, f64)]| {
        let effects = Effects {
            elements: elements(all),
            ..Effects::default()
        };
        Cascade::<f64, 3, 2, 2, true>::new(&chain(0.0, effects), None).err()
    };
    assert_eq!(refused(&[(0.49, 0.2, 0.0)]), None);
    // Right after a turn the elements fall by 0.51 V/V, and the drive itself weighs 0.5.
    assert_eq!(
        refused(&[(0.51, 0.2, 0.0)]),
        Some(ParameterError::Outweighed(Field::Weights))
    );
    let effects = Effects {
        elements: elements(&[(0.1, 0.2, 0.0)]),
        ..Effects::default()
    };
    assert_eq!(
        Cascade::<f64, 3, 2, 2>::new(&chain(0.0, effects), None).err(),
        Some(ParameterError::NotSupported(Field::Elements))
    );
    let mut full = elements(&[(0.1, 0.2, 0.0); ELEMENTS]);
    assert_eq!(
        full.add(BoucWen::new(0.1, 0.2, 0.0).unwrap()),
        Err(ParameterError::TooLarge(Field::Elements))
    );
}
