//! The preview inverse on plants that see the rate of their own drive.

mod preview_suite;

use hysteron::effect::asymmetry::{Asymmetry, Side};
use hysteron::error::{Field, ParameterError, SampleError};
use hysteron::hysteresis::Parameters;
use hysteron::hysteresis::preview::{PlantRate, PreviewInverse, PreviewSettings};
use hysteron::model::Model;

use preview_suite::{
    Preview, Rate, SHAPES, Shape, Stage, WINDOW, drive_of, errors, explicit, preview, reference,
    settings,
};

/// Worst largest and rms error over ten sampling phases.
fn worst(frequency: f64, rate: Rate, drive: impl Fn(&[f64]) -> Vec<f64>) -> (f64, f64) {
    let stage = Stage::p753();
    (0..10).fold((0.0f64, 0.0f64), |worst, phase| {
        let reference = reference(Shape::Sine, frequency, 1e-4, f64::from(phase) / 10.0);
        let displacement = stage.displacement(&drive(&reference), 1e-4, rate);
        let (largest, rms) = errors(&reference, &displacement, 1e-4);
        (worst.0.max(largest), worst.1.max(rms))
    })
}

#[test]
fn the_published_stage_with_the_rate_of_its_own_drive() {
    let stage = Stage::p753();
    let lines = Rate::Backward(20);
    let either = |frequency, drive: &dyn Fn(&[f64]) -> Vec<f64>| {
        [Rate::Forward, lines].map(|rate| worst(frequency, rate, drive))
    };
    // Largest and rms error with the rate of the step to come, and on a drive joined by lines.
    let free = (f64::INFINITY, f64::INFINITY);
    for (plant_rate, at_50_hz, at_100_hz) in [
        (
            PlantRate::Forward,
            [(0.001, 0.001), free],
            [(0.001, 0.001), free],
        ),
        (
            PlantRate::Midpoint,
            [(0.07, 0.04), (0.22, 0.06)],
            [(0.2, 0.12), (0.46, 0.17)],
        ),
        (
            PlantRate::Backward,
            [free, (0.18, 0.025)],
            [free, (0.45, 0.1)],
        ),
    ] {
        for (frequency, limits) in [(50.0, at_50_hz), (100.0, at_100_hz)] {
            let found = either(frequency, &|v| {
                preview(&stage, v, 1e-4, plant_rate).unwrap()
            });
            println!("{plant_rate:?}, {frequency} Hz: {found:.4?}");
            for (found, limit) in found.iter().zip(limits) {
                assert!(
                    found.0 <= limit.0 && found.1 <= limit.1,
                    "{found:?} {limit:?}"
                );
            }
        }
    }
    for frequency in [50.0, 100.0] {
        let without = either(frequency, &|v| explicit(&stage, v, 1e-4));
        println!("explicit, {frequency} Hz: {without:.4?}");
        assert!(without.iter().all(|found| found.0 > 1.0), "{without:?}");
    }
}

/// What the preview inverse is compared on.
struct Suite {
    stages: Vec<Stage>,
    sample_rates: Vec<f64>,
    frequencies: Vec<f64>,
    phases: Vec<f64>,
}

/// How often it is worse than the explicit inverse.
#[derive(Debug, Default)]
struct Tally {
    compared: usize,
    refused: usize,
    largest: usize,
    rms: usize,
}

fn tally(suite: &Suite, rate: Rate, plant_rate: PlantRate) -> Tally {
    let mut tally = Tally::default();
    for (at, stage) in suite.stages.iter().enumerate() {
        for &sample_rate in &suite.sample_rates {
            let sample_time = 1.0 / sample_rate;
            for (shape, &frequency) in SHAPES
                .iter()
                .flat_map(|&shape| suite.frequencies.iter().map(move |f| (shape, f)))
            {
                // Seven harmonics need samples, and slow references take their time.
                if frequency > sample_rate / 100.0 || frequency < sample_rate / 1e4 {
                    continue;
                }
                for &phase in &suite.phases {
                    let reference = reference(shape, frequency, sample_time, phase);
                    let Some(with) = preview(stage, &reference, sample_time, plant_rate) else {
                        tally.refused += 1;
                        continue;
                    };
                    let error = |drive: &[f64]| {
                        let out = stage.displacement(drive, sample_time, rate);
                        errors(&reference, &out, sample_time)
                    };
                    let with = error(&with);
                    let without = error(&explicit(stage, &reference, sample_time));
                    let worse = (with.0 > without.0 + 1e-6, with.1 > without.1 + 1e-6);
                    tally.compared += 1;
                    tally.largest += usize::from(worse.0);
                    tally.rms += usize::from(worse.1);
                    if worse.0 || worse.1 {
                        println!(
                            "stage {at}, {sample_rate} Hz, {shape:?} {frequency} Hz, phase \
                             {phase}, {rate:?}: preview {with:.4?}, explicit {without:.4?}"
                        );
                    }
                }
            }
        }
    }
    println!("{plant_rate:?}: {tally:?}");
    tally
}

