//! The tick end to end: what it puts out, model swaps, underruns, overruns, a cut link, recordings.

mod firmware_rig;

use firmware_rig::{Rig, bipolar, exact_code, model, published, sine, step_in_codes};
use hysteron::control::Path;
use hysteron::link::{Answer, Command, Message, Refusal};
use hysteron::reference::Waveform;
use hysteron::safety::{Cause, State};
use hysteron::settings::Settings;
use std::f64::consts::TAU;

/// Inverse of paper J written down anew in double precision: plays by clamping the distance to the
/// input, thresholds of (J 14), weights of (J 15).
struct Textbook {
    weights: Vec<f64>,
    thresholds: Vec<f64>,
    beta_a0_per_h: f64,
    plays: Vec<f64>,
    before: Option<f64>,
}

impl Textbook {
    fn new(thresholds: &[f64], weights: &[f64], beta: f64, rate: f64) -> Self {
        let sums: Vec<f64> = weights
            .iter()
            .scan(0.0, |sum, a| {
                *sum += a;
                Some(*sum)
            })
            .collect();
        let mut inverse = vec![1.0 / weights[0]];
        inverse.extend(sums.windows(2).map(|pair| 1.0 / pair[1] - 1.0 / pair[0]));
        let mut s = vec![sums[0] * thresholds[0]];
        for i in 1..thresholds.len() {
            s.push(s[i - 1] + sums[i] * (thresholds[i] - thresholds[i - 1]));
        }
        Self {
            weights: inverse,
            plays: vec![0.0; s.len()],
            thresholds: s,
            beta_a0_per_h: beta * weights[0] * rate,
            before: None,
        }
    }

    fn step(&mut self, v: f64) -> f64 {
        let widening = self.beta_a0_per_h * (v - self.before.unwrap_or(v)).abs();
        self.before = Some(v);
        let mut u = self.weights[0] * v;
        for ((z, s), b) in self
            .plays
            .iter_mut()
            .zip(&self.thresholds)
            .zip(&self.weights[1..])
        {
            let r = s + widening;
            *z = v - (v - *z).clamp(-r, r);
            u += b * *z;
        }
        u
    }
}

#[test]
fn a_compensated_sine_is_that_of_the_textbook_to_a_code() {
    let settings = Settings {
        drive_min_v: -50.0,
        drive_max_v: 50.0,
        ..bipolar()
    };
    let mut rig = Rig::new(settings);
    rig.watch(settings);
    rig.tell(Command::SetModel(Some(published())));
    rig.tick();
    let weights = [0.7236f32, 0.2906, 0.0416, 0.1512].map(f64::from);
    let thresholds = [9.715f32, 19.43, 29.145].map(f64::from);
    let mut textbook = Textbook::new(&thresholds, &weights, f64::from(8.572e-4f32), 1e4);
    // The phase advances by 0.005 turns, rounded to 32 bits.
    let turns = (0.005 * 2f64.powi(32)).round() / 2f64.powi(32);
    let wanted: Vec<f64> = (0..20_000)
        .map(|k| textbook.step(40.0 * (TAU * turns * f64::from(k)).sin()))
        .collect();
    assert_eq!(
        rig.ask(Command::Start {
            path: Path::Compensated,
            waveform: sine(40.0, 50.0),
            samples: 0,
        }),
        Answer::Done
    );
    // The output stands still in the sample of the order.
    assert_eq!(rig.tick().code, 0x8000);
    for (k, wanted) in wanted.iter().enumerate() {
        let code = f64::from(rig.tick().code);
        let exact = exact_code(&settings, *wanted);
        assert!((code - exact).abs() < 0.55, "{k}: {code} for {exact}");
    }
    // Rest is where a sine starts: nothing had to be joined, nothing was held back.
    assert_eq!(rig.statistics().limited, 0);
}

#[test]
fn a_model_is_swapped_without_a_jump() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetModel(Some(published())));
    rig.start(Path::Compensated, sine(20.0, 20.0));
    rig.ticks(1_020);
    // In one sample a 20 um sine of 20 Hz moves by 0.05 um, its drive by no more than twice that.
    let allowed = (exact_code(&bipolar(), 0.1) - exact_code(&bipolar(), 0.0)) + 1.0;
    let ramp = exact_code(&bipolar(), 0.2) - exact_code(&bipolar(), 0.0) + 1.0;
    rig.step = allowed + ramp;
    // Twice the gain: the drive is to halve, 10 V away.
    let other = model(
        &[9.0, 19.0, 29.0],
        &[0.7236, 0.2906, 0.0416, 0.1512],
        8.572e-4,
        2.0,
    );
    rig.tell(Command::SetModel(Some(other)));
    rig.ticks(2_000);
    let settled = rig.ticks(500).iter().map(|o| o.code).max().unwrap();
    let mut fresh = Rig::new(bipolar());
    let other = model(
        &[9.0, 19.0, 29.0],
        &[0.7236, 0.2906, 0.0416, 0.1512],
        8.572e-4,
        2.0,
    );
    fresh.tell(Command::SetModel(Some(other)));
    fresh.start(Path::Compensated, sine(20.0, 20.0));
    fresh.ticks(2_000);
    let alone = fresh.ticks(500).iter().map(|o| o.code).max().unwrap();
    assert_eq!(settled, alone);
    rig.tell(Command::SetModel(None));
    rig.ticks(10);
    let statistics = rig.statistics();
    assert_eq!(
        (statistics.state, statistics.cause),
        (State::Fault, Some(Cause::NoModel))
    );
}

