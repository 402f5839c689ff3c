//! Intervals of the parameters that a diagnosis finds, on simulated stages of tier 1 whose truth is known.

use hysteron_host::discover::{Baseline, Options, diagnose};
use hysteron_host::identify::Effect;
use hysteron_host::plant::hidden::{self, Choice, HiddenCase, Protocol};

/// An effect as it is hidden and as it is found, and one of its parameters.
type Parameter = (hidden::Effect, Effect, &'static str);

const PARAMETERS: [Parameter; 4] = [
    (
        hidden::Effect::TransportDelay,
        Effect::TransportDelay,
        "delay_s",
    ),
    (hidden::Effect::SensorLag, Effect::SensorLag, "tau_s"),
    (hidden::Effect::Resonance, Effect::Resonance, "f_n_hz"),
    (hidden::Effect::Saturation, Effect::Saturation, "limit_v"),
];

struct Found {
    truth: f64,
    value: f64,
    low: f64,
    high: f64,
}

impl Found {
    fn holds_truth(&self) -> bool {
        (self.low..=self.high).contains(&self.truth)
    }

    fn width(&self) -> f64 {
        self.high - self.low
    }
}

fn found((hide, effect, key): Parameter, seed: u64, noise_percent: f64) -> Found {
    let case = HiddenCase {
        choice: Choice::Named(vec![hide]),
        seed,
        noise_percent,
        strength: 1.5,
        protocol: Protocol::Full,
        rate_term: Some(false),
        ..HiddenCase::default()
    };
    let hidden = case.make().unwrap();
    let truth = hidden.truth.details[0].parameters[key].as_float().unwrap();
    let options = Options {
        baseline: Baseline::RateIndependent,
        library: vec![effect],
        ..Options::default()
    };
    let diagnosis = diagnose(&hidden.dataset, &options, &|_| {}).unwrap();
    let json = diagnosis.to_json(&[]);
    let one = &json["effects"][0];
    let number = |value: &serde_json::Value| {
        value
            .as_f64()
            .unwrap_or_else(|| panic!("{key}, seed {seed}: {one}"))
    };
    Found {
        truth,
        value: number(&one["parameters"][key]),
        low: number(&one["intervals"][key][0]),
        high: number(&one["intervals"][key][1]),
    }
}

/// Of twelve intervals of 95 %, ten or more hold the truth in 98 % of such draws, of intervals half as
/// wide in 19 %. Intervals that are far too wide fail by the spread of the errors, which is one in units
/// of the standard deviation that they claim.
#[test]
fn most_intervals_hold_the_truth() {
    let (mut held, mut squares) = (0, 0.0);
    for parameter in PARAMETERS {
        for seed in 1..=3 {
            let found = found(parameter, seed, 0.2);
            println!(
                "{} {seed}: {} in {} to {}, truth {}",
                parameter.2, found.value, found.low, found.high, found.truth
            );
            assert!(found.low < found.value && found.value < found.high);
            held += usize::from(found.holds_truth());
            let deviation = found.width() / (2.0 * 1.96);
            squares += ((found.value - found.truth) / deviation).powi(2);
        }
    }
    assert!(held >= 10, "{held} of 12");
    let spread = (squares / 12.0f64).sqrt();
    assert!((0.5..1.6).contains(&spread), "{spread}");
}

#[test]
fn intervals_shrink_with_the_noise() {
    for parameter in PARAMETERS {
        let [loud, quiet] = [0.4, 0.1].map(|noise| found(parameter, 5, noise).width());
        let ratio = loud / quiet;
        println!("{}: {ratio}", parameter.2);
        assert!((2.0..8.0).contains(&ratio), "{}: {ratio}", parameter.2);
    }
}
