//! Effects fitted together with the hysteresis. The truth is integrated here: plays as loops over a
//! formula, mechanics by the classical fourth-order method, nothing of the core.

use std::f64::consts::TAU;

use hysteron_host::dataset::{Dataset, LengthUnit, Record, Role, Zero};
use hysteron_host::identify::{Effect, Identification, Options, identify};
use hysteron_host::model_file::Stage;

const H: f64 = 2e-4;

/// What the truth consists of, beside the plays.
#[derive(Clone, Copy, Default)]
struct Truth {
    lag_s: f64,
    delay_s: f64,
    even: f64,
    odd: f64,
    mode: Option<(f64, f64)>,
}

impl Truth {
    /// Displacement in um for a drive in V that is zero before its first sample.
    fn displacement(&self, drive: impl Fn(f64) -> f64, samples: usize) -> Vec<f64> {
        const FINE: usize = 40;
        let d = H / FINE as f64;
        let (mut lagged, mut y, mut v) = (0.0, 0.0, 0.0);
        let mut plays = [0.0f64; 12];
        let mut out = Vec::new();
        for step in 0..samples * FINE {
            let t = step as f64 * d;
            let u = drive((t - self.delay_s).max(0.0));
            lagged = if self.lag_s > 0.0 {
                u + (lagged - u) * (-d / self.lag_s).exp()
            } else {
                u
            };
            let mut w = 1.2 * lagged;
            for (i, z) in plays.iter_mut().enumerate() {
                let r = 0.3 * (i + 1) as f64;
                *z = z.min(lagged + r).max(lagged - r);
                w += 0.05 * *z;
            }
            let x = w + self.even * w * w + self.odd * w * w * w;
            match self.mode {
                None => y = x,
                Some((f_n, zeta)) => {
                    let w_n = TAU * f_n;
                    let acceleration = |y: f64, v: f64| w_n * w_n * (x - y) - 2.0 * zeta * w_n * v;
                    let (k1, l1) = (v, acceleration(y, v));
                    let (k2, l2) = (
                        v + 0.5 * d * l1,
                        acceleration(y + 0.5 * d * k1, v + 0.5 * d * l1),
                    );
                    let (k3, l3) = (
                        v + 0.5 * d * l2,
                        acceleration(y + 0.5 * d * k2, v + 0.5 * d * l2),
                    );
                    let (k4, l4) = (v + d * l3, acceleration(y + d * k3, v + d * l3));
                    y += d / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
                    v += d / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
                }
            }
            if step % FINE == 0 {
                out.push(y);
            }
        }
        out
    }

    /// Slow loops of falling amplitude, and tones up to 210 Hz on top of a slow sine: 8 s in all.
    fn dataset(&self) -> Dataset {
        let slow =
            |amplitude: f64| move |t: f64| amplitude * (1.0 - t / 2.4) * (TAU * 2.5 * t).sin();
        let tones = |start: f64| {
            move |t: f64| {
                let ramp = (t / 0.2).min(1.0);
                let tone = |q: i32| {
                    let q = f64::from(q);
                    (TAU * (7.0 * q) * t + start * q * q).sin()
                };
                ramp * (2.0 * (TAU * 1.5 * t).sin() + 0.12 * (1..=30).map(tone).sum::<f64>())
            }
        };
        let record = |name: &str, role, drive: &dyn Fn(f64) -> f64| {
            let samples = 10_000;
            // A different least significant figure in each sample, as a sensor has.
            let mut noise = 12345u32;
            let displacement_um = self
                .displacement(drive, samples)
                .into_iter()
                .map(|y| {
                    noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    y + 0.01 * (f64::from(noise >> 8) / f64::from(1 << 24) - 0.5)
                })
                .collect();
            let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * H).collect();
            Record {
                name: name.to_owned(),
                start_s: 0.0,
                role,
                sample_time_s: H,
                drive_v: time_s.iter().map(|&t| drive(t)).collect(),
                time_s,
                displacement_um,
                continues: None,
            }
        };
        Dataset {
            name: "hidden".to_owned(),
            output_unit: LengthUnit::Micrometre,
            zero: Zero::Shared,
            input_zero: Zero::Shared,
            records: vec![
                record("slow", Role::Fit, &slow(5.0)),
                record("tones", Role::Fit, &tones(0.11)),
                record("other tones", Role::Select, &tones(0.23)),
                record("held out", Role::Report, &tones(0.4)),
            ],
        }
    }
}

