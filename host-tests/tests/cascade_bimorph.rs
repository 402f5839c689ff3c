//! The cascade on the simulated bimorph of paper M: Preisach relays, a mode, an even part behind it,
//! a held drive, noise. Its parameters come from `identify` on ten seconds of records.

use std::f64::consts::TAU;

use hysteron_host::dataset::{Dataset, LengthUnit, Record, Role, Zero};
use hysteron_host::identify::{Effect, Identification, Options, identify};
use hysteron_host::plant::bimorph::Bimorph;
use hysteron_host::stage;

const H: f64 = Bimorph::SAMPLE_TIME_S;
/// 2.5 s.
const SAMPLES: usize = 12_500;

/// Small tones up to 133 Hz on a slow large sine.
fn tones(start: f64) -> impl Fn(f64) -> f64 {
    move |t| {
        let tone = |q: i32| {
            let q = f64::from(q);
            0.03 * (TAU * 7.0 * q * t + start * q * q).sin()
        };
        3.0 * (TAU * 1.2 * t).sin() + (t / 0.2).min(1.0) * (1..=19).map(tone).sum::<f64>()
    }
}

fn records() -> Dataset {
    let slow = |t: f64| 5.0 * (1.0 - t / 2.6) * (TAU * 2.0 * t).sin();
    // From 8 to 60 Hz: its third harmonic sweeps across the mode.
    let sweep = |t: f64| 2.5 * (t / 0.2).min(1.0) * (TAU * (8.0 * t + 10.4 * t * t)).sin();
    let record = |name: &str, role, seed: u64, drive: &dyn Fn(f64) -> f64| {
        let time_s: Vec<f64> = (0..SAMPLES).map(|k| k as f64 * H).collect();
        let drive_v: Vec<f64> = time_s.iter().map(|&t| drive(t)).collect();
        let mut bimorph = Bimorph::pzba();
        bimorph.sensor.seed = seed;
        Record {
            name: name.to_owned(),
            role,
            start_s: 0.0,
            sample_time_s: H,
            displacement_um: bimorph.run(&drive_v, H).unwrap(),
            drive_v,
            time_s,
            continues: None,
        }
    };
    Dataset {
        name: "bimorph".to_owned(),
        output_unit: LengthUnit::Micrometre,
        zero: Zero::Shared,
        input_zero: Zero::Shared,
        records: vec![
            record("slow", Role::Fit, 1, &slow),
            record("tones", Role::Fit, 2, &tones(0.11)),
            record("sweep", Role::Fit, 3, &sweep),
            record("other tones", Role::Select, 4, &tones(0.31)),
        ],
    }
}

fn identified() -> Identification {
    let options = Options {
        effects: vec![
            Effect::AmplifierLag,
            Effect::TransportDelay,
            Effect::OutputQuadratic,
            Effect::Resonance,
        ],
        beta: Some(false),
        ..Options::default()
    };
    identify(&records(), &options, &|_| {}).unwrap()
}

#[test]
fn the_reference_is_followed_from_1_to_110_hz() {
    let begin = std::time::Instant::now();
    let found = identified();
    println!("{:?} {:?}", found.rms, begin.elapsed());
    println!("{:?}", found.model.parameters());
    let mut worst = 0.0f64;
    for f in [
        1.0, 5.0, 10.0, 15.0, 23.0, 25.0, 27.0, 35.0, 50.0, 65.0, 74.0, 80.0, 95.0, 110.0,
    ] {
        // 50 um, begun and ended over a fifth of a second.
        let samples = 15_000;
        let end = samples as f64 * H;
        let reference: Vec<f64> = (0..samples)
            .map(|k| {
                let t = k as f64 * H;
                let ease = |t: f64| {
                    let x = (t / 0.2).clamp(0.0, 1.0);
                    x * x * x * (10.0 + x * (6.0 * x - 15.0))
                };
                50.0 * ease(t) * ease(end - 0.3 - t) * (TAU * f * t).sin()
            })
            .collect();
        let drive = stage::drive_ahead(&found.model, H, &reference).unwrap();
        let leap = drive
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).abs())
            .fold(0.0, f64::max);
        let y = Bimorph::pzba().run(&drive, H).unwrap();
        let kept = 5_000..10_000;
        let square: f64 = kept.clone().map(|k| (y[k] - reference[k]).powi(2)).sum();
        let rmse_mm = 1e-3 * (square / kept.len() as f64).sqrt();
        let largest_v = drive.iter().fold(0.0f64, |a, u| a.max(u.abs()));
        println!(
            "{f:5} Hz: rmse {rmse_mm:.2e} mm, drive up to {largest_v:.2} V, steps to {leap:.3} V"
        );
        worst = worst.max(rmse_mm);
    }
    assert!(worst < 2e-3);
}
