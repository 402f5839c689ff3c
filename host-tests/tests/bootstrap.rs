//! The bar for a name by bootstrap, on simulated stages whose noise is known.

use hysteron_host::discover::{Options, Verdict, diagnose};
use hysteron_host::identify::Effect;
use hysteron_host::plant::hidden::{self, Choice, HiddenCase, Protocol};

const DRAWS: usize = 8;

/// Verdict, bar and true rms of the noise, both in um.
fn asked(choice: Choice, noise_percent: f64) -> (Verdict, f64, f64) {
    let case = HiddenCase {
        choice,
        seed: 17,
        noise_percent,
        strength: 0.3,
        protocol: Protocol::Slow,
        rate_term: Some(false),
        ..HiddenCase::default()
    };
    let hidden = case.make().unwrap();
    let options = Options {
        library: vec![Effect::Quadratic, Effect::Creep],
        bootstrap: DRAWS,
        ..Options::default()
    };
    let found = diagnose(&hidden.dataset, &options, &|_| {}).unwrap();
    (found.verdict, found.bar_um, hidden.truth.noise_um)
}

/// Chance alone gains a small part of the noise among thousands of samples, more noise gains more, and an
/// effect that leaves more than that is named.
#[test]
fn chance_gains_a_small_part_of_the_noise() {
    let (quiet, bar, noise) = asked(Choice::Named(Vec::new()), 0.1);
    assert_eq!(quiet, Verdict::None);
    assert!(bar > 0.0 && bar < 0.3 * noise, "{bar} {noise}");
    let (_, louder, _) = asked(Choice::Named(Vec::new()), 0.4);
    assert!((1.5..8.0).contains(&(louder / bar)), "{louder} {bar}");
    let (verdict, ..) = asked(Choice::Named(vec![hidden::Effect::Quadratic]), 0.1);
    assert_eq!(verdict, Verdict::Named);
}
