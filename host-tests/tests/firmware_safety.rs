//! The safety machine against its promises: range, slew, soft start, stale targets, faults.

use hysteron::safety::{Cause, Limits, Safety, State};
use proptest::prelude::*;

const LIMITS: Limits = Limits {
    lowest: -30.0,
    highest: 40.0,
    rest: 5.0,
    slew: 2.0,
    ramp: 0.25,
    stale: 10,
};

#[derive(Clone, Debug)]
enum Event {
    Target(f32),
    Missing,
    Run,
    Hold,
    Off,
    Clear,
    Fault,
    Join,
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        20 => (-100f32..100.0).prop_map(Event::Target),
        2 => prop_oneof![
            Just(f32::NAN), Just(f32::INFINITY), Just(f32::NEG_INFINITY), Just(f32::MAX), Just(f32::MIN)
        ].prop_map(Event::Target),
        6 => Just(Event::Missing),
        3 => Just(Event::Run),
        1 => Just(Event::Hold),
        1 => Just(Event::Off),
        1 => Just(Event::Clear),
        1 => Just(Event::Fault),
        1 => Just(Event::Join),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn range_and_slew_hold_whatever_happens(events in prop::collection::vec(event(), 1..400)) {
        let mut safety = Safety::new(&LIMITS);
        let mut before = LIMITS.rest;
        for event in events {
            let mut target = None;
            match event {
                Event::Target(value) => target = Some(value),
                Event::Missing => {}
                Event::Run => safety.run(),
                Event::Hold => safety.hold(),
                Event::Off => safety.off(),
                Event::Clear => safety.clear(),
                Event::Fault => safety.fault(Cause::Deadline),
                Event::Join => safety.join(),
            }
            let faulty = safety.state() == State::Fault;
            let output = safety.step(&LIMITS, target);
            prop_assert!((LIMITS.lowest..=LIMITS.highest).contains(&output));
            prop_assert!((output - before).abs() <= LIMITS.slew * (1.0 + 1e-6));
            if matches!(safety.state(), State::Off | State::Fault) {
                prop_assert!((output - before).abs() <= LIMITS.ramp * (1.0 + 1e-5));
            }
            if faulty {
                prop_assert_eq!(safety.state(), State::Fault);
            }
            before = output;
        }
        // Whatever happened before: off ends at rest, with the driver disabled.
        safety.clear();
        safety.off();
        for _ in 0..1 + (70.0 / LIMITS.ramp) as usize {
            safety.step(&LIMITS, None);
        }
        prop_assert_eq!(safety.output(), LIMITS.rest);
        prop_assert!(!safety.driver_enabled(&LIMITS));
    }
}

#[test]
fn soft_start_joins_a_far_target_at_the_ramp_rate() {
    let mut safety = Safety::new(&LIMITS);
    safety.run();
    let mut before = safety.output();
    for sample in 0..100 {
        let output = safety.step(&LIMITS, Some(25.0));
        assert!(output - before <= LIMITS.ramp * 1.0001, "sample {sample}");
        before = output;
    }
    // 20 V at 0.25 V a sample take 80 samples after the one that joins.
    assert_eq!(before, 25.0);
}

#[test]
fn a_new_target_is_joined_without_a_jump_and_reached_exactly() {
    let mut safety = Safety::new(&LIMITS);
    safety.run();
    for _ in 0..100 {
        safety.step(&LIMITS, Some(10.0));
    }
    safety.join();
    assert_eq!(safety.step(&LIMITS, Some(12.0)), 10.0);
    let outputs: Vec<f32> = (0..8).map(|_| safety.step(&LIMITS, Some(12.0))).collect();
    assert_eq!(
        outputs,
        [10.25, 10.5, 10.75, 11.0, 11.25, 11.5, 11.75, 12.0]
    );
}

#[test]
fn a_stale_target_is_waited_for_and_then_ramped_away() {
    let mut safety = Safety::new(&LIMITS);
    safety.run();
    for _ in 0..100 {
        safety.step(&LIMITS, Some(20.0));
    }
    for _ in 0..=LIMITS.stale {
        assert_eq!(safety.state(), State::Run);
        assert_eq!(safety.step(&LIMITS, None), 20.0);
    }
    assert_eq!(safety.state(), State::Off);
    assert_eq!(safety.step(&LIMITS, Some(20.0)), 19.75);
    assert_eq!(safety.underruns(), 1);
    for _ in 0..59 {
        safety.step(&LIMITS, Some(20.0));
    }
    assert_eq!(safety.output(), LIMITS.rest);
}

#[test]
fn a_target_that_comes_back_in_time_is_joined_again() {
    let mut safety = Safety::new(&LIMITS);
    safety.run();
    for _ in 0..100 {
        safety.step(&LIMITS, Some(20.0));
    }
    for _ in 0..LIMITS.stale {
        safety.step(&LIMITS, None);
    }
    assert_eq!(safety.step(&LIMITS, Some(30.0)), 20.0);
    assert_eq!(safety.state(), State::Run);
    assert_eq!(safety.step(&LIMITS, Some(30.0)), 20.25);
}

#[test]
fn not_finite_is_a_fault_that_only_clear_leaves() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut safety = Safety::new(&LIMITS);
        safety.run();
        for _ in 0..100 {
            safety.step(&LIMITS, Some(20.0));
        }
        assert_eq!(safety.step(&LIMITS, Some(bad)), 20.0);
        assert_eq!(
            (safety.state(), safety.cause()),
            (State::Fault, Some(Cause::NotFinite))
        );
        safety.run();
        safety.hold();
        safety.off();
        assert_eq!(safety.state(), State::Fault);
        assert_eq!(safety.step(&LIMITS, Some(20.0)), 19.75);
        safety.clear();
        assert_eq!((safety.state(), safety.cause()), (State::Off, None));
        safety.run();
        assert_eq!(safety.step(&LIMITS, Some(20.0)), 19.75);
        assert_eq!(safety.step(&LIMITS, Some(20.0)), 20.0);
    }
}
