//! Records that are longer than what is worked on: condensed, fitted, and scored on every sample.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use hysteron_host::dataset::{Dataset, Role, long};
use hysteron_host::identify::whole;
use hysteron_host::output::AtomicFile;
use hysteron_host::plant::{Sensor, Stage};
use hysteron_host::{model_file, stage};

const STEP_S: f64 = 1e-4;

fn rows(samples: usize, drive: impl Fn(f64) -> f64, displacement: impl Fn(f64) -> f64) -> String {
    let mut text = "time_s,drive_v,displacement_um\n".to_owned();
    for k in 0..samples {
        let time = k as f64 * STEP_S;
        let u = drive(time);
        writeln!(text, "{time:.4},{u:.6},{:.6}", displacement(u)).unwrap();
    }
    text
}

fn column(text: &str, index: usize) -> Vec<f64> {
    let cell = |line: &str| line.split(',').nth(index).unwrap().parse().unwrap();
    text.lines().skip(1).map(cell).collect()
}

/// A slow drive is kept whole, in means; the parts go on from each other.
#[test]
fn means_are_means() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("slow.csv");
    let text = rows(40_000, |t| 30.0 * (TAU * t).sin(), |u| 0.7 * u);
    fs::write(&file, &text).unwrap();
    let told = std::cell::Cell::new(0);
    let loaded = long::load(&file, 10_000, &|_| told.set(told.get() + 1)).unwrap();
    assert!(told.get() >= 2);
    let long = loaded.long.unwrap();
    assert!(
        long.notes()[1].contains("means of 4 samples"),
        "{:?}",
        long.notes()
    );
    let records = &loaded.dataset.records;
    let lengths: Vec<usize> = records.iter().map(|r| r.drive_v.len()).collect();
    assert_eq!(lengths, [6_000, 2_000, 2_000]);
    assert_eq!(records[2].continues, Some(1));
    let all: [Vec<f64>; 3] = [0, 1, 2].map(|index| column(&text, index));
    let mean = |signal: &[f64], from: usize| signal[from..from + 4].iter().sum::<f64>() / 4.0;
    for (record, first) in records.iter().zip([0, 24_000, 32_000]) {
        assert!((record.sample_time_s / (4.0 * STEP_S) - 1.0).abs() < 1e-9);
        for k in [0, 1, 777, 1_999] {
            let from = first + 4 * k;
            for (kept, all) in [&record.time_s, &record.drive_v, &record.displacement_um]
                .iter()
                .zip(&all)
            {
                assert!((kept[k] - mean(all, from)).abs() < 1e-12, "{from}");
            }
        }
    }
    let whole: Vec<_> = long.files().collect();
    assert_eq!(whole[0].samples, 40_000);
    assert_eq!(whole[0].roles[1], (Role::Select, 24_000..32_000));
}

/// The first cycle is left out of a whole record's rms however long it is, and kept where none follows.
#[test]
fn the_first_cycle_is_not_scored() {
    let model = model_file::builtin("p753").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sine.npy");
    let chain = stage::chain(&model, STEP_S).unwrap();
    // A sine turns after a quarter and three quarters of its period.
    for (samples, period, first) in [
        (200_000, 100_000, 75_000),
        (100_000, 1_000, 750),
        (100_000, 80_000, 0),
    ] {
        let time: Vec<f64> = (0..samples).map(|k| k as f64 * STEP_S).collect();
        let phase = |k: usize| (k % period) as f64 / period as f64;
        let drive: Vec<f64> = (0..samples)
            .map(|k| 30.0 * (TAU * phase(k)).sin())
            .collect();
        let mut state = chain.start(drive[0]);
        let mut length: Vec<f64> = drive.iter().map(|&u| chain.step(&mut state, u)).collect();
        // Of which the score must know nothing, unless nothing is left out.
        length[first * 9 / 10..first]
            .iter_mut()
            .for_each(|y| *y += 7.0);
        let mut out = AtomicFile::create(&file).unwrap();
        let columns: [(&str, &[f64]); 3] = [
            ("time_s", &time),
            ("drive_v", &drive),
            ("displacement_um", &length),
        ];
        out.write_columns(&columns).unwrap();
        out.commit().unwrap();
        let long = long::load(&file, 8_000, &|_| ()).unwrap().long.unwrap();
        let scored = whole(&long, &model, &|_| ()).unwrap();
        assert_eq!(scored.samples, (samples - first) as u64);
        let rms = scored.rms.fit.unwrap();
        assert!(rms < 1e-6, "{rms} with a period of {period}");
    }
}

