//! Settings, models and data sets as files.

use std::fs;

use hysteron::hysteresis::preview::PlantRate;
use hysteron::record::{Effect, ModelRecord};
use hysteron::settings::Settings;
use hysteron_host::dataset::{Dataset, NewRecord, Role, add_record};
use hysteron_host::link::model::{self, Choice};
use hysteron_host::link::settings;
use hysteron_host::model_file::{
    Backlash, BoucWen, Congruency, Hysteresis, Interleaving, ModelFile, Quantisation, RateLaw,
    Saturation, SensorLag, SlewLimit, Stage, builtin,
};
use hysteron_host::pil::Hardware;

use crate::support::message;

#[test]
fn settings_survive_their_file_and_change_by_parts() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("settings.toml");
    let odd = Settings {
        sample_rate_hz: 12_345.678,
        stale_s: 0.1,
        miss_limit: 7,
        ..Hardware::paper_j().unwrap().settings
    };
    fs::write(&file, settings::to_toml(&odd).unwrap()).unwrap();
    assert_eq!(settings::load(&file, &Settings::default()).unwrap(), odd);
    // Numbers as a person would write them.
    assert!(settings::to_toml(&odd).unwrap().contains("stale_s = 0.1\n"));

    fs::write(&file, "drive_max_v = 20\ndac = \"internal12\"\n").unwrap();
    let changed = settings::load(&file, &Settings::default()).unwrap();
    let expected = Settings {
        drive_max_v: 20.0,
        ..Settings::default()
    };
    assert_eq!(changed, expected);
}

#[test]
fn bad_settings_are_told_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("settings.toml");
    for (text, says) in [
        ("stale_s = 1\nslew = 3\n", "settings.toml:2: "),
        ("dac = \"unipolar\"\n", "settings.toml:1: dac"),
        ("drive_max_v = nan\n", "drive_min_v"),
        ("drive_max_v = 90\n", "amplifier_gain"),
        ("ramp_v_per_s = 1e9\n", "ramp_v_per_s"),
        ("sample_rate_hz = 50\n", "sample_rate_hz"),
        ("drive_max_v = \n", "settings.toml:1: "),
    ] {
        fs::write(&file, text).unwrap();
        let said = message(settings::load(&file, &Settings::default()));
        assert!(said.contains(says), "{said}");
    }
}

#[test]
fn models_are_judged_before_they_are_sent() {
    let bank = |plays: usize, first: f64| {
        let mut weights = vec![0.05; plays + 1];
        weights[0] = first;
        let hysteresis = Hysteresis {
            thresholds_v: (1..=plays).map(|i| i as f64).collect(),
            weights,
            beta_s: 0.0,
        };
        ModelFile::new("bank", vec![Stage::Hysteresis(hysteresis)])
    };
    let settings = Settings::default();
    assert!(model::record(&bank(16, 1.0), &settings, Choice::Explicit).is_ok());
    let said = message(model::record(&bank(17, 1.0), &settings, Choice::Explicit));
    assert!(
        said.contains("17 plays") && said.contains("--plays 16"),
        "{said}"
    );
    let said = message(model::record(&bank(3, -1.0), &settings, Choice::Explicit));
    assert!(said.contains("weights[0]"), "{said}");
    // Apart in double precision, one in single.
    let mut close = bank(2, 1.0);
    if let Stage::Hysteresis(hysteresis) = &mut close.stages[0] {
        hysteresis.thresholds_v = vec![1.0, 1.0 + 1e-9];
    }
    let said = message(model::record(&close, &settings, Choice::Explicit));
    assert!(said.contains("thresholds_v[1]"), "{said}");
    for name in ["p753", "p753-printed", "example-f"] {
        assert!(model::record(&builtin(name).unwrap(), &settings, Choice::Explicit).is_ok());
    }
}

