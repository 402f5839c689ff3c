//! The firmware itself, in QEMU: every code equals that of the host's replica, bit for bit, and a
//! failing program leaves the converter safe.
//!
//! `scripts/check-firmware.sh` builds the firmware and runs this with `HYSTERON_FIRMWARE` naming it.

mod firmware_rig;

use std::io::{Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command as Process, Stdio};

use firmware_rig::{Rig, bipolar, model, published, sine};
use hysteron::control::Path;
use hysteron::link::{Command, FRAME_LEN};
use hysteron::reference::{Tone, Waveform};
use hysteron::safety::State;
use hysteron::settings::Settings;

const NEEDS: &str = "HYSTERON_FIRMWARE names the ELF; scripts/check-firmware.sh builds and runs";

/// Most link bytes in one response.
const PAYLOAD_LEN: usize = 2048;

struct Emulator {
    process: Child,
    requests: Option<ChildStdin>,
    responses: ChildStdout,
}

#[derive(Debug, PartialEq)]
struct Response {
    kind: u8,
    state: u8,
    code: u16,
    driver_enabled: bool,
    count: u32,
    payload: Vec<u8>,
}

impl Emulator {
    fn start() -> Self {
        let elf = std::env::var("HYSTERON_FIRMWARE").expect(NEEDS);
        let mut process = Process::new("qemu-system-arm")
            .args([
                "-M",
                "netduinoplus2",
                "-nographic",
                "-monitor",
                "none",
                "-serial",
                "none",
            ])
            .args(["-semihosting-config", "enable=on,target=native"])
            .args(["-icount", "shift=0,sleep=off", "-kernel", &elf])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("qemu-system-arm starts");
        let requests = process.stdin.take();
        let responses = process.stdout.take().unwrap();
        Self {
            process,
            requests,
            responses,
        }
    }

    fn send(&mut self, kind: u8, len: u8, value: u16, payload: &[u8]) {
        let [low, high] = value.to_le_bytes();
        let mut bytes = vec![kind, len, low, high];
        bytes.extend_from_slice(payload);
        self.requests.as_mut().unwrap().write_all(&bytes).unwrap();
    }

    fn response(&mut self) -> Response {
        let mut header = [0; 12];
        self.responses.read_exact(&mut header).unwrap();
        let [kind, state, c0, c1, enabled, _, l0, l1, rest @ ..] = header;
        let mut payload = vec![0; usize::from(u16::from_le_bytes([l0, l1]))];
        self.responses.read_exact(&mut payload).unwrap();
        Response {
            kind,
            state,
            code: u16::from_le_bytes([c0, c1]),
            driver_enabled: enabled == 1,
            count: u32::from_le_bytes(rest),
            payload,
        }
    }

    fn tick(&mut self, late: bool) -> Response {
        self.send(if late { b'O' } else { b'T' }, 0, 1234, &[]);
        self.response()
    }

    /// Link bytes there, and what comes back.
    fn link(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut answer = Vec::new();
        for chunk in bytes.chunks(255) {
            self.send(b'L', chunk.len() as u8, 0, chunk);
            answer.extend(self.response().payload);
        }
        answer
    }

    /// Exit code and what was said on the error stream.
    fn end(mut self) -> (Option<i32>, String) {
        drop(self.requests.take());
        let output = self.process.wait_with_output().unwrap();
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    }
}

/// Emulator and replica side by side.
struct Pair {
    emulator: Emulator,
    rig: Rig,
    counts: Vec<u32>,
}

impl Pair {
    fn new() -> Self {
        let mut pair = Self {
            emulator: Emulator::start(),
            rig: Rig::new(Settings::default()),
            counts: Vec::new(),
        };
        pair.emulator.tick(false);
        pair
    }

    /// The same command to both; the same bytes have to come back.
    fn tell(&mut self, command: Command) {
        let frame = self.rig.frame(command);
        let there = self.emulator.link(&frame);
        let mut here = Vec::new();
        for byte in frame {
            here.extend_from_slice(self.rig.server.receive(byte).unwrap_or(&[]));
        }
        while here.len() + FRAME_LEN <= PAYLOAD_LEN
            && let Some(recorded) = self.rig.server.recorded(false)
        {
            here.extend_from_slice(recorded);
        }
        assert!(here == there, "{} and {} bytes", here.len(), there.len());
        self.ticks(1);
    }

