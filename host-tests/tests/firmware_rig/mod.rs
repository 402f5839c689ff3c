//! A target without hardware: the same queues, control and link that the firmware connects.

#![allow(dead_code, reason = "each test file uses a part of the rig")]

use hysteron::control::{Control, Output, Path};
use hysteron::dac;
use hysteron::dim::Law;
use hysteron::hysteresis::modified_play::Harmonics;
use hysteron::link::{Answer, Command, FRAME_LEN, Message, Request, Server, decode, encode};
use hysteron::record::{ChainRecord, Inverse, ModelRecord, ModifiedPlayRecord};
use hysteron::reference::{Tone, Waveform};
use hysteron::settings::Settings;
use hysteron::store::{Boot, Keep};
use hysteron::telemetry::{Shared, Statistics};
use hysteron::wiring::Memory;

/// +-50 V from a bipolar converter and an amplifier of ten.
pub fn bipolar() -> Settings {
    Settings {
        dac: dac::Kind::Bipolar16,
        drive_min_v: -45.0,
        drive_max_v: 45.0,
        slew_v_per_s: 30_000.0,
        ramp_v_per_s: 2_000.0,
        stale_s: 0.01,
        ..Settings::default()
    }
}

/// The stage P-753.31C of paper J, consistent constants.
pub fn published() -> ModelRecord {
    model(
        &[9.715, 19.43, 29.145],
        &[0.7236, 0.2906, 0.0416, 0.1512],
        8.572e-4,
        1.0,
    )
}

pub fn model(thresholds: &[f32], weights: &[f32], beta_s: f32, gain: f32) -> ModelRecord {
    ModelRecord::Chain(ChainRecord {
        thresholds_v: heapless::Vec::from_slice(thresholds).unwrap(),
        weights: heapless::Vec::from_slice(weights).unwrap(),
        beta_s,
        asymmetry: None,
        effects: heapless::Vec::new(),
        gain_um_per_v: gain,
        offset_um: 0.0,
        inverse: Inverse::Explicit,
    })
}

/// The same record with some of its fields changed.
pub fn with(record: ModelRecord, change: impl FnOnce(&mut ChainRecord)) -> ModelRecord {
    match record {
        ModelRecord::Chain(mut chain) => {
            change(&mut chain);
            ModelRecord::Chain(chain)
        }
        other => panic!("{other:?}"),
    }
}

/// A full modified play model of `divisions` for 50 V and 10 kHz, steep enough for 50 um.
pub fn modified_play(divisions: usize, law: Law, harmonics: Harmonics) -> ModelRecord {
    let mut slopes: Vec<f32> = (1..divisions)
        .map(|i| 0.3 * (-0.2 * i as f32).exp())
        .collect();
    slopes.insert(0, 0.7);
    ModelRecord::ModifiedPlay(ModifiedPlayRecord {
        u_max_v: 50.0,
        slopes_um_per_v: heapless::Vec::from_slice(&slopes).unwrap(),
        offset_um: 0.25,
        alpha_s: 2e-5,
        beta_s: 3e-5,
        interleaving_per_v: 1e-3,
        feedback: [0.3, 0.1, -0.05],
        frequency_hz: 50.0,
        harmonics,
        sine: [1e-2, 1e-5, 1e-9],
        cosine: [-1e-2, 2e-5, 1e-9],
        sample_time_s: 1e-4,
        law,
    })
}

pub fn sine(amplitude: f32, frequency_hz: f32) -> Waveform {
    let tone = |amplitude| Tone {
        amplitude,
        frequency_hz,
    };
    Waveform::Tones {
        offset: 0.0,
        tones: [tone(amplitude), tone(0.0)],
    }
}

/// The bytes of a command.
pub fn frame(sequence: u16, command: Command) -> Vec<u8> {
    let mut frame = [0; FRAME_LEN];
    let len = encode(&Request { sequence, command }, &mut frame).unwrap();
    frame[..len].to_vec()
}

pub struct Rig {
    pub control: Control<'static>,
    pub server: Server<'static>,
    pub shared: &'static Shared,
    pub last: Output,
    /// Watched in every tick: codes never beyond these, never further apart than `step`.
    pub bounds: (u16, u16),
    pub step: f64,
    sequence: u16,
}

impl Rig {
    pub fn new(settings: Settings) -> Self {
        Self::connect(Boot::new(settings).unwrap(), None)
    }

    /// A target that starts with what was saved, and may save.
    pub fn kept(keep: &'static mut (dyn Keep + Send)) -> Self {
        Self::connect(Boot::load(keep).unwrap(), Some(keep))
    }