#[test]
fn what_no_compensator_undoes_is_left_out_and_named() {
    let hysteresis = Stage::Hysteresis(Hysteresis {
        thresholds_v: vec![8.0],
        weights: vec![0.8, 0.3],
        beta_s: 0.0,
    });
    let settings = Settings::default();
    let choice = Choice::Cascade(PlantRate::Midpoint);
    let (g, width) = (1e-3, 0.5);
    let stages = vec![
        Stage::Saturation(Saturation { limit_v: 50.0 }),
        Stage::SlewLimit(SlewLimit { slew_v_per_s: 1e5 }),
        hysteresis.clone(),
        Stage::Backlash(Backlash { width }),
        Stage::Interleaving(Interleaving { g }),
        Stage::SensorLag(SensorLag { tau_s: 1e-4 }),
        Stage::Quantisation(Quantisation { step: 0.01 }),
    ];
    let extended = ModelFile::new("extended", stages);
    let prepared = model::record(&extended, &settings, choice).unwrap();
    assert_eq!(
        prepared.left_out,
        ["saturation", "slew-limit", "sensor-lag", "quantisation"]
    );
    let ModelRecord::Chain(chain) = &prepared.record else {
        panic!("a modified play model");
    };
    let (g, width) = (g as f32, width as f32);
    let sent = [Effect::Backlash { width }, Effect::Interleaving { g }];
    assert_eq!(chain.effects, sent);

    // Without these the numbers of the hysteresis mean something else, so none is left out.
    for (stage, name) in [
        (Stage::RateLaw(RateLaw { exponent: 0.5 }), "rate-law"),
        (Stage::Congruency(Congruency { kappa: 0.01 }), "congruency"),
        (
            Stage::BoucWen(BoucWen {
                weight: 0.1,
                grow_per_v: 0.2,
                shape_per_v: 0.0,
            }),
            "bouc-wen",
        ),
    ] {
        let file = ModelFile::new("of its own law", vec![stage, hysteresis.clone()]);
        for choice in [choice, Choice::Explicit] {
            let said = message(model::record(&file, &settings, choice));
            assert!(
                said.contains(name) && said.contains("--inverse cascade"),
                "{said}"
            );
        }
    }
}

#[test]
fn records_gather_in_a_data_set() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("stage \"A\"");
    let drive: Vec<f64> = (0..50).map(|k| 0.1 * f64::from(k)).collect();
    let displacement: Vec<f64> = drive.iter().map(|u| 1.2 * u).collect();
    let new = |stem, role, start_s| NewRecord {
        stem,
        role,
        start_s,
        sample_time_s: 1e-4,
        drive_v: &drive,
        displacement_um: &displacement,
    };
    let add = |stem, role, start_s| add_record(&set, &new(stem, role, start_s));
    assert_eq!(add("sine", Role::Fit, 1.0).unwrap(), "sine.csv");
    assert_eq!(add("sine", Role::Select, 2.0).unwrap(), "sine-2.csv");
    assert_eq!(add("sine", Role::Report, 3.5).unwrap(), "sine-3.csv");

    let dataset = Dataset::load(&set).unwrap();
    assert_eq!(dataset.name, "stage \"A\"");
    let facts: Vec<_> = dataset
        .records
        .iter()
        .map(|record| (record.role, record.start_s))
        .collect();
    let expected = [(Role::Fit, 1.0), (Role::Select, 2.0), (Role::Report, 3.5)];
    assert_eq!(facts, expected);
    assert_eq!(dataset.records[1].drive_v, drive);
    assert_eq!(dataset.records[1].displacement_um, displacement);

    // What does not fit changes nothing.
    let before = fs::read_to_string(set.join("dataset.toml")).unwrap();
    let said = message(add("sine", Role::Fit, 3.504));
    assert!(said.contains("ends at 3.5049"), "{said}");
    let short = NewRecord {
        drive_v: &drive[..7],
        ..new("sine", Role::Fit, 9.0)
    };
    assert!(message(add_record(&set, &short)).contains("too few"));
    let other = before.replace("\"um\"", "\"nm\"");
    fs::write(set.join("dataset.toml"), &other).unwrap();
    let said = message(add("sine", Role::Fit, 9.0));
    assert!(said.contains("other columns or units"), "{said}");
    assert_eq!(fs::read_to_string(set.join("dataset.toml")).unwrap(), other);
    assert_eq!(fs::read_dir(&set).unwrap().count(), 4);
}