fn stages() -> Vec<Stage> {
    let others = [
        (1, 8e-4),
        (3, 0.0),
        (3, 1e-4),
        (5, 3e-3),
        (10, 7e-4),
        (16, 1.5e-3),
    ];
    let others = others.map(|(n, beta)| Stage::of(n, beta));
    std::iter::once(Stage::p753()).chain(others).collect()
}

/// Whether all of the suite is wanted: `HYSTERON_WHOLE_SUITE=1 cargo test --release -p hysteron-host --test
/// core_preview explicit_inverse -- --nocapture` takes ten minutes.
fn whole() -> bool {
    std::env::var_os("HYSTERON_WHOLE_SUITE").is_some()
}

/// The suite, or a part of it that takes seconds.
fn suite() -> Suite {
    if whole() {
        Suite {
            stages: stages(),
            sample_rates: vec![5e3, 1e4, 2e4, 5e4],
            frequencies: vec![1.0, 10.0, 40.0, 100.0, 200.0],
            phases: (0..10).map(|phase| f64::from(phase) / 10.0).collect(),
        }
    } else {
        Suite {
            stages: stages(),
            sample_rates: vec![5e3, 2e4],
            frequencies: vec![40.0, 200.0],
            phases: vec![0.0, 0.37],
        }
    }
}

/// On a plant that sees the step that led to a sample, single samples at which that step changes at
/// once may be worse; `docs/preview.md` says where.
#[test]
fn not_worse_than_the_explicit_inverse() {
    let suite = suite();
    let exact = tally(&suite, Rate::Forward, PlantRate::Forward);
    assert_eq!((exact.largest, exact.rms), (0, 0));
    let lines = tally(&suite, Rate::Backward(20), PlantRate::Backward);
    if whole() {
        assert!(lines.largest * 50 <= lines.compared, "{lines:?}");
        assert!(lines.rms * 1000 <= lines.compared, "{lines:?}");
    } else {
        assert_eq!((exact.refused, lines.refused, lines.rms), (0, 0, 0));
        assert!(lines.largest * 20 <= lines.compared, "{lines:?}");
    }
}

#[test]
fn the_midpoint_is_seldom_worse_than_the_explicit_inverse() {
    for rate in [Rate::Forward, Rate::Backward(20)] {
        let tally = tally(&suite(), rate, PlantRate::Midpoint);
        assert!(tally.largest * 10 <= tally.compared, "{tally:?}");
        assert!(tally.rms * 25 <= tally.compared, "{tally:?}");
    }
}

#[test]
fn without_a_rate_term_it_is_the_explicit_inverse() {
    let stage = Stage::of(7, 0.0);
    let reference = reference(Shape::TwoTone, 13.0, 1e-4, 0.3);
    for plant_rate in [PlantRate::Forward, PlantRate::Midpoint, PlantRate::Backward] {
        let with = preview(&stage, &reference, 1e-4, plant_rate).unwrap();
        for (a, b) in with.iter().zip(explicit(&stage, &reference, 1e-4)) {
            assert!((a - b).abs() < 1e-11, "{plant_rate:?}: {a} {b}");
        }
    }
}

