//! The firmware itself, in QEMU: every code equals that of the host's replica, bit for bit, and a
//! failing program leaves the converter safe.
//!
//! `scripts/check-firmware.sh` builds the firmware and runs this with `HYSTERON_FIRMWARE` naming it.

mod firmware_rig;

use std::path::PathBuf;

use firmware_rig::{bipolar, frame, model, modified_play, published, sine, with};
use hysteron::control::Path;
use hysteron::dim::Law;
use hysteron::hysteresis::modified_play::Harmonics;
use hysteron::hysteresis::preview::PlantRate;
use hysteron::link::{Answer, CHUNK_LEN, Command, Message, Refusal, decode};
use hysteron::record::{Effect, Inverse, ModelRecord, Preview};
use hysteron::reference::{Tone, Waveform};
use hysteron::settings::Settings;
use hysteron::store::Kept;
use hysteron_host::pil::{Emulator, Pair, Replica, Target, Ticked};

const NEEDS: &str = "HYSTERON_FIRMWARE names the ELF; scripts/check-firmware.sh builds and runs";

/// Instructions of a sample within 16,800 cycles, those of 168 MHz at 10 kHz, of two cycles each at
/// most in the mean.
const DEADLINE: u32 = 8_400;

/// The same for white noise, which leaves 1.68 cycles for an instruction.
const NOISE: u32 = 10_000;

/// Any code of the sensor: nothing here depends on it but what is recorded.
const SENSOR: u16 = 1234;

/// Emulator and replica side by side.
struct Both {
    pair: Pair,
    sequence: u16,
    /// Instructions of the samples, and of those in which a setup came into force: the output stands
    /// still in them.
    counts: Vec<u32>,
    swaps: Vec<u32>,
}

impl Both {
    fn new() -> Self {
        let elf = PathBuf::from(std::env::var_os("HYSTERON_FIRMWARE").expect(NEEDS));
        let emulator = Emulator::start(&elf).unwrap();
        let mut both = Self {
            pair: Pair::new(emulator, Replica::power_on().unwrap()),
            sequence: 0,
            counts: Vec::new(),
            swaps: Vec::new(),
        };
        both.tick(false);
        both
    }

    /// The answer of both to the same command; recorded samples may come with it.
    fn ask(&mut self, command: Command) -> Answer {
        self.sequence += 1;
        let swaps = matches!(command, Command::SetModel(_));
        let heard = self.pair.link(&frame(self.sequence, command)).unwrap();
        let answer = heard
            .split(|&byte| byte == 0)
            .find_map(|frame| match decode(&mut frame.to_vec()) {
                Ok(Message::Reply { sequence, answer }) if sequence == self.sequence => {
                    Some(answer)
                }
                _ => None,
            })
            .expect("a reply");
        self.tick(false);
        if swaps {
            self.swaps.extend(self.counts.pop());
        }
        answer
    }

    /// A command that both have to carry out, if not before the next sample.
    fn tell(&mut self, command: Command) {
        let mut answer = self.ask(command.clone());
        if answer == Answer::Refused(Refusal::Busy) {
            answer = self.ask(command);
        }
        assert_eq!(answer, Answer::Done);
    }

    fn stream(&mut self, samples: &[f32]) {
        self.tell(Command::ResetStream);
        let mut first = 0;
        for chunk in samples.chunks(CHUNK_LEN) {
            let answer = self.ask(Command::Stream {
                first,
                samples: chunk.iter().copied().collect(),
            });
            first += chunk.len() as u32;
            assert!(matches!(answer, Answer::Stream { next, .. } if next == first));
        }
    }

    fn tick(&mut self, late: bool) -> Ticked {
        let ticked = self.pair.tick(SENSOR, late).unwrap();
        assert_eq!(self.pair.first_difference(), None);
        self.counts.push(ticked.instructions);
        ticked
    }

