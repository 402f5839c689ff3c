//! The whole way: record a stage over the link, identify it, upload the model, run compensated.

use std::path::PathBuf;
use std::time::Duration;

use hysteron::control::Path;
use hysteron::link::Command;
use hysteron_host::dataset::{Dataset, NewRecord, Role, add_record};
use hysteron_host::experiment::references::{Grid, Tone, tones};
use hysteron_host::identify::{Options, identify};
use hysteron_host::link::model::{self, Choice};
use hysteron_host::link::{Client, Excitation, Shape, play};
use hysteron_host::metrics::rms_error;
use hysteron_host::model_file;
use hysteron_host::pil::{Bench, Emulator, Hardware, Pair, Replica, Target};
use hysteron_host::plant::Stage;

/// Time between samples of the bench in s.
const H: f64 = 1e-4;

/// Rms errors in um along the same reference: with the best straight line of the recorded data as the
/// drive, and through the compensator. The target comes back for further questions.
fn circle<T: Target>(target: T) -> (f64, f64, T) {
    let hardware = Hardware::paper_j().unwrap();
    // No model that the program knows: every constant of the published stage is 20 % off.
    let stage = Stage::p753_perturbed(0.2, 3);
    let mut bench = Bench::new(target, hardware, &stage).unwrap();
    let (mut client, _) = Client::connect(&mut bench).unwrap();
    client.wait(Duration::from_millis(1)).unwrap();
    client
        .tell(Command::SetSettings(hardware.settings))
        .unwrap();

    let folder = tempfile::tempdir().unwrap();
    let records = [
        ("slow", Role::Fit, Shape::sine(0.0, 38.0, 10.0)),
        ("fast", Role::Fit, Shape::sine(0.0, 38.0, 100.0)),
        ("triangle", Role::Select, Shape::triangle(0.0, 36.0, 40.0)),
        (
            "loops",
            Role::Report,
            Shape::two_tone(0.0, (18.0, 20.0), (18.0, 60.0)),
        ),
    ];
    for (stem, role, shape) in records {
        let played = play(
            &mut client,
            &Excitation::drive(shape, 3_000),
            true,
            &mut |_| {},
        )
        .unwrap();
        client.stop().unwrap();
        let new = NewRecord {
            stem,
            role,
            start_s: played.start_s,
            sample_time_s: played.sample_time_s,
            drive_v: &played.signals.drive_v,
            displacement_um: &played.signals.displacement_um,
        };
        assert_eq!(played.limited, 0);
        add_record(folder.path(), &new).unwrap();
    }

    let dataset = Dataset::load(folder.path()).unwrap();
    let options = Options {
        plays: Some(6),
        ..Options::default()
    };
    let found = identify(&dataset, &options, &|_| {}).unwrap();
    let file = folder.path().join("model.toml");
    std::fs::write(&file, found.model.to_toml_string()).unwrap();
    let loaded = model_file::load(&file).unwrap();
    let settings = client.settings().unwrap();
    let record = model::record(&loaded, &settings, Choice::Explicit)
        .unwrap()
        .record;
    client.tell(Command::SetModel(Some(record))).unwrap();

    // 60 um from peak to peak with minor loops, three periods of 0.1 s, the first not counted.
    let grid = Grid::for_duration(H, 0.3).unwrap();
    let lines = [Tone::new(18.0, 10.0), Tone::new(12.0, 70.0)];
    let reference = tones(&grid, &lines).unwrap().samples;
    let counted = 1_000..3_000;
    let (slope, offset) = line(&dataset);
    let straight: Vec<f64> = reference.iter().map(|um| (um - offset) / slope).collect();
    let mut error = |path, values: &[f64]| {
        let excitation = Excitation::streamed(path, values).unwrap();
        let played = play(&mut client, &excitation, true, &mut |_| {}).unwrap();
        let displacement = &played.signals.displacement_um[counted.clone()];
        rms_error(displacement, &reference[counted.clone()]).unwrap()
    };
    let without = error(Path::Direct, &straight);
    let with = error(Path::Compensated, &reference);
    (without, with, bench.into_target())
}

/// Slope (um/V) and offset (um) of the least-squares line through all records.
fn line(dataset: &Dataset) -> (f64, f64) {
    let points = || {
        dataset
            .records
            .iter()
            .flat_map(|record| record.drive_v.iter().zip(&record.displacement_um))
    };
    let n = points().count() as f64;
    let mean_u = points().map(|(u, _)| u).sum::<f64>() / n;
    let mean_y = points().map(|(_, y)| y).sum::<f64>() / n;
    let cross: f64 = points().map(|(u, y)| (u - mean_u) * (y - mean_y)).sum();
    let square: f64 = points().map(|(u, _)| (u - mean_u).powi(2)).sum();
    let slope = cross / square;
    (slope, mean_y - slope * mean_u)
}

fn assert_shrinks(without: f64, with: f64) {
    println!("rms error: {without:.3} um without, {with:.3} um with");
    assert!(without > 2.0, "there is nothing to compensate: {without}");
    assert!(with < without / 6.0, "{without} um, then {with} um");
}

#[test]
fn record_identify_upload_run_on_the_host() {
    let (without, with, _) = circle(Replica::power_on().unwrap());
    assert_shrinks(without, with);
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn record_identify_upload_run_in_the_emulator() {
    let elf = PathBuf::from(std::env::var_os("HYSTERON_FIRMWARE").expect("the firmware's ELF"));
    let emulator = Emulator::start(&elf).unwrap();
    let pair = Pair::new(emulator, Replica::power_on().unwrap());
    let (without, with, pair) = circle(pair);
    assert_eq!(pair.first_difference(), None);
    assert_shrinks(without, with);
}