/// (P 4): what lies beyond the window is forgotten within it.
#[test]
fn a_longer_window_changes_nothing() {
    let model = Stage::p753().model(1e-4);
    let settings = settings(&model, PlantRate::Forward);
    let window = 4 * settings.window;
    let [short, long] = [settings, PreviewSettings { window, ..settings }]
        .map(|settings| Preview::new(&model, settings).unwrap());
    let reference = reference(Shape::Multisine, 20.0, 1e-4, 0.1);
    let [short, long] = [short, long].map(|preview| drive_of(&preview, &reference));
    for (a, b) in short.iter().zip(&long).skip(10) {
        assert!((a - b).abs() < 0.01, "{a} {b}");
    }
}

#[test]
fn the_compensator_inverts_the_whole_stage() {
    let side = |slopes, thresholds| Side { slopes, thresholds };
    let map = Asymmetry::<f64, 4>::new(
        side(&[1.0, 0.1, -0.05], &[10.0, 25.0]),
        side(&[0.9, 0.2], &[15.0]),
    )
    .unwrap();
    let operator = Stage::p753().model(1e-4);
    let model = Model::new(operator, Some(map), -0.8, 3.0).unwrap();
    let settings = settings(&operator, PlantRate::Forward);
    let compensator = model.preview_compensator::<WINDOW>(settings).unwrap();
    let reference: Vec<f64> = reference(Shape::Sine, 50.0, 1e-4, 0.2)
        .iter()
        .map(|v| 3.0 + 0.6 * v)
        .collect();
    let mut state = Box::new(compensator.start(reference[0]).unwrap());
    let before = compensator.step(&mut state, f64::NAN);
    assert_eq!(before, Err(SampleError::NotFinite));
    let latency = compensator.latency();
    let drive: Vec<f64> = reference
        .iter()
        .map(|&v| compensator.step(&mut state, v).unwrap())
        .skip(latency)
        .collect();
    let mut stage = model.start(drive[0]);
    for (pair, wanted) in drive.windows(2).zip(&reference) {
        let came = model.step_with_rate(&mut stage, pair[0], (pair[1] - pair[0]) / 1e-4);
        assert!((came - wanted).abs() < 0.01, "{came} {wanted}");
    }
}

#[test]
fn single_precision_is_enough() {
    let stage = Stage::p753();
    let weights = [0.7236f32, 0.2906, 0.0416, 0.1512];
    let single = Parameters {
        weights: &weights,
        thresholds: &[9.715, 19.43, 29.145],
        beta: 8.572e-4,
    };
    let single = single.build::<3>(1e-4).unwrap();
    let double = stage.model(1e-4);
    let reference = reference(Shape::TwoTone, 13.0, 1e-4, 0.3);
    for plant_rate in [PlantRate::Forward, PlantRate::Backward] {
        let settings = settings(&double, plant_rate);
        let single = PreviewInverse::<f32, 3, 32>::new(&single, settings).unwrap();
        let mut state = single.start(reference[0] as f32);
        let drives = reference.iter().map(|&v| single.step(&mut state, v as f32));
        let truth = drive_of(&Preview::new(&double, settings).unwrap(), &reference);
        for (a, b) in drives.skip(single.latency()).zip(truth) {
            assert!((f64::from(a) - b).abs() < 0.02, "{plant_rate:?}: {a} {b}");
        }
    }
}

#[test]
fn refuses_what_has_no_preview_inverse() {
    let settings = PreviewSettings {
        window: 16,
        sweeps: 1,
        plant_rate: PlantRate::Forward,
    };
    let model = Stage::p753().model(1e-4);
    for wrong in [
        PreviewSettings {
            window: 1,
            ..settings
        },
        PreviewSettings {
            window: WINDOW + 1,
            ..settings
        },
        PreviewSettings {
            sweeps: 0,
            ..settings
        },
    ] {
        let refused = Preview::new(&model, wrong);
        assert_eq!(refused.unwrap_err(), ParameterError::Length(Field::Preview));
    }
    // A_1 = a_0 / 2: well-posed while beta < h / 2 (P 4).
    let falling = |beta| Stage {
        weights: vec![1.0, -0.5],
        thresholds: vec![5.0],
        beta,
    };
    assert!(Preview::new(&falling(0.49e-4).model(1e-4), settings).is_ok());
    assert_eq!(
        Preview::new(&falling(0.51e-4).model(1e-4), settings).unwrap_err(),
        ParameterError::RateTooStrong(1)
    );
}