/// Few samples are loaded as ever.
#[test]
fn what_fits_is_not_touched() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("short.csv");
    fs::write(&file, rows(5_000, |t| (TAU * t).sin(), |u| u)).unwrap();
    let loaded = long::load(&file, 5_000, &|_| ()).unwrap();
    assert!(loaded.long.is_none());
    assert_eq!(loaded.dataset, Dataset::load(&file).unwrap());
}

/// A fast narrow motion on a slow wide one: stretches for the one, means of the whole for the other,
/// and the widest excursion, which comes once, is among them.
#[test]
fn fast_and_slow() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("both.csv");
    let drive = |t: f64| {
        let once = 20.0 * (-((t - 3.3) / 0.05).powi(2)).exp();
        20.0 * (TAU * 0.5 * t).sin() + (TAU * 150.0 * t).sin() + once
    };
    let text = rows(100_000, drive, |u| 0.7 * u);
    fs::write(&file, &text).unwrap();
    let loaded = long::load(&file, 8_000, &|_| ()).unwrap();
    let notes = loaded.long.unwrap().notes().join("\n");
    assert!(
        notes.contains("stretches") && notes.contains("over the whole"),
        "{notes}"
    );
    let records = &loaded.dataset.records;
    let kept: usize = records.iter().map(|record| record.drive_v.len()).sum();
    assert!((4_000..=9_000).contains(&kept), "{kept}: {notes}");
    let finest = records.iter().map(|r| r.sample_time_s).fold(1.0, f64::min);
    // 150 Hz still has more than thirty samples a period.
    assert!(finest < 1.0 / (30.0 * 150.0), "{finest}");
    for role in [Role::Fit, Role::Select, Role::Report] {
        assert!(loaded.dataset.with_role(role).count() >= 2);
    }
    let highest = |values: &[f64]| values.iter().copied().fold(f64::MIN, f64::max);
    let found = records
        .iter()
        .map(|r| highest(&r.drive_v))
        .fold(f64::MIN, f64::max);
    let truth = highest(&column(&text, 1));
    assert!(truth - found < 0.02 * truth, "{found} of {truth}");
}

/// A fault far down the file is refused at its line, as in a short file.
#[test]
fn faults_have_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bad.csv");
    let good = rows(20_000, |t| (TAU * t).sin(), |u| u);
    let lines: Vec<&str> = good.lines().collect();
    let spoilt = |at: usize, put: &str| {
        let mut lines = lines.clone();
        lines[at] = put;
        lines.join("\n")
    };
    let mut gap = lines.clone();
    gap.drain(12_000..12_003);
    let cases = [
        (
            spoilt(15_000, "1.4999,x,0"),
            "bad.csv:15001: column drive_v: \"x\" is not a number",
        ),
        (
            spoilt(15_000, "1.4999,0"),
            "bad.csv:15001: the row has 2 cells",
        ),
        (
            spoilt(15_000, lines[14_999]),
            "bad.csv:15001: column time_s: the time 1.4998 s is that",
        ),
        (
            gap.join("\n"),
            "bad.csv:12001: column time_s: the time steps by 0.0004 s here",
        ),
    ];
    for (text, wanted) in cases {
        fs::write(&file, text).unwrap();
        let short = Dataset::load(&file).unwrap_err().to_string();
        let long = long::load(&file, 4_096, &|_| ()).err().unwrap().to_string();
        for error in [short, long] {
            assert!(error.contains(wanted), "{error}");
        }
    }
    // A clock that runs ever faster: no step is far off its neighbours, the grid is.
    let mut text = "time_s,drive_v,displacement_um\n".to_owned();
    for k in 0..20_000 {
        let time = k as f64 * STEP_S * (1.0 + 1e-6 * k as f64);
        writeln!(text, "{time:.7},{},{}", (k % 50), (k % 50)).unwrap();
    }
    fs::write(&file, text).unwrap();
    let short = Dataset::load(&file).unwrap_err().to_string();
    let long = long::load(&file, 4_096, &|_| ()).err().unwrap().to_string();
    assert_eq!(short, long);
    assert!(short.contains("off a uniform grid"), "{short}");
}

