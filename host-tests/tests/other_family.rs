//! Diagnosis of stages whose hysteresis is none that the baseline's plays make: Bouc and Wen's equation,
//! and plays wider than every loop. The truth is the hidden stage's own.

use hysteron_host::dataset::{Dataset, Role};
use hysteron_host::discover::{Diagnosis, Options, Verdict, diagnose};
use hysteron_host::identify::Effect;
use hysteron_host::plant::hidden::{self, Choice, HiddenCase, Protocol, Tier};
use hysteron_host::stage;

fn diagnosis(case: &HiddenCase) -> (Dataset, Diagnosis) {
    let hidden = case.make().unwrap();
    let found = diagnose(&hidden.dataset, &Options::default(), &|_| {}).unwrap();
    (hidden.dataset, found)
}

/// Plays leave 27 times the noise of this stage, and no effect closes that gap.
#[test]
fn an_effect_is_found_beside_bouc_and_wen() {
    let case = HiddenCase {
        choice: Choice::Named(vec![hidden::Effect::Quadratic]),
        seed: 9009,
        tier: Tier::Other,
        strength: 0.454,
        noise_percent: 0.029,
        protocol: Protocol::Slow,
        rate_term: None,
    };
    let (dataset, found) = diagnosis(&case);
    let names: Vec<Effect> = found.effects.iter().map(|one| one.effect).collect();
    assert_eq!(found.verdict, Verdict::Named, "{names:?}");
    assert_eq!(names, [Effect::Quadratic]);
    assert!(found.closed().unwrap() > 0.9, "{:?}", found.closed());
    let elements = found.model.stages.iter();
    let elements = elements.filter(|stage| stage.name() == "bouc-wen");
    assert!((1..=3).contains(&elements.count()), "{:?}", found.model);

    // The model that is written, run by the core along each report record alone: the history before it is
    // missing, which the second halves have forgotten for the most part.
    let mut squares = Vec::new();
    for record in dataset.records.iter().filter(|r| r.role == Role::Report) {
        let y = stage::displacement(&found.model, record.sample_time_s, &record.drive_v).unwrap();
        let half = y.len() / 2;
        let left: Vec<f64> = y[half..]
            .iter()
            .zip(&record.displacement_um[half..])
            .map(|(y, measured)| measured - y)
            .collect();
        let mean = left.iter().sum::<f64>() / left.len() as f64;
        squares.push(left.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / left.len() as f64);
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let baseline = found.baseline.report.unwrap();
    assert!(rms < 0.4 * baseline, "{rms} of {baseline}");
}

/// A threshold of 0.59 of the range: its play moves once, in the first loop of the session.
#[test]
fn plays_wider_than_every_loop_are_no_effect() {
    let case = HiddenCase {
        choice: Choice::Named(Vec::new()),
        seed: 91_283,
        tier: Tier::Same,
        strength: 2.22,
        noise_percent: 0.0271,
        protocol: Protocol::Full,
        rate_term: None,
    };
    let (_, found) = diagnosis(&case);
    assert_eq!(found.verdict, Verdict::None);
    let widest = found
        .model
        .hysteresis()
        .unwrap()
        .thresholds_v
        .last()
        .copied();
    // That it is beyond the half of the range shows; where, only one move tells.
    assert!(widest.unwrap() > 50.0, "{widest:?}");
}

/// A drift takes 0.6 of the noise from the select records of these relays, and adds 0.9 of it to the report
/// records, which show no gap without it.
#[test]
fn a_name_that_does_harm_on_the_report_records_is_refused() {
    let case = HiddenCase {
        choice: Choice::Named(Vec::new()),
        seed: 94_218,
        tier: Tier::Other,
        strength: 0.794,
        noise_percent: 0.039,
        protocol: Protocol::Full,
        rate_term: None,
    };
    let (_, found) = diagnosis(&case);
    assert_eq!(found.verdict, Verdict::None);
    assert!(found.effects.is_empty());
    let refused = found.notes.iter().any(|note| note.contains("drift"));
    assert!(refused, "{:?}", found.notes);
}