    fn ticks(&mut self, count: usize) {
        for _ in 0..count {
            self.tick(false);
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

    /// Plays everything with a model; no sample may take more instructions than `most`.
    fn exercise(&mut self, name: &str, record: ModelRecord, most: u32) {
        self.tell(Command::SetModel(Some(record.clone())));
        self.counts.clear();
        for waveform in references() {
            for path in [Path::Compensated, Path::Direct] {
                self.start(path, waveform);
                self.tell(Command::Record { every: 1 });
                self.ticks(4_000);
                for pause in [1, 7, 19, 25, 37, 50] {
                    self.tell(Command::SetModel(Some(record.clone())));
                    self.tell(Command::Record { every: 1 });
                    self.ticks(pause);
                }
                self.tell(Command::Hold);
            }
        }
        for samples in [unwinding(), noise()] {
            self.stream(&samples);
            self.start(Path::Compensated, Waveform::Stream);
            self.ticks(samples.len());
            self.tell(Command::Hold);
        }
        self.report(name, most);
    }

    /// Tells what the samples took; none may have taken more instructions than `most`.
    fn report(&self, name: &str, most: u32) {
        let mut counts = self.counts.clone();
        counts.sort_unstable();
        let (median, worst) = (counts[counts.len() / 2], counts[counts.len() - 1]);
        println!(
            "whole interrupt, {name}: {} to {worst} instructions, median {median}",
            counts[0]
        );
        assert!(worst <= most, "{worst} instructions in the worst sample");
        let swap = self.swaps.iter().copied().max().unwrap_or_default();
        println!("the sample of a swap, {name}: {swap} instructions at most");
        assert!(swap <= DEADLINE, "{swap} instructions in a swap");
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

/// Oscillations that die away and leave a segment for each play, and at their end a jump that merges
/// all of them in one sample. Each value comes twice: at the second the rate is zero and the envelope
/// closed.
fn unwinding() -> Vec<f32> {
    let mut samples = Vec::new();
    for decay in [0.8f32, 0.85, 0.9, 0.93, 0.95, 0.97] {
        for k in 0..80 {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            samples.extend([sign * 45.0 * decay.powi(k); 2]);
        }
    }
    samples
}

/// White noise of uniform distribution, each value twice.
fn noise() -> Vec<f32> {
    let mut seed = 1u32;
    let mut samples = Vec::new();
    for _ in 0..500 {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        samples.extend([45.0 * (seed as i32 as f32 / 2_147_483_648.0); 2]);
    }
    samples
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn target_and_host_agree_bit_for_bit_within_the_budget() {
    let mut both = Both::new();
    both.wide();
    let thresholds: Vec<f32> = (1..=10).map(|i| 2.5 * i as f32).collect();
    let mut weights = vec![0.7236];
    weights.extend((1..=10).map(|i| 0.12 * (-0.1 * i as f32).exp()));
    let ten = model(&thresholds, &weights, 8.572e-4, 1.1);
    // Most instructions of a sample, from the request of the interrupt to the return from it, with the
    // bipolar converter, a recording and an order in the same sample, swaps of the model in full swing
    // among them.
    for (name, record, most) in [("n = 3", published(), 480), ("n = 10", ten, 510)] {
        both.exercise(name, record, most);
    }
    assert_eq!(both.tick(false).state, 1);
    let mut emulator = both.pair.into_emulator();
    println!("stack: {} bytes", emulator.stack_bytes().unwrap());
    assert_eq!(emulator.end().unwrap(), (Some(0), String::new()));
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn dim_agrees_bit_for_bit_within_its_budget() {
    let mut both = Both::new();
    both.wide();
    for (name, divisions, law, harmonics, most) in [
        (
            "DIM printed, N = 10",
            10,
            Law::Printed,
            Harmonics::Printed,
            630,
        ),
        (
            "DIM exact, N = 10",
            10,
            Law::Exact,
            Harmonics::Corrected,
            630,
        ),
        ("DIM exact, N = 16", 16, Law::Exact, Harmonics::Printed, 750),
    ] {
        both.exercise(name, modified_play(divisions, law, harmonics), most);
    }
    let mut emulator = both.pair.into_emulator();
    println!("with DIM, stack: {} bytes", emulator.stack_bytes().unwrap());
    assert_eq!(emulator.end().unwrap(), (Some(0), String::new()));
}

/// A lag, a delay, both curvatures, a gap, a mode, eight decades of creep and interleaving around a
/// hysteresis.
fn with_effects(record: ModelRecord) -> ModelRecord {
    let effects = [
        Effect::AmplifierLag { tau_s: 2e-4 },
        Effect::TransportDelay { delay_s: 1.3e-4 },
        Effect::Quadratic { q: 5e-4 },
        Effect::Cubic { c: 1e-5 },
        Effect::Backlash { width: 0.4 },
        Effect::Resonance {
            f_n_hz: 900.0,
            zeta: 0.05,
        },
        Effect::Creep {
            gain_per_decade: 0.01,
            tau_min_s: 1e-2,
            tau_max_s: 1e5,
        },
        Effect::Interleaving { g: 2e-3 },
    ];
    with(record, |chain| {
        chain.effects = heapless::Vec::from_slice(&effects).unwrap();
    })
}

fn inverted(record: &ModelRecord, inverse: Inverse) -> ModelRecord {
    with(record.clone(), |chain| chain.inverse = inverse)
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn what_looks_ahead_agrees_bit_for_bit_within_the_deadline() {
    let mut both = Both::new();
    both.wide();
    let ahead = |window, plant_rate| Preview { window, plant_rate };
    let published = with_effects(published());
    let thresholds: Vec<f32> = (1..=10).map(|i| 2.5 * i as f32).collect();
    let mut weights = vec![0.7236];
    weights.extend((1..=10).map(|i| 0.12 * (-0.1 * i as f32).exp()));
    let ten = with_effects(model(&thresholds, &weights, 8.572e-4, 1.1));
    let midpoint = ahead(26, PlantRate::Midpoint);
    let forward = ahead(26, PlantRate::Forward);
    for (name, record, inverse) in [
        ("preview, n = 3", &published, Inverse::Preview(midpoint)),
        ("cascade, n = 3", &published, Inverse::Cascade(midpoint)),
        ("preview, n = 10", &ten, Inverse::Preview(forward)),
        (
            "cascade, n = 10",
            &ten,
            Inverse::Cascade(ahead(24, PlantRate::Midpoint)),
        ),
    ] {
        let chosen = inverted(record, inverse);
        let fallback = inverted(record, Inverse::Explicit);
        both.tell(Command::SetModel(Some(chosen.clone())));
        both.counts.clear();
        for waveform in [sine(25.0, 50.0), sine(25.0, 100.0), references()[4]] {
            both.start(Path::Compensated, waveform);
            both.tell(Command::Record { every: 1 });
            both.ticks(600);
            for pause in [1, 7, 29, 60, 200] {
                for record in [&fallback, &chosen] {
                    both.tell(Command::SetModel(Some(record.clone())));
                    both.ticks(pause);
                }
            }
            both.tell(Command::Hold);
        }
        both.report(name, DEADLINE);
        both.counts.clear();
        both.stream(&noise());
        both.tell(Command::Start {
            path: Path::Compensated,
            waveform: Waveform::Stream,
            samples: 1_000,
        });
        // With the samples that it looks ahead it comes to its end, and holds.
        both.ticks(1_100);
        assert_eq!(both.tick(false).state, 1);
        // No reference of a stage: it turns at every sample, and every turn moves plays.
        both.report(&format!("{name}, white noise"), NOISE);
    }
    let mut emulator = both.pair.into_emulator();
    println!("ahead, stack: {} bytes", emulator.stack_bytes().unwrap());
    assert_eq!(emulator.end().unwrap(), (Some(0), String::new()));
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn late_samples_are_a_fault_that_ends_safe_and_recovers() {
    let mut both = Both::new();
    both.wide();
    both.start(Path::Direct, sine(30.0, 10.0));
    both.ticks(250);
    for _ in 0..4 {
        both.tick(true);
    }
    both.ticks(300);
    let ticked = both.tick(false);
    assert_eq!(
        (ticked.state, ticked.code, ticked.driver_enabled),
        (3, 0x8000, false)
    );
    both.tell(Command::Clear);
    both.start(Path::Direct, sine(30.0, 10.0));
    both.ticks(1_000);
    assert_eq!(both.pair.into_emulator().end().unwrap().0, Some(0));
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn a_program_that_fails_leaves_the_converter_safe() {
    for (kind, says) in [(b'P', "forced"), (b'H', "hard fault")] {
        let mut both = Both::new();
        both.wide();
        both.start(Path::Direct, sine(30.0, 10.0));
        both.ticks(250);
        assert!(both.tick(false).code != 0x8000);
        let mut emulator = both.pair.into_emulator();
        emulator.request(kind, 0, &[]).unwrap();
        let response = emulator.response().unwrap();
        assert_eq!(
            (
                response.kind,
                response.ticked.code,
                response.ticked.driver_enabled
            ),
            (b'F', 0x8000, false)
        );
        let (code, message) = emulator.end().unwrap();
        assert_eq!(code, Some(101));
        assert!(message.contains(says), "{message}");
    }
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn what_was_saved_is_in_force_after_a_reset() {
    let mut both = Both::new();
    assert_eq!(both.ask(Command::GetKept), Answer::Kept(Kept::Nothing));
    both.wide();
    let record = inverted(
        &with_effects(published()),
        Inverse::Cascade(Preview {
            window: 26,
            plant_rate: PlantRate::Midpoint,
        }),
    );
    both.tell(Command::SetModel(Some(record.clone())));
    let in_force = both.ask(Command::GetSettings);
    both.tick(false);
    both.tell(Command::Save);
    assert_eq!(both.ask(Command::GetKept), Answer::Kept(Kept::InForce));
    both.tell(Command::SetModel(None));
    for start in 0..2 {
        both.pair.reset().unwrap();
        both.tick(false);
        assert_eq!(both.ask(Command::GetSettings), in_force);
        let model = both.ask(Command::GetModel);
        assert_eq!(model, Answer::Model(Some(record.clone())));
        // On the way, so that the next reset hits it in full swing.
        both.start(Path::Compensated, sine(25.0, 50.0));
        both.ticks(300 + 200 * start);
        assert!(both.tick(false).driver_enabled);
    }
    let mut emulator = both.pair.into_emulator();
    println!("saved, stack: {} bytes", emulator.stack_bytes().unwrap());
    assert_eq!(emulator.end().unwrap(), (Some(0), String::new()));
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn a_difference_does_not_go_unseen() {
    let elf = PathBuf::from(std::env::var_os("HYSTERON_FIRMWARE").expect(NEEDS));
    let mut emulator = Emulator::start(&elf).unwrap();
    // The firmware alone is told to hold, so its driver is on and the host's is not.
    emulator.tick(SENSOR, false).unwrap();
    emulator.link(&frame(1, Command::Hold)).unwrap();
    let mut pair = Pair::new(emulator, Replica::power_on().unwrap());
    pair.tick(SENSOR, false).unwrap();
    assert!(pair.first_difference().is_some());
}
