//! The fault campaign: what it must find, that it would find it, and what it once found.
//!
//! The part in the emulator runs by `scripts/check-firmware.sh`.

mod firmware_rig;
mod golden;

use std::path::PathBuf;
use std::process::Command as Program;

use firmware_rig::{Rig, bipolar, published, sine};
use hysteron::control::Path;
use hysteron::link::{Answer, CHUNK_LEN, Command, FRAME_LEN, Message, Refusal, encode};
use hysteron::reference::Waveform;
use hysteron::settings::Settings;
use hysteron_host::campaign::judge::{self, Judge};
use hysteron_host::campaign::{self, Failing, Outcome, ROUNDS, Subject};
use hysteron_host::error::Error;
use hysteron_host::pil::{Emulator, Pair, Replica, Target, Ticked};

fn held(outcome: &Outcome, each: u64) {
    assert!(outcome.failures.is_empty(), "{:#?}", outcome.failures);
    for row in &outcome.rows {
        assert!(row.injected >= each, "{}: {}", row.key, row.injected);
    }
}

#[test]
fn ten_thousand_faults_on_the_host() {
    let outcome = campaign::on_host(1, 110, &|| {}).unwrap();
    println!("{} faults, {} samples", outcome.injected(), outcome.samples);
    held(&outcome, 110 * ROUNDS as u64);
    assert!(outcome.injected() >= 10_000);
    assert_eq!(outcome.to_json(), golden::golden("faults"));
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn hundreds_of_faults_in_the_emulator() {
    let elf = std::env::var_os("HYSTERON_FIRMWARE").expect("HYSTERON_FIRMWARE names the ELF");
    let elf = PathBuf::from(elf);
    let start = || Ok(Pair::new(Emulator::start(&elf)?, Replica::power_on()?));
    let outcome = campaign::emulated(&start, 1, 4, &|| {}).unwrap();
    println!("{} faults, {} samples", outcome.injected(), outcome.samples);
    held(&outcome, 4);
    assert_eq!(
        outcome.rows.len(),
        campaign::Kind::ALL.len() + Failing::ALL.len()
    );
    assert_eq!(outcome.to_json(), golden::golden("faults-emulator"));
}

/// How a target is made to misbehave, for the judge to find.
#[derive(Clone, Copy, Debug)]
enum Wrong {
    Jump,
    BeyondRange,
    SampleLost,
    DriverStaysOn,
    Forgets,
    ReplyLost,
    SensorLeaks,
    MovesInHold,
}

/// A good target behind something that spoils what it does.
struct Doctored {
    replica: Replica,
    wrong: Wrong,
    samples: u64,
    last: u16,
}

impl Target for Doctored {
    fn tick(&mut self, sensor: u16, late: bool) -> Result<Ticked, Error> {
        let mut ticked = self.replica.tick(sensor, late)?;
        self.samples += 1;
        let now = self.samples.is_multiple_of(1_009);
        match self.wrong {
            Wrong::Jump if now => ticked.code ^= 0x0800,
            Wrong::BeyondRange if now => ticked.code = u16::MAX,
            // The sample before once more.
            Wrong::SampleLost if self.samples.is_multiple_of(53) && ticked.state == 2 => {
                ticked.code = self.last;
            }
            Wrong::DriverStaysOn => ticked.driver_enabled |= self.samples > 1_009,
            Wrong::Forgets if now => self.replica.restart()?,
            Wrong::SensorLeaks => ticked.code += u16::from(sensor > 60_000 && ticked.state == 2),
            Wrong::MovesInHold => ticked.code ^= u16::from(now && ticked.state == 1),
            _ => {}
        }
        self.last = ticked.code;
        Ok(ticked)
    }

    fn chunk(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error> {
        let heard = self.replica.chunk(bytes)?;
        let lost = matches!(self.wrong, Wrong::ReplyLost) && self.samples > 5_000;
        Ok(if lost { Vec::new() } else { heard })
    }
}

impl Subject for Doctored {
    fn reset(&mut self) -> Result<(), Error> {
        self.replica.restart()
    }
}

/// Every way to misbehave is found within a few runs, and named.
#[test]
fn the_judge_finds_what_is_wrong() {
    for (wrong, words) in [
        (Wrong::Jump, "moved by"),
        (Wrong::BeyondRange, "outside"),
        (Wrong::SampleLost, "of the acknowledged stream"),
        (Wrong::DriverStaysOn, "does not come to rest"),
        (Wrong::Forgets, "outside"),
        (Wrong::ReplyLost, "None after 0 others"),
        (Wrong::SensorLeaks, "depends on the sensor"),
        (Wrong::MovesInHold, "while it holds"),
    ] {
        let start = || {
            Ok(Doctored {
                replica: Replica::power_on()?,
                wrong,
                samples: 0,
                last: 0,
            })
        };
        let outcome = campaign::on(&start, 1, 8, &|| {}).unwrap();
        let named = |one: &campaign::Failure| one.what.contains(words);
        assert!(
            outcome.failures.iter().any(named),
            "{wrong:?}: {:#?}",
            outcome.failures
        );
    }
}

/// What was acknowledged and is told otherwise later does not go unseen.
#[test]
fn the_judge_misses_what_was_acknowledged() {
    let reply = |sequence, answer| {
        let mut frame = [0; FRAME_LEN];
        let len = encode(&Message::Reply { sequence, answer }, &mut frame).unwrap();
        frame[..len].to_vec()
    };
    let mut judge = Judge::new();
    let mut says = |sequence, command: Command, answer| {
        judge.asks(sequence, &command);
        judge.heard(&reply(sequence, answer)).map(drop)
    };
    let model = || Some(published());
    assert_eq!(says(1, Command::SetModel(model()), Answer::Done), Ok(()));
    assert_eq!(says(2, Command::GetModel, Answer::Model(model())), Ok(()));
    assert!(says(3, Command::GetModel, Answer::Model(None)).is_err());
    let settings = Answer::Settings(Settings::default());
    assert_eq!(says(4, Command::GetSettings, settings), Ok(()));
    assert!(says(5, Command::GetSettings, Answer::Settings(bipolar())).is_err());
    let chunk = |first| Command::Stream {
        first,
        samples: [1.0; CHUNK_LEN].into_iter().collect(),
    };
    let at = |next| Answer::Stream { next, free: 9 };
    assert_eq!(says(6, chunk(0), at(64)), Ok(()));
    assert!(says(7, chunk(64), at(63)).is_err());
    assert!(says(8, chunk(64), at(129)).is_err());
    let played = |codes: &[u16]| judge::played(&bipolar(), &[0.0, 1.0], codes);
    assert_eq!(played(&[32_768, 33_423]), Ok(()));
    assert!(played(&[32_768]).is_err());
    assert!(played(&[32_768, 32_768]).is_err());
}

/// Emptying a stream again in the sample after a swap once took eight acknowledged samples with it.
#[test]
fn a_stream_that_is_emptied_twice_keeps_what_came_after() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::ResetStream);
    for first in [0, 64, 128] {
        rig.stream(first, &[1.0; CHUNK_LEN]);
    }
    rig.tell(Command::ResetStream);
    rig.tell(Command::SetModel(Some(published())));
    // As a host does: again while the target is busy.
    let mut tries = 0;
    while rig.ask(Command::ResetStream) == Answer::Refused(Refusal::Busy) {
        rig.tick();
        tries += 1;
        assert!(tries < 40);
    }
    let samples: Vec<f32> = (0..64).map(|k| 0.1 * k as f32).collect();
    rig.stream(0, &samples);
    rig.ticks(40);
    rig.start(Path::Direct, Waveform::Stream);
    rig.ticks(64);
    assert_eq!(rig.statistics().played, 64);
    rig.tell(Command::Hold);
    rig.start(Path::Direct, sine(1.0, 50.0));
}

/// The files of a run, and the same seed again.
#[test]
fn the_command_writes_what_it_did_and_a_seed_repeats_it() {
    let folder = tempfile::tempdir().unwrap();
    let run = || {
        let out = folder.path().join("faults");
        let done = Program::new(env!("CARGO_BIN_EXE_hysteron"))
            .args(["faults", "--runs", "1", "--seed", "17", "--out"])
            .arg(&out)
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        std::fs::read_to_string(out.join("faults.json")).unwrap()
    };
    let first = run();
    let told: serde_json::Value = serde_json::from_str(&first).unwrap();
    assert_eq!(told["injected"], 92);
    assert_eq!(told["kinds"]["model_swap"], 4);
    assert_eq!(told["failures"], serde_json::json!([]));
    assert_eq!(first, run());
    let page = std::fs::read_to_string(folder.path().join("faults/report.html")).unwrap();
    for row in [
        "all of 92 faults",
        "stream that pauses",
        "model removed in motion",
    ] {
        assert!(page.contains(row), "{row}");
    }
}
