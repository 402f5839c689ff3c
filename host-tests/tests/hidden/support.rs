//! Stages whose every part is known.

use hysteron_host::plant::hidden::{
    Baseline, Choice, Core, Effect, Family, Hidden, HiddenCase, HiddenPlant, Law, Protocol, Setup,
    Tier,
};

pub const TIERS: [Tier; 4] = [Tier::Same, Tier::Finer, Tier::Irregular, Tier::Other];

pub fn case(effects: &[Effect], seed: u64, tier: Tier) -> HiddenCase {
    HiddenCase {
        choice: Choice::Named(effects.to_vec()),
        seed,
        tier,
        protocol: Protocol::Full,
        ..HiddenCase::default()
    }
}

pub fn hide(effects: &[Effect], seed: u64, tier: Tier) -> Hidden {
    case(effects, seed, tier).make().unwrap()
}

/// A stage of 2 um/V and 1 um at 0 V, 0 to 10 V, with plays of these thresholds and weights.
pub fn stage(tier: Tier, plays: &[(f64, f64)], beta_s: f64, laws: Vec<Law>) -> HiddenPlant {
    HiddenPlant {
        tier,
        setup: Setup {
            drive_min_v: 0.0,
            drive_max_v: 10.0,
            stroke_um: 20.0,
            offset_um: 1.0,
            top_hz: 100.0,
            ..hide(&[], 1, Tier::Same).plant.setup
        },
        baseline: Baseline {
            core: Core {
                direct: 1.0,
                family: Family::Plays {
                    thresholds_v: plays.iter().map(|play| play.0).collect(),
                    weights: plays.iter().map(|play| play.1).collect(),
                },
                middle_v: 5.0,
            },
            hysteresis_percent: 0.0,
            beta_s,
        },
        laws,
    }
}

pub fn near(value: f64, expected: f64, tolerance: f64) {
    assert!(
        (value - expected).abs() <= tolerance,
        "{value} is not {expected} within {tolerance}"
    );
}

pub fn rms(signal: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = signal
        .into_iter()
        .fold((0.0, 0), |(sum, count), x| (sum + x * x, count + 1));
    (sum / f64::from(count)).sqrt()
}