    fn connect(boot: Boot, keep: Option<&'static mut (dyn Keep + Send)>) -> Self {
        let settings = boot.settings;
        let memory = Box::leak(Box::new(Memory::new()));
        let (control, server, shared) = memory.connect_kept(boot, keep).unwrap();
        let mut rig = Self {
            control,
            server,
            shared,
            last: Output {
                dac: settings.dac,
                code: 0,
                driver_enabled: false,
            },
            bounds: (0, 0),
            step: f64::INFINITY,
            sequence: 0,
        };
        rig.watch(settings);
        rig.tick();
        rig.step = step_in_codes(&settings);
        rig
    }

    /// Bounds from the settings, computed in double precision and apart from the code under test.
    pub fn watch(&mut self, settings: Settings) {
        let at = |drive: f32| exact_code(&settings, f64::from(drive));
        let (a, b) = (at(settings.drive_min_v), at(settings.drive_max_v));
        let max = f64::from(settings.dac.max_code());
        self.bounds = (
            (a.min(b) - 2e-3).ceil().max(0.0) as u16,
            (a.max(b) + 2e-3).floor().min(max) as u16,
        );
    }

    pub fn tick(&mut self) -> Output {
        self.tick_with(0, false)
    }

    pub fn tick_with(&mut self, sensor: u16, late: bool) -> Output {
        let output = self.control.tick(sensor, late);
        let code = output.code;
        assert!(
            (self.bounds.0..=self.bounds.1).contains(&code),
            "code {code} beyond {:?}",
            self.bounds
        );
        let moved = (f64::from(code) - f64::from(self.last.code)).abs();
        assert!(
            moved <= self.step,
            "moved {moved} codes, allowed {}",
            self.step
        );
        self.last = output;
        output
    }

    pub fn ticks(&mut self, count: usize) -> Vec<Output> {
        (0..count).map(|_| self.tick()).collect()
    }

    /// The bytes of a command.
    pub fn frame(&mut self, command: Command) -> Vec<u8> {
        self.sequence = self.sequence.wrapping_add(1);
        frame(self.sequence, command)
    }

    pub fn feed(&mut self, bytes: &[u8]) -> Vec<Message> {
        let mut messages = Vec::new();
        for &byte in bytes {
            if let Some(reply) = self.server.receive(byte) {
                let mut reply = reply.to_vec();
                assert_eq!(reply.pop(), Some(0));
                messages.push(decode(&mut reply).unwrap());
            }
        }
        messages
    }

    pub fn ask(&mut self, command: Command) -> Answer {
        let frame = self.frame(command);
        match self.feed(&frame).pop() {
            Some(Message::Reply { sequence, answer }) => {
                assert_eq!(sequence, self.sequence);
                answer
            }
            other => panic!("no reply but {other:?}"),
        }
    }

    /// Asks, expects success, and lets it come into force.
    pub fn tell(&mut self, command: Command) {
        let answer = self.ask(command);
        assert_eq!(answer, Answer::Done);
        self.tick();
    }

    pub fn start(&mut self, path: Path, waveform: Waveform) {
        self.tell(Command::Start {
            path,
            waveform,
            samples: 0,
        });
    }

    pub fn statistics(&mut self) -> Statistics {
        match self.ask(Command::Statistics) {
            Answer::Statistics(statistics) => statistics,
            other => panic!("{other:?}"),
        }
    }

    pub fn stream(&mut self, first: u32, samples: &[f32]) -> Answer {
        self.ask(Command::Stream {
            first,
            samples: heapless::Vec::from_slice(samples).unwrap(),
        })
    }
}

/// The code for a drive as a real number, from the definition of the settings.
pub fn exact_code(settings: &Settings, drive: f64) -> f64 {
    let converter =
        (drive - f64::from(settings.amplifier_offset_v)) / f64::from(settings.amplifier_gain);
    match settings.dac {
        dac::Kind::Internal12 => converter / 3.3 * 4096.0,
        dac::Kind::Bipolar16 => (converter + 5.0) / 10.0 * 65_536.0,
    }
}

/// Largest distance of the codes of two samples: the slew limit, and one for rounding both.
pub fn step_in_codes(settings: &Settings) -> f64 {
    let step = f64::from(settings.slew_v_per_s) / f64::from(settings.sample_rate_hz);
    (exact_code(settings, step) - exact_code(settings, 0.0)).abs() * (1.0 + 1e-6) + 1.0
}