#[test]
fn models_can_be_swapped_every_other_sample() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetModel(Some(published())));
    rig.tick();
    rig.start(Path::Compensated, sine(20.0, 20.0));
    rig.tick();
    for _ in 0..500 {
        rig.tell(Command::SetModel(Some(published())));
        rig.tick();
    }
    assert_eq!(rig.statistics().state, State::Run);
    assert_eq!(rig.statistics().played, 501);
}

#[test]
fn a_cut_link_holds_then_ramps_to_rest_and_recovers_on_command() {
    let mut rig = Rig::new(bipolar());
    let samples: Vec<f32> = (0..960).map(|k| (k as f32 * 0.01).sin() * 30.0).collect();
    for (chunk, samples) in samples.chunks(64).enumerate() {
        rig.stream(chunk as u32 * 64, samples);
    }
    // The link breaks within a frame.
    rig.tell(Command::Start {
        path: Path::Direct,
        waveform: Waveform::Stream,
        samples: 0,
    });
    let cut = rig.frame(Command::Stream {
        first: 960,
        samples: heapless::Vec::from_slice(&[0.0; 64]).unwrap(),
    });
    rig.feed(&cut[..cut.len() / 2]);
    rig.ticks(960);
    let last = rig.last.code;
    assert!((f64::from(last) - exact_code(&bipolar(), 30.0 * 9.59f64.sin())).abs() < 1.0);
    // 10 ms are 100 samples.
    let held = rig.ticks(101);
    assert!(held.iter().all(|o| o.code == last && o.driver_enabled));
    rig.ticks(300);
    assert_eq!((rig.last.code, rig.last.driver_enabled), (0x8000, false));
    // The other half of the frame never comes; zeros find the way back.
    rig.feed(&[0]);
    let statistics = rig.statistics();
    assert_eq!(
        (
            statistics.state,
            statistics.underruns,
            statistics.bad_frames
        ),
        (State::Off, 1, 1)
    );
    rig.start(Path::Direct, sine(10.0, 10.0));
    rig.ticks(250);
    let peak = exact_code(&bipolar(), 10.0);
    assert!((f64::from(rig.last.code) - peak).abs() < 2.0);
}

#[test]
fn a_late_stream_goes_on_without_a_jump() {
    let mut rig = Rig::new(bipolar());
    rig.stream(0, &[10.0; 64]);
    rig.start(Path::Direct, Waveform::Stream);
    rig.ticks(100);
    rig.step = 1.0;
    rig.stream(64, &[10.0; 60]);
    rig.ticks(60);
    assert_eq!(rig.statistics().underruns, 1);
    assert_eq!(rig.statistics().state, State::Run);
}

#[test]
fn a_counted_reference_ends_in_a_hold() {
    let mut rig = Rig::new(bipolar());
    rig.stream(0, &[0.0, 0.1, 0.2, 0.3]);
    rig.tell(Command::Start {
        path: Path::Direct,
        waveform: Waveform::Stream,
        samples: 4,
    });
    rig.ticks(4);
    let end = rig.last.code;
    rig.ticks(1_000);
    assert_eq!(rig.last.code, end);
    let statistics = rig.statistics();
    assert_eq!(
        (statistics.state, statistics.underruns, statistics.played),
        (State::Hold, 0, 4)
    );
}

#[test]
fn overruns_are_counted_and_past_the_limit_a_fault() {
    let mut rig = Rig::new(bipolar());
    rig.start(Path::Direct, sine(40.0, 10.0));
    rig.ticks(250);
    for _ in 0..3 {
        rig.tick_with(0, true);
    }
    assert_eq!(rig.statistics().state, State::Run);
    rig.tick_with(0, true);
    let statistics = rig.statistics();
    assert_eq!(statistics.misses, 4);
    assert_eq!(
        (statistics.state, statistics.cause),
        (State::Fault, Some(Cause::Deadline))
    );
    rig.ticks(500);
    assert_eq!((rig.last.code, rig.last.driver_enabled), (0x8000, false));
    let start = Command::Start {
        path: Path::Direct,
        waveform: sine(1.0, 1.0),
        samples: 0,
    };
    assert_eq!(rig.ask(start.clone()), Answer::Refused(Refusal::State));
    assert_eq!(rig.ask(Command::Hold), Answer::Refused(Refusal::State));
    rig.tell(Command::Clear);
    rig.tell(start);
    assert_eq!(rig.statistics().state, State::Run);
}