fn identified(truth: Truth, effects: &[Effect]) -> Identification {
    let options = Options {
        effects: effects.to_vec(),
        beta: Some(false),
        ..Options::default()
    };
    identify(&truth.dataset(), &options, &|_| {}).unwrap()
}

fn number(found: &Identification, key: &str) -> f64 {
    found.model.parameters()[key].as_f64().unwrap()
}

fn assert_near(what: &str, value: f64, truth: f64, share: f64) {
    assert!(
        (value / truth - 1.0).abs() < share,
        "{what}: {value}, not {truth}"
    );
}

#[test]
fn a_mode_with_even_curvature() {
    let truth = Truth {
        even: 4e-3,
        mode: Some((74.0, 0.02)),
        ..Truth::default()
    };
    let found = identified(truth, &[Effect::Resonance, Effect::Quadratic]);
    println!("{:?} {:?}", found.rms, found.line_rms);
    println!("{:?}", found.model.parameters());
    assert_near("f_n", number(&found, "resonance.f_n_hz"), 74.0, 1e-3);
    assert_near("zeta", number(&found, "resonance.zeta"), 0.02, 0.03);
    // In volts: the gain of the stage is the sum of its weights.
    let gain = found.model.output().0;
    assert_near("q", number(&found, "quadratic.q"), 4e-3 * gain, 0.03);
    assert!(found.rms.report.unwrap() < 0.02);
}

#[test]
fn a_lag_with_odd_curvature() {
    let truth = Truth {
        lag_s: 8e-4,
        odd: 5e-4,
        ..Truth::default()
    };
    let found = identified(truth, &[Effect::AmplifierLag, Effect::Cubic]);
    println!("{:?} {:?}", found.rms, found.line_rms);
    assert_near("tau", number(&found, "amplifier-lag.tau_s"), 8e-4, 0.03);
    let gain = found.model.output().0;
    assert_near("c", number(&found, "cubic.c"), 5e-4 * gain * gain, 0.05);
    assert!(found.rms.report.unwrap() < 0.02);
}

#[test]
fn a_delay() {
    let truth = Truth {
        delay_s: 5.3e-4,
        ..Truth::default()
    };
    let found = identified(truth, &[Effect::TransportDelay]);
    println!("{:?} {:?}", found.rms, found.line_rms);
    assert_near(
        "delay",
        number(&found, "transport-delay.delay_s"),
        5.3e-4,
        0.03,
    );
    assert!(found.rms.report.unwrap() < 0.02);
    // Without it the model does far worse.
    let without = identified(truth, &[Effect::Quadratic]);
    assert!(without.rms.report.unwrap() > 3.0 * found.rms.report.unwrap());
}

#[test]
fn the_model_file_holds_the_stages_in_order() {
    let found = identified(
        Truth {
            mode: Some((74.0, 0.05)),
            ..Truth::default()
        },
        &[Effect::Resonance, Effect::AmplifierLag],
    );
    let names: Vec<_> = found.model.stages.iter().map(Stage::name).collect();
    assert_eq!(
        names,
        ["amplifier-lag", "hysteresis", "resonance", "output"]
    );
    let text = found.model.to_toml_string();
    let parsed = hysteron_host::model_file::parse(&text, "model.toml").unwrap();
    assert_eq!(parsed, found.model);
}
