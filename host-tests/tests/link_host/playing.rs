//! References played and recorded: what lies beside what, when it began, and how it ends when
//! something goes wrong.

use std::f64::consts::TAU;
use std::time::Duration;

use hysteron::control::Path;
use hysteron::link::Command;
use hysteron_host::error::Error;
use hysteron_host::link::model::{self, Choice};
use hysteron_host::link::{Client, Excitation, Shape, multisine, play};
use hysteron_host::model_file::builtin;
use hysteron_host::pil::{Bench, Hardware, Replica, Target, Ticked};
use hysteron_host::plant::{Hysteresis, Sensor, Stage};

use crate::support::{Fault, Line, bench, bench_with, client, message};

const H: f64 = 1e-4;
/// Step of the sensor's converter on the bench, um.
const SENSOR_STEP_UM: f64 = 120.0 / 4096.0;
/// Step of the bipolar converter behind the amplifier of ten, V.
const DRIVE_STEP_V: f64 = 100.0 / 65_536.0;

/// The stage with neither noise nor rounding: what is recorded is told by its drive alone.
fn quiet() -> Stage {
    Stage {
        sensor: Sensor::default(),
        dac: None,
        ..Stage::p753()
    }
}

fn at_rest(bench: &mut Bench<Replica>) {
    for _ in 0..2_000 {
        bench.tick().unwrap();
    }
    let last = bench.last().unwrap();
    assert_eq!((last.state, last.driver_enabled), (0, false), "{last:?}");
}

#[test]
fn a_recording_holds_drive_and_answer_side_by_side() {
    for samples in [37_u32, 2_500] {
        let mut bench = bench_with(&quiet());
        let before = {
            let mut client = client(&mut bench);
            let excitation = Excitation::drive(Shape::sine(0.0, 30.0, 80.0), samples);
            let played = play(&mut client, &excitation, true, &mut |_| {}).unwrap();
            assert_eq!(played.sample_time_s, 1.0 / f64::from(10_000.0_f32));
            let drive = &played.signals.drive_v;
            assert_eq!(drive.len(), samples as usize);
            for (k, u) in drive.iter().enumerate() {
                let asked = 30.0 * (TAU * 80.0 * k as f64 * H).sin();
                assert!((u - asked).abs() < 0.51 * DRIVE_STEP_V, "{k}: {u}, {asked}");
            }
            // The same stage driven apart from any target.
            let mut alone = quiet().start(H, 0.0).unwrap();
            for (u, y) in drive.iter().zip(&played.signals.displacement_um) {
                let truth = alone.step(*u).unwrap();
                assert!((y - truth).abs() < 0.51 * SENSOR_STEP_UM, "{y}, {truth}");
            }
            played.start_s
        };
        // Of the bench's own count of samples.
        let now = bench.samples() as f64 * H;
        let least = f64::from(samples) * H;
        assert!(before > 0.0 && before + least <= now, "{before} {now}");
    }
}

/// Notes the sample in which the drive first leaves zero.
struct Watched {
    replica: Replica,
    samples: u64,
    moved_at: Option<u64>,
}

impl Target for Watched {
    fn tick(&mut self, sensor: u16, late: bool) -> Result<Ticked, Error> {
        let ticked = self.replica.tick(sensor, late)?;
        if ticked.driver_enabled && ticked.code != 0x8000 && self.moved_at.is_none() {
            self.moved_at = Some(self.samples);
        }
        self.samples += 1;
        Ok(ticked)
    }

