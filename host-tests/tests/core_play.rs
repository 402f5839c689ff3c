//! Identities that a play operator must satisfy, whatever its implementation.

use hysteron::play::{Envelope, PlainState, PlayBank, StackState, play};
use proptest::prelude::*;

const N: usize = 12;

fn bank_strategy() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    prop::collection::vec((0.05f64..3.0, -1.0f64..1.0), 1..=N).prop_map(|rows| {
        let mut threshold = 0.0;
        rows.into_iter()
            .map(|(gap, weight)| {
                threshold += gap;
                (threshold, weight)
            })
            .unzip()
    })
}

/// Play outputs that satisfy (J 8) at any input: steps of at most the gap between thresholds.
fn admissible(thresholds: &[f64], shares: &[f64]) -> Vec<f64> {
    let (mut z, mut before) = (0.0, 0.0);
    thresholds
        .iter()
        .zip(shares.iter().cycle())
        .map(|(&r, share)| {
            z += share * (r - before);
            before = r;
            z
        })
        .collect()
}

fn inputs() -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(-20.0f64..20.0, 1..120)
}

fn run(bank: &PlayBank<f64, N>, state: &mut StackState<f64, N>, inputs: &[f64]) -> Vec<[f64; N]> {
    inputs
        .iter()
        .map(|&u| {
            state.step(bank, Envelope::closed(u));
            state.outputs(bank)
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn plain_and_stack_agree(
        (thresholds, weights) in bank_strategy(),
        shares in prop::collection::vec(-1.0f64..1.0, N),
        samples in prop::collection::vec((-20.0f64..20.0, 0.0f64..4.0), 1..200),
    ) {
        let bank = PlayBank::<f64, N>::new(&thresholds, &weights).unwrap();
        let z = admissible(&thresholds, &shares);
        let mut plain = PlainState::new(&bank, &z).unwrap();
        let mut stack = StackState::new(&bank, &z).unwrap();
        for (u, half_width) in samples {
            let envelope = Envelope { lo: u - half_width, hi: u + half_width };
            let (a, b) = (plain.step(&bank, envelope), stack.step(&bank, envelope));
            prop_assert!((a - b).abs() <= 1e-12 * 20.0 * N as f64, "{a} {b}");
            for (a, b) in plain.outputs().iter().zip(stack.outputs(&bank)) {
                prop_assert!((a - b).abs() <= 1e-12, "{a} {b}");
            }
        }
    }

    #[test]
    fn outputs_stay_within_the_threshold_of_the_envelope(
        (thresholds, weights) in bank_strategy(),
        samples in prop::collection::vec((-20.0f64..20.0, 0.0f64..4.0), 1..200),
    ) {
        let bank = PlayBank::<f64, N>::new(&thresholds, &weights).unwrap();
        let mut state = StackState::zero(&bank);
        for (u, half_width) in samples {
            state.step(&bank, Envelope { lo: u - half_width, hi: u + half_width });
            for (z, r) in state.outputs(&bank).iter().zip(&thresholds) {
                prop_assert!((u - z).abs() <= r + half_width + 1e-12);
            }
            // What a step leaves is a state that a step can start from.
            prop_assert!(bank.check_outputs(&state.outputs(&bank)[..thresholds.len()]).is_ok());
        }
    }

    #[test]
    fn a_larger_excursion_wipes_out_what_lies_within_it(
        (thresholds, weights) in bank_strategy(),
        before in inputs(),
        within in inputs(),
        after in inputs(),
    ) {
        let bank = PlayBank::<f64, N>::new(&thresholds, &weights).unwrap();
        let (mut with, mut without) = (StackState::zero(&bank), StackState::zero(&bank));
        // The excursions reach both beyond the range of what came before and of what lies between.
        run(&bank, &mut with, &[&before[..], &[-20.0, 20.0], &within[..], &[-20.0, 20.0]].concat());
        run(&bank, &mut without, &[&before[..], &[-20.0, 20.0]].concat());
        prop_assert_eq!(run(&bank, &mut with, &after), run(&bank, &mut without, &after));
    }

    #[test]
    fn a_minor_loop_returns_to_the_point_it_left(
        (thresholds, weights) in bank_strategy(),
        before in inputs(),
        start in -20.0f64..20.0,
        minor in prop::collection::vec(0.0f64..1.0, 1..30),
        depth in 0.0f64..15.0,
    ) {
        // Left while rising, inside an excursion `depth` deep, and back: the return point.
        let bank = PlayBank::<f64, N>::new(&thresholds, &weights).unwrap();
        let mut state = PlainState::zero();
        for &u in before.iter().chain(&[-40.0, start]) {
            state.step(&bank, Envelope::closed(u));
        }
        let left = state.outputs();
        for share in &minor {
            state.step(&bank, Envelope::closed(start - depth * share));
        }
        state.step(&bank, Envelope::closed(start));
        for (a, b) in state.outputs().iter().zip(left) {
            prop_assert!((a - b).abs() < 1e-12);
        }
    }

    #[test]
    fn repeated_and_interpolated_samples_change_nothing(
        (thresholds, weights) in bank_strategy(),
        path in inputs(),
        pieces in 1usize..5,
    ) {
        let bank = PlayBank::<f64, N>::new(&thresholds, &weights).unwrap();
        let (mut once, mut often) = (StackState::zero(&bank), StackState::zero(&bank));
        let mut from = 0.0;
        for &u in &path {
            once.step(&bank, Envelope::closed(u));
            for k in 1..=pieces {
                let share = k as f64 / pieces as f64;
                let between = if k == pieces { u } else { from + share * (u - from) };
                often.step(&bank, Envelope::closed(between));
                often.step(&bank, Envelope::closed(between));
            }
            from = u;
            for (a, b) in once.outputs(&bank).iter().zip(often.outputs(&bank)) {
                prop_assert!((a - b).abs() < 1e-11);
            }
        }
    }

    #[test]
    fn monotone_in_monotone_out(
        (thresholds, weights) in bank_strategy(),
        before in inputs(),
        steps in prop::collection::vec(0.0f64..2.0, 1..50),
    ) {
        let weights: Vec<f64> = weights.iter().map(|w| w.abs()).collect();
        let bank = PlayBank::<f64, N>::new(&thresholds, &weights).unwrap();
        let mut state = bank.start();
        let mut output = f64::NEG_INFINITY;
        for &u in &before {
            output = state.step(&bank, Envelope::closed(u));
        }
        let mut u = *before.last().unwrap();
        for step in steps {
            u += step;
            let next = state.step(&bank, Envelope::closed(u));
            prop_assert!(next >= output - 1e-12);
            output = next;
        }
    }
}

/// A symmetric cycle of amplitude A > r drives a play around a parallelogram of area 4 r (A - r).
#[test]
fn loop_area_of_one_play() {
    let (amplitude, r) = (5.0, 1.5);
    let corners = [0.0, amplitude, -amplitude, amplitude];
    let steps = 1000;
    let mut z = 0.0;
    let mut area = 0.0;
    for leg in corners.windows(2).enumerate() {
        let (leg, [from, to]) = leg else {
            unreachable!()
        };
        for k in 1..=steps {
            let (u, before) = (
                from + (to - from) * k as f64 / steps as f64,
                from + (to - from) * (k - 1) as f64 / steps as f64,
            );
            let z_before = z;
            z = play(z, Envelope::closed(u), r);
            if leg > 0 {
                area += 0.5 * (u + before) * (z - z_before);
            }
        }
    }
    assert!(
        (area.abs() - 4.0 * r * (amplitude - r)).abs() < 1e-9,
        "{area}"
    );
}

/// Captures of few and of many of a hundred plays, a jump among them, against each play by itself.
#[test]
fn a_large_stack_agrees_with_its_plays() {
    const MANY: usize = 100;
    let thresholds: Vec<f64> = (1..=MANY).map(|i| (i as f64).powf(1.2) * 0.1).collect();
    let weights: Vec<f64> = (0..MANY).map(|i| (i as f64 * 0.7).sin()).collect();
    let bank = PlayBank::<f64, MANY>::new(&thresholds, &weights).unwrap();
    let mut state = StackState::zero(&bank);
    let mut z = [0.0; MANY];
    let mut seed = 7u64;
    for k in 0..20_000 {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let noise = (seed >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        let t = k as f64 * 1e-3;
        let u = 20.0 * (7.0 * t).sin() + if k % 500 < 50 { 45.0 } else { 3.0 } * noise;
        let envelope = Envelope {
            lo: u - noise.abs(),
            hi: u + noise.abs(),
        };
        let output = state.step(&bank, envelope);
        let mut sum = 0.0;
        for ((z, r), w) in z.iter_mut().zip(&thresholds).zip(&weights) {
            *z = (envelope.lo - r).max((envelope.hi + r).min(*z));
            sum += w * *z;
        }
        assert!((output - sum).abs() < 1e-10, "{k}: {output} and {sum}");
        for (a, b) in state.outputs(&bank).iter().zip(&z) {
            assert!((a - b).abs() < 1e-12, "{k}: {a} and {b}");
        }
    }
}

/// On a smooth input a sample touches few segments, however many plays there are.
#[test]
fn the_stack_stays_shallow() {
    const MANY: usize = 1000;
    let thresholds: Vec<f64> = (1..=MANY).map(|i| i as f64 * 0.04).collect();
    let bank = PlayBank::<f64, MANY>::new(&thresholds, &[1e-3; MANY]).unwrap();
    let mut state = StackState::zero(&bank);
    let mut deepest = 0;
    for k in 0..20_000 {
        let t = k as f64 * 1e-4;
        let u = 25.0 * (2.0 * std::f64::consts::PI * 5.0 * t).sin() + 15.0 * (77.0 * t).sin();
        state.step(&bank, Envelope::closed(u));
        if k > 2000 {
            deepest = deepest.max(state.depth());
        }
    }
    assert!(deepest <= 40, "{deepest} segments");
}