#[test]
fn a_reference_beyond_range_and_slew_is_held_back() {
    let mut rig = Rig::new(bipolar());
    // 1,000 V at 1 kHz: the rig watches every sample.
    rig.start(Path::Direct, sine(1_000.0, 1_000.0));
    rig.ticks(2_000);
    assert!(rig.statistics().limited > 1_500);
    assert_eq!(rig.statistics().state, State::Run);
}

#[test]
fn a_reference_that_overflows_is_a_fault() {
    let mut rig = Rig::new(bipolar());
    let steep = model(&[1.0], &[1e-3, 1e-3], 0.0, 1e-3);
    rig.tell(Command::SetModel(Some(steep)));
    rig.start(Path::Compensated, sine(f32::MAX, 100.0));
    rig.ticks(300);
    let statistics = rig.statistics();
    assert_eq!(
        (statistics.state, statistics.cause),
        (State::Fault, Some(Cause::NotFinite))
    );
    assert_eq!((rig.last.code, rig.last.driver_enabled), (0x8000, false));
}

#[test]
fn recordings_are_numbered_and_drops_show_as_gaps() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::Start {
        path: Path::Direct,
        waveform: sine(10.0, 10.0),
        samples: 0,
    });
    // The first sample of a motion obeys no order.
    rig.tick();
    assert_eq!(rig.ask(Command::Record { every: 3 }), Answer::Done);
    let outputs: Vec<u16> = (0..3_000)
        .map(|k| rig.tick_with(k as u16, false).code)
        .collect();
    let mut frames = Vec::new();
    while let Some(frame) = rig.server.recorded(true) {
        let mut frame = frame[..frame.len() - 1].to_vec();
        frames.push(hysteron::link::decode::<Message>(&mut frame).unwrap());
    }
    let mut number = 0;
    for frame in frames {
        let Message::Recorded { first, codes } = frame else {
            panic!("{frame:?}");
        };
        assert_eq!(first, number);
        for codes in codes {
            assert_eq!(usize::from(codes.sensor), number as usize * 3);
            assert_eq!(codes.drive, outputs[number as usize * 3]);
            number += 1;
        }
    }
    // The queue holds 511 of the 1,000 samples; the rest is dropped and counted.
    assert_eq!((number, rig.statistics().dropped), (511, 489));
    rig.ticks(3);
    let Some(frame) = rig.server.recorded(true) else {
        panic!("there is a new sample");
    };
    let mut frame = frame[..frame.len() - 1].to_vec();
    let message: Message = hysteron::link::decode(&mut frame).unwrap();
    assert!(matches!(message, Message::Recorded { first: 1_000, .. }));
}

#[test]
fn a_start_numbers_the_recording_from_its_first_sample() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::Record { every: 1 });
    rig.ticks(7);
    let ask = Command::Start {
        path: Path::Direct,
        waveform: sine(10.0, 100.0),
        samples: 0,
    };
    assert_eq!(rig.ask(ask), Answer::Done);
    let outputs: Vec<u16> = rig.ticks(20).iter().map(|output| output.code).collect();
    let mut frames = Vec::new();
    while let Some(frame) = rig.server.recorded(true) {
        let mut frame = frame[..frame.len() - 1].to_vec();
        match hysteron::link::decode::<Message>(&mut frame).unwrap() {
            Message::Recorded { first, codes } => frames.push((first, codes)),
            other => panic!("{other:?}"),
        }
    }
    let lengths: Vec<_> = frames
        .iter()
        .map(|(first, codes)| (*first, codes.len()))
        .collect();
    // In the sample of the order the output stands still, and none is recorded.
    assert_eq!(lengths, [(0, 8), (0, 19)]);
    let recorded: Vec<u16> = frames[1].1.iter().map(|codes| codes.drive).collect();
    assert_eq!(recorded, outputs[1..]);
}

#[test]
fn the_step_bound_is_that_of_the_settings() {
    // 30,000 V/s at 10 kHz: 3 V, of 1.526 mV each.
    assert!((step_in_codes(&bipolar()) - 1.0 - 3.0 / 10.0 / 10.0 * 65_536.0).abs() < 0.1);
}