    fn chunk(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error> {
        self.replica.chunk(bytes)
    }
}

#[test]
fn the_start_is_timed_to_the_sample() {
    let watched = Watched {
        replica: Replica::power_on().unwrap(),
        samples: 0,
        moved_at: None,
    };
    let hardware = Hardware::paper_j().unwrap();
    let mut bench = Bench::new(watched, hardware, &quiet()).unwrap();
    let mut client = client(&mut bench);
    client.wait(Duration::from_millis(40)).unwrap();
    // Sample 0 is zero, sample 1 is not.
    let ramp: Vec<f64> = (0..2_000).map(|k| 0.01 * f64::from(k)).collect();
    let excitation = Excitation::streamed(Path::Direct, &ramp).unwrap();
    let played = play(&mut client, &excitation, false, &mut |_| {}).unwrap();
    assert!(played.signals.drive_v.is_empty());
    // Samples are numbered from 0 here and ticks from 1.
    let moved_at = bench.target().moved_at.unwrap();
    let start = played.start_s / H;
    assert!(
        (start - moved_at as f64).abs() < 1e-2,
        "{start}, {moved_at}"
    );
}

#[test]
fn streams_longer_than_the_queue_run_through() {
    let mut bench = bench();
    let mut client = client(&mut bench);
    let settings = client.settings().unwrap();
    let record = model::record(&builtin("p753").unwrap(), &settings, Choice::Explicit)
        .unwrap()
        .record;
    client.tell(Command::SetModel(Some(record))).unwrap();
    let reference: Vec<f64> = (0..5_000)
        .map(|k| 30.0 * (TAU * 10.0 * f64::from(k) * H).sin())
        .collect();
    let excitation = Excitation::streamed(Path::Compensated, &reference).unwrap();
    for _ in 0..2 {
        let mut told = Vec::new();
        let played = play(&mut client, &excitation, true, &mut |done| told.push(done)).unwrap();
        assert_eq!(played.signals.displacement_um.len(), reference.len());
        let error = hysteron_host::metrics::max_abs_error(
            &played.signals.displacement_um[1_000..],
            &reference[1_000..],
        )
        .unwrap();
        assert!(error < 2.5, "{error}");
        assert!(told.is_sorted() && told.last() == Some(&5_000));
    }
    let shape = multisine(0.0, 20.0, (5.0, 10), 7, (10_000.0, 3_000)).unwrap();
    let played = play(
        &mut client,
        &Excitation::drive(shape, 3_000),
        true,
        &mut |_| {},
    )
    .unwrap();
    let highest = played
        .signals
        .drive_v
        .iter()
        .fold(0.0, |a: f64, b| a.max(b.abs()));
    assert!((19.0..20.1).contains(&highest), "{highest}");
}

#[test]
fn what_cannot_be_played_is_refused_before_anything_moves() {
    let mut bench = bench();
    let mut client = client(&mut bench);
    let mut refuse = |excitation: &Excitation, says: &str| {
        let said = message(play(&mut client, excitation, true, &mut |_| {}));
        assert!(said.contains(says), "{said}");
        assert_eq!(client.statistics().unwrap().played, 0);
    };
    let sine = |offset, amplitude, hz| Shape::sine(offset, amplitude, hz);
    refuse(&Excitation::drive(sine(0.0, 51.0, 1.0), 9), "-51 V to 51 V");
    refuse(&Excitation::drive(sine(30.0, 21.0, 1.0), 9), "9 V to 51 V");
    refuse(&Excitation::drive(sine(0.0, 1.0, 1.0), 0), "no samples");
    refuse(&Excitation::drive(sine(0.0, 1.0, 9e3), 9), "frequency");
    let bad = Excitation::streamed(Path::Direct, &[0.0, 1e300]).unwrap();
    refuse(&bad, "sample 1");
    let compensated = Excitation::streamed(Path::Compensated, &[0.0; 9]).unwrap();
    refuse(&compensated, "no model");
}

#[test]
fn a_line_that_goes_silent_ends_in_an_error_and_at_rest() {
    let silent = Fault::Silence(Duration::from_millis(150), Duration::from_millis(3_000));
    let values = vec![0.0; 9_000];
    let streamed = Excitation::streamed(Path::Direct, &values).unwrap();
    let built = Excitation::drive(Shape::sine(0.0, 20.0, 10.0), 9_000);
    for excitation in [streamed, built] {
        let mut line = Line::new(bench());
        client(&mut line);
        line.fault = Some(silent);
        {
            let (mut client, _) = Client::connect(&mut line).unwrap();
            message(play(&mut client, &excitation, true, &mut |_| {}));
        }
        // The stage is at rest by itself or because it was told, and can be used again.
        at_rest(&mut line.bench);
        let (mut client, _) = Client::connect(&mut line).unwrap();
        let again = Excitation::drive(Shape::sine(0.0, 20.0, 10.0), 100);
        play(&mut client, &again, true, &mut |_| {}).unwrap();
    }
}

#[test]
fn lost_samples_and_a_clipped_sensor_make_no_record() {
    let mut line = Line::new(bench());
    client(&mut line);
    line.fault = Some(Fault::DamageReplies(40));
    {
        let (mut client, _) = Client::connect(&mut line).unwrap();
        let excitation = Excitation::drive(Shape::sine(0.0, 20.0, 10.0), 9_000);
        let said = message(play(&mut client, &excitation, true, &mut |_| {}));
        assert!(said.contains("were lost on the way"), "{said}");
    }
    line.fault = None;
    at_rest(&mut line.bench);

    // A stage that moves further than the sensor sees.
    let far = Hysteresis {
        gain_um_per_v: 2.0,
        ..quiet().hysteresis
    };
    let mut bench = bench_with(&Stage::ideal(far));
    {
        let mut client = client(&mut bench);
        let excitation = Excitation::drive(Shape::sine(0.0, 40.0, 10.0), 1_000);
        let said = message(play(&mut client, &excitation, true, &mut |_| {}));
        assert!(said.contains("end of its range"), "{said}");
    }
    at_rest(&mut bench);
}

#[test]
fn a_fault_is_told_and_cleared() {
    let mut bench = bench();
    let mut client = client(&mut bench);
    let settings = client.settings().unwrap();
    let record = model::record(&builtin("p753").unwrap(), &settings, Choice::Explicit)
        .unwrap()
        .record;
    client.tell(Command::SetModel(Some(record))).unwrap();
    // Finite, but not on its way through the compensator.
    let reference = Excitation::streamed(Path::Compensated, &[0.0, 1.0, 3e38, 0.0]).unwrap();
    let said = message(play(&mut client, &reference, false, &mut |_| {}));
    assert!(said.contains("fault") && said.contains("clear"), "{said}");
    let sine = Excitation::drive(Shape::sine(0.0, 5.0, 10.0), 100);
    let said = message(play(&mut client, &sine, false, &mut |_| {}));
    assert!(said.contains("fault"), "{said}");
    client.tell(Command::Clear).unwrap();
    client.wait(Duration::from_millis(1)).unwrap();
    play(&mut client, &sine, false, &mut |_| {}).unwrap();
}
