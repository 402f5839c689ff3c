//! A model of the user's own as the baseline of a diagnosis. The truth is run by the core's chain, which
//! no fit uses.

use std::f64::consts::TAU;

use hysteron_host::dataset::{Dataset, LengthUnit, Record, Role, Zero};
use hysteron_host::discover::{Baseline, Diagnosis, Options, Verdict, diagnose};
use hysteron_host::identify::Effect;
use hysteron_host::model_file::{self, ModelFile, Stage};
use hysteron_host::stage;
use rand::{Rng, SeedableRng, rngs::SmallRng};

/// Effects that may be named: those of the models below and some others.
const LIBRARY: [Effect; 7] = [
    Effect::AmplifierLag,
    Effect::Congruency,
    Effect::Quadratic,
    Effect::Cubic,
    Effect::Resonance,
    Effect::Creep,
    Effect::Drift,
];

const H: f64 = 1e-3;
const NOISE_UM: f64 = 0.01;

/// A stage that falls with the drive, with a map of more zones than a fit has of its own and a slope at
/// zero that is not one.
const MODEL: &str = r#"
format = "hysteron-model"
version = 1
name = "own"
units = { time = "s", drive = "V", displacement = "um" }
[[stage]]
name = "amplifier-lag"
tau_s = 0.004
[[stage]]
name = "hysteresis"
thresholds_v = [2.0, 5.0, 11.0]
weights = [1.4, 0.2, 0.15, 0.25]
beta_s = 0.0
[[stage]]
name = "congruency"
kappa = 0.002
[[stage]]
name = "asymmetry"
thresholds = { positive = [5.0, 10.0, 20.0, 30.0], negative = [12.0] }
slopes = { positive = [0.8, 0.03, -0.05, 0.04, -0.06], negative = [0.76, 0.1] }
[[stage]]
name = "quadratic"
q = 0.001
[[stage]]
name = "resonance"
f_n_hz = 60.0
zeta = 0.05
[[stage]]
name = "output"
gain_um_per_v = -0.6
offset_um = 30.0
[[stage]]
name = "mains-hum"
frequency_hz = 50.1
amplitude = 0.05
phase_rad = 0.4
"#;

fn own() -> ModelFile {
    model_file::parse(MODEL, "own.toml").unwrap()
}

/// With one stage more, or less.
fn with(model: &ModelFile, stage: Stage) -> ModelFile {
    let mut model = model.clone();
    model.stages.push(stage);
    model.stages.sort_by_key(Stage::place);
    model
}

fn without(model: &ModelFile, name: &str) -> ModelFile {
    let mut model = model.clone();
    model.stages.retain(|stage| stage.name() != name);
    model
}

fn creep() -> Stage {
    Stage::Creep(model_file::Creep {
        gain_per_decade: 0.02,
        tau_min_s: 0.05,
        tau_max_s: 0.5,
    })
}

/// Records of a model that starts each of them from rest at zero.
fn measured(model: &ModelFile, seed: u64) -> Dataset {
    const STAIRS: [f64; 8] = [0.0, 8.0, 16.0, 24.0, 16.0, 8.0, 0.0, -10.0];
    let mut noise = SmallRng::seed_from_u64(seed);
    let mut record = |name: &str, role, drive: &dyn Fn(f64) -> f64| {
        let time_s: Vec<f64> = (0..2500).map(|k| k as f64 * H).collect();
        let drive_v: Vec<f64> = time_s.iter().map(|&t| drive(t)).collect();
        let mut displacement_um = stage::displacement(model, H, &drive_v).unwrap();
        for y in &mut displacement_um {
            // Twelve uniform draws have a variance of one.
            let sum: f64 = (0..12).map(|_| noise.random_range(-0.5..0.5)).sum();
            *y += NOISE_UM * sum;
        }
        Record {
            name: name.to_owned(),
            role,
            start_s: 0.0,
            sample_time_s: H,
            time_s,
            drive_v,
            displacement_um,
            continues: None,
        }
    };
    let tone = |hz: f64, t: f64| (TAU * hz * t).sin();
    Dataset {
        name: "own".to_owned(),
        output_unit: LengthUnit::Micrometre,
        zero: Zero::Shared,
        input_zero: Zero::Shared,
        records: vec![
            record("loops", Role::Fit, &|t| {
                25.0 * (t / 2.5) * tone(1.7, t) + 4.0 * tone(31.0, t)
            }),
            record("stairs", Role::Fit, &|t| STAIRS[(3.2 * t) as usize % 8]),
            record("mixed", Role::Select, &|t| {
                18.0 * tone(0.6, t) + 9.0 * tone(2.3, t)
            }),
            record("held out", Role::Report, &|t| {
                22.0 * tone(0.5, t) + 5.0 * tone(11.0, t)
            }),
        ],
    }
}