fn hysteron(folder: &Path, kib: Option<u32>, arguments: &str) -> std::process::Output {
    let limit = kib.map_or(String::new(), |kib| format!("ulimit -v {kib}; "));
    Command::new("sh")
        .args([
            "-c",
            &format!("{limit}exec \"$0\" {arguments}"),
            env!("CARGO_BIN_EXE_hysteron"),
        ])
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Two million samples identified in an address space that they do not fit into, and the figures over
/// all of them against `simulate` and a sum in this test.
#[cfg(target_os = "linux")]
#[test]
fn two_million_samples_in_bounded_memory() {
    const SAMPLES: usize = 2_000_000;
    const KIB: u32 = 192 << 10;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let stage = Stage {
        dac: None,
        oversample: 1,
        amplifier_tau_s: 0.0,
        sensor: Sensor {
            noise_um: 0.02,
            ..Stage::p753().sensor
        },
        ..Stage::p753()
    };
    let mut plant = stage.start(STEP_S, 0.0).unwrap();
    let mut text = String::with_capacity(32 * SAMPLES);
    text.push_str("time_s,drive_v,displacement_um\n");
    let mut displacement = Vec::with_capacity(SAMPLES);
    for k in 0..SAMPLES {
        let time = k as f64 * STEP_S;
        let amplitude = 30.0 + 10.0 * (TAU * 0.07 * time).cos();
        let drive = format!("{:.4}", amplitude * (TAU * 0.5 * time).sin());
        let y = plant.step(drive.parse().unwrap()).unwrap();
        writeln!(text, "{time:.4},{drive},{y:.5}").unwrap();
        displacement.push(y);
    }
    fs::write(folder.join("long.csv"), text).unwrap();

    let all = hysteron(
        folder,
        Some(KIB),
        "identify long.csv --samples 9000000 --out all",
    );
    assert!(!all.status.success(), "the limit is none: {all:?}");
    let found = hysteron(
        folder,
        Some(KIB),
        "identify long.csv --samples 20000 --out found",
    );
    assert!(found.status.success(), "{found:?}");
    let json = fs::read_to_string(folder.join("found/identification.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();

    let simulated = hysteron(
        folder,
        None,
        "simulate --model found/model.toml --input long.csv --out model.csv",
    );
    assert!(simulated.status.success(), "{simulated:?}");
    let modelled = column(&fs::read_to_string(folder.join("model.csv")).unwrap(), 1);
    let residual: Vec<f64> = displacement
        .iter()
        .zip(&modelled)
        .map(|(y, m)| y - m)
        .collect();
    // The first cycle, 2 s, is not scored; it ends somewhere within its last quarter.
    let parts = [15_000..1_200_000, 1_200_000..1_600_000, 1_600_000..SAMPLES];
    let mean = residual[parts[0].clone()].iter().sum::<f64>() / parts[0].len() as f64;
    for (role, part) in ["fit", "select", "report"].iter().zip(parts) {
        let squares: f64 = residual[part.clone()]
            .iter()
            .map(|e| (e - mean).powi(2))
            .sum();
        let truth = (squares / part.len() as f64).sqrt();
        let told = json["whole"][role].as_f64().unwrap();
        assert!(
            (told / truth - 1.0).abs() < 2e-3,
            "{role}: {told} and {truth}"
        );
        // Not much is left over beside the noise of 0.02 um, of a stroke of 90 um.
        assert!(told < 0.06, "{role}: {told}");
    }
    let scored = json["whole"]["samples"].as_u64().unwrap() as usize;
    assert!((SAMPLES - 25_000..SAMPLES).contains(&scored), "{scored}");
}
