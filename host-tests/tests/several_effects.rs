//! Effects that hide each other: below the steps of a coarse reading, or of the same size, or that look like
//! others while one of them is missing. The truth
//! is the hidden stage's own.

use hysteron_host::discover::{Diagnosis, Options, Verdict, diagnose};
use hysteron_host::identify::Effect;
use hysteron_host::plant::hidden::{self, Choice, HiddenCase, Protocol, Tier};

fn diagnosis(
    effects: &[hidden::Effect],
    seed: u64,
    tier: Tier,
    (strength, noise_percent): (f64, f64),
) -> Diagnosis {
    let case = HiddenCase {
        choice: Choice::Named(effects.to_vec()),
        seed,
        tier,
        strength,
        noise_percent,
        protocol: Protocol::Full,
        rate_term: None,
    };
    let hidden = case.make().unwrap();
    diagnose(&hidden.dataset, &Options::default(), &|_| {}).unwrap()
}

fn names(found: &Diagnosis) -> Vec<Effect> {
    found.effects.iter().map(|one| one.effect).collect()
}

/// Bend and rounding have the same rms, 81 times that of the noise; the bend's is 0.29 of a step.
#[test]
fn an_effect_below_the_steps_of_the_reading_is_found() {
    let effects = [hidden::Effect::Quadratic, hidden::Effect::Quantisation];
    let found = diagnosis(&effects, 9466, Tier::Same, (2.26, 0.028));
    assert_eq!(found.verdict, Verdict::Named);
    assert_eq!(names(&found), [Effect::Quantisation, Effect::Quadratic]);
    assert!(
        found.effects[1].also_possible.is_empty(),
        "{:?}",
        found.effects[1].also_possible
    );
}

/// Plays come no nearer to relays than the steps show.
#[test]
fn a_coarse_reading_of_another_family_is_a_coarse_reading() {
    for seed in [102, 105] {
        let found = diagnosis(
            &[hidden::Effect::Quantisation],
            seed,
            Tier::Other,
            (1.7, 0.3),
        );
        assert_eq!(names(&found), [Effect::Quantisation], "seed {seed}");
    }
}

/// The mode alone closes 12 % of the gap.
#[test]
fn two_effects_are_found_of_which_neither_is_worth_it_alone() {
    let effects = [hidden::Effect::Resonance, hidden::Effect::SensorLag];
    let found = diagnosis(&effects, 9476, Tier::Same, (1.67, 0.482));
    assert_eq!(found.verdict, Verdict::Named);
    assert_eq!(names(&found), [Effect::Resonance, Effect::SensorLag]);
    assert!(found.effects[0].left_over > 0.8);
    assert!(found.effects[1].left_over < 0.3);
}

/// Three effects, in any order, as the only names.
fn three_are_found(effects: [hidden::Effect; 3], seed: u64, size: (f64, f64)) {
    let found = diagnosis(&effects, seed, Tier::Same, size);
    assert_eq!(found.verdict, Verdict::Named);
    let mut named: Vec<&str> = names(&found).into_iter().map(Effect::name).collect();
    named.sort_unstable();
    let mut truth = effects.map(hidden::Effect::name);
    truth.sort_unstable();
    assert_eq!(named, truth);
    assert!(found.closed().unwrap() > 0.9);
}

/// The best of them alone closes 5 % of the gap.
#[test]
fn three_effects_are_found_of_which_none_is_worth_it_alone() {
    use hidden::Effect::{Cubic, Resonance, SlewLimit};
    three_are_found([SlewLimit, Cubic, Resonance], 10_323, (1.66, 0.105));
}

/// A mode makes other records worse as long as the lag before it is not known.
#[test]
fn a_mode_is_found_that_does_harm_without_the_lag_before_it() {
    use hidden::Effect::{AmplifierLag, MainsHum, Resonance};
    three_are_found([AmplifierLag, Resonance, MainsHum], 11_314, (1.9, 0.0205));
}

/// Taken one by one, a congruency and a cubic stand in for the quadratic.
#[test]
fn fewer_effects_take_the_place_of_look_alikes() {
    use hidden::Effect::{Quadratic, RateLaw, Resonance};
    three_are_found([RateLaw, Quadratic, Resonance], 10_303, (2.5, 0.0539));
}

/// One by one an asymmetry takes the place of both.
#[test]
fn two_effects_take_the_place_of_one_that_leaves_more() {
    use hidden::Effect::{Congruency, Cubic, MainsHum};
    three_are_found([Congruency, Cubic, MainsHum], 10_313, (1.29, 0.0663));
}