    fn ticks(&mut self, count: usize) {
        for _ in 0..count {
            let there = self.emulator.tick(false);
            let here = self.rig.control.tick(1234, false);
            assert_eq!(
                (there.code, there.driver_enabled),
                (here.code, here.driver_enabled)
            );
            self.counts.push(there.count);
        }
    }

    fn start(&mut self, path: Path, waveform: Waveform) {
        self.tell(Command::Start {
            path,
            waveform,
            samples: 0,
        });
    }

    fn wide(&mut self) {
        self.tell(Command::SetSettings(Settings {
            drive_min_v: -50.0,
            drive_max_v: 50.0,
            slew_v_per_s: 1e6,
            ..bipolar()
        }));
    }
}

fn references() -> Vec<Waveform> {
    let tone = |amplitude, frequency_hz| Tone {
        amplitude,
        frequency_hz,
    };
    vec![
        sine(30.0, 10.0),
        sine(30.0, 50.0),
        sine(30.0, 100.0),
        Waveform::Triangle {
            offset: 0.0,
            tone: tone(30.0, 50.0),
        },
        Waveform::Tones {
            offset: 0.0,
            tones: [tone(14.0, 20.0), tone(16.0, 60.0)],
        },
    ]
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn target_and_host_agree_bit_for_bit_within_the_budget() {
    let mut pair = Pair::new();
    pair.wide();
    let thresholds: Vec<f32> = (1..=10).map(|i| 2.5 * i as f32).collect();
    let mut weights = vec![0.7236];
    weights.extend((1..=10).map(|i| 0.12 * (-0.1 * i as f32).exp()));
    let ten = model(&thresholds, &weights, 8.572e-4, 1.1);
    // Most instructions of a sample, from the request of the interrupt to the return from it, with the
    // bipolar converter, a recording and an order in the same sample.
    for (name, record, most) in [("n = 3", published(), 470), ("n = 10", ten, 580)] {
        pair.tell(Command::SetModel(Some(record)));
        pair.counts.clear();
        for waveform in references() {
            for path in [Path::Compensated, Path::Direct] {
                pair.start(path, waveform);
                pair.tell(Command::Record { every: 1 });
                pair.ticks(4_000);
                pair.tell(Command::Hold);
            }
        }
        let mut counts = pair.counts.clone();
        counts.sort_unstable();
        let (median, worst) = (counts[counts.len() / 2], counts[counts.len() - 1]);
        println!(
            "whole interrupt, {name}: {} to {worst} instructions, median {median}",
            counts[0]
        );
        assert!(worst <= most, "{worst} instructions in the worst sample");
    }
    assert_eq!(pair.rig.control.safety().state(), State::Hold);
    pair.emulator.send(b'S', 0, 0, &[]);
    println!("stack: {} bytes", pair.emulator.response().count);
    assert_eq!(pair.emulator.end(), (Some(0), String::new()));
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn late_samples_are_a_fault_that_ends_safe_and_recovers() {
    let mut pair = Pair::new();
    pair.wide();
    pair.start(Path::Direct, sine(30.0, 10.0));
    pair.ticks(250);
    for _ in 0..4 {
        assert_eq!(
            pair.emulator.tick(true).code,
            pair.rig.control.tick(1234, true).code
        );
    }
    pair.ticks(300);
    let response = pair.emulator.tick(false);
    assert_eq!(
        (response.state, response.code, response.driver_enabled),
        (3, 0x8000, false)
    );
    pair.rig.control.tick(1234, false);
    pair.tell(Command::Clear);
    pair.start(Path::Direct, sine(30.0, 10.0));
    pair.ticks(1_000);
    assert_eq!(pair.emulator.end().0, Some(0));
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn a_program_that_fails_leaves_the_converter_safe() {
    for (kind, says) in [(b'P', "forced"), (b'H', "hard fault")] {
        let mut pair = Pair::new();
        pair.wide();
        pair.start(Path::Direct, sine(30.0, 10.0));
        pair.ticks(250);
        assert!(pair.rig.last.code != 0x8000);
        pair.emulator.send(kind, 0, 0, &[]);
        let response = pair.emulator.response();
        assert_eq!(
            (response.kind, response.code, response.driver_enabled),
            (b'F', 0x8000, false)
        );
        let (code, message) = pair.emulator.end();
        assert_eq!(code, Some(101));
        assert!(message.contains(says), "{message}");
    }
}