/// Without the stages that cost a fit most.
fn light() -> ModelFile {
    without(&without(&own(), "asymmetry"), "mains-hum")
}

fn found(truth: &ModelFile, baseline: &ModelFile) -> Diagnosis {
    let options = Options {
        baseline: Baseline::Model(Box::new(baseline.clone())),
        library: LIBRARY.to_vec(),
        ..Options::default()
    };
    diagnose(&measured(truth, 7), &options, &|_| {}).unwrap()
}

fn names(found: &Diagnosis) -> Vec<Effect> {
    found.effects.iter().map(|one| one.effect).collect()
}

#[test]
fn the_true_model_leaves_the_noise_and_misses_nothing() {
    let found = found(&own(), &own());
    for rms in [
        found.baseline.fit,
        found.baseline.select,
        found.baseline.report,
    ] {
        let ratio = rms.unwrap() / NOISE_UM;
        assert!((0.95..1.05).contains(&ratio), "{:?}", found.baseline);
    }
    assert_eq!(found.verdict, Verdict::None, "{:?}", names(&found));
    assert!(found.effects.is_empty());
    assert_eq!(found.baseline_model, own());
}

#[test]
fn a_new_effect_is_named_and_those_of_the_model_are_not() {
    let found = found(&with(&light(), creep()), &light());
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence());
    assert_eq!(names(&found), [Effect::Creep]);
    assert!(found.closed().unwrap() > 0.9);
    let Some(Stage::Creep(creep)) = &found.effects[0].stage else {
        panic!("{:?}", found.effects);
    };
    assert!(
        (creep.gain_per_decade / 0.02 - 1.0).abs() < 0.2,
        "{creep:?}"
    );
    // All of it is in the extended model, which falls with the drive as well.
    for stage in light().effects() {
        let mut stages = found.model.stages.iter();
        assert!(
            stages.any(|one| one.name() == stage.name()),
            "{}",
            stage.name()
        );
    }
    assert!(found.model.output().0 < 0.0);
}

#[test]
fn wrong_numbers_are_no_missing_effect() {
    let mut other = light();
    for stage in &mut other.stages {
        match stage {
            Stage::Output(output) => output.gain_um_per_v *= 1.05,
            Stage::Resonance(mode) => mode.f_n_hz *= 1.02,
            _ => {}
        }
    }
    let found = found(&light(), &other);
    let refitted = found.refitted.unwrap().select.unwrap();
    assert!(found.baseline.select.unwrap() > 20.0 * NOISE_UM);
    assert!(refitted < 1.1 * NOISE_UM, "{refitted}");
    assert_eq!(found.verdict, Verdict::None, "{}", found.sentence());
    assert!(found.closed().unwrap() > 0.95);
}

/// Which of the two modes is the new one is for the refit to say: both must be there in the end.
#[test]
fn a_second_mode_is_named_beside_the_first() {
    let mode = Stage::Resonance(model_file::Resonance {
        f_n_hz: 140.0,
        zeta: 0.05,
    });
    let found = found(&with(&light(), mode), &light());
    assert_eq!(found.verdict, Verdict::Named, "{}", found.sentence());
    assert_eq!(names(&found), [Effect::Resonance]);
    let modes: Vec<f64> = found
        .model
        .stages
        .iter()
        .filter_map(|stage| match stage {
            Stage::Resonance(mode) => Some(mode.f_n_hz),
            _ => None,
        })
        .collect();
    assert_eq!(modes.len(), 2);
    for truth in [60.0, 140.0] {
        let near = |f: &f64| (f / truth - 1.0).abs() < 0.01;
        assert!(modes.iter().any(near), "{modes:?}");
    }
}

#[test]
fn models_that_no_fit_holds_are_refused_in_a_line() {
    let refusal = |model: &ModelFile| {
        let options = Options {
            baseline: Baseline::Model(Box::new(model.clone())),
            ..Options::default()
        };
        let refused = diagnose(&measured(&own(), 1), &options, &|_| {}).unwrap_err();
        refused.to_string()
    };
    let changed = |change: &dyn Fn(&mut Stage)| {
        let mut model = own();
        model.stages.iter_mut().for_each(change);
        model
    };
    let risen = changed(&|stage| {
        if let Stage::Output(output) = stage {
            output.gain_um_per_v = 0.6;
        }
    });
    assert!(refusal(&risen).contains("the other sign"));
    let negative = changed(&|stage| {
        if let Stage::Hysteresis(hysteresis) = stage {
            hysteresis.weights[2] = -0.1;
        }
    });
    assert!(refusal(&negative).contains("weight 2 is negative"));
    let impossible = changed(&|stage| {
        if let Stage::Resonance(mode) = stage {
            mode.zeta = 1.5;
        }
    });
    assert!(refusal(&impossible).contains("zeta"));
    for model in [risen, negative, impossible] {
        assert_eq!(refusal(&model).lines().count(), 1);
    }
}
