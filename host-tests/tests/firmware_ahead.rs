//! Compensators that look ahead, in the tick: that the stage follows, what the latency is, how a
//! motion ends, pauses, and goes over to another compensator.

mod firmware_rig;

use firmware_rig::{Rig, bipolar, exact_code, published, sine, with};
use hysteron::control::Path;
use hysteron::hysteresis::preview::PlantRate;
use hysteron::link::{Command, Message};
use hysteron::record::{Effect, Inverse, ModelRecord, Preview};
use hysteron::reference::Waveform;
use hysteron::safety::State;
use hysteron::settings::Settings;
use std::f64::consts::TAU;

const H: f64 = 1e-4;

fn wide() -> Settings {
    Settings {
        drive_min_v: -50.0,
        drive_max_v: 50.0,
        slew_v_per_s: 1e6,
        ..bipolar()
    }
}

fn preview(plant_rate: PlantRate) -> Preview {
    Preview {
        window: 26,
        plant_rate,
    }
}

fn previewed(plant_rate: PlantRate) -> ModelRecord {
    with(published(), |chain| {
        chain.inverse = Inverse::Preview(preview(plant_rate));
    })
}

/// The drive in V of a code, from the definition of the settings.
fn drive(code: u16) -> f64 {
    let settings = wide();
    let zero = exact_code(&settings, 0.0);
    (f64::from(code) - zero) / (exact_code(&settings, 1.0) - zero)
}

/// Paper J's stage as plain loops, its thresholds widened by the rate of the step to come.
fn displacement(drives: &[f64]) -> Vec<f64> {
    let thresholds = [9.715f32, 19.43, 29.145].map(f64::from);
    let weights = [0.2906f32, 0.0416, 0.1512].map(f64::from);
    let mut plays = [0.0; 3];
    let steps = drives.windows(2).map(|pair| {
        let rate = (pair[1] - pair[0]) / H;
        let mut sum = f64::from(0.7236f32) * pair[0];
        for i in 0..3 {
            let r = thresholds[i] + f64::from(8.572e-4f32) * rate.abs();
            plays[i] = pair[0] - (pair[0] - plays[i]).clamp(-r, r);
            sum += weights[i] * plays[i];
        }
        sum
    });
    steps.collect()
}

/// The reference that starts smoothly: no leap of its rate.
fn smooth(samples: usize, amplitude: f64, hz: f64) -> Vec<f64> {
    let at = |k: usize| {
        let t = k as f64 * H;
        let fade = (t * hz / 2.0).min(1.0);
        amplitude * (3.0 - 2.0 * fade) * fade * fade * (TAU * hz * t).sin()
    };
    (0..samples).map(at).collect()
}

/// Streams a reference and gives the drive of each of its samples.
fn followed(rig: &mut Rig, reference: &[f64]) -> Vec<f64> {
    let samples: Vec<f32> = reference.iter().map(|&v| v as f32).collect();
    let mut chunks = samples.chunks(64).enumerate().peekable();
    rig.tell(Command::ResetStream);
    rig.ticks(2);
    let mut send = |rig: &mut Rig, count: usize| {
        for _ in 0..count {
            if let Some((chunk, samples)) = chunks.next() {
                rig.stream(chunk as u32 * 64, samples);
            }
        }
    };
    send(rig, 10);
    let latency = rig.statistics().latency;
    rig.tell(Command::Start {
        path: Path::Compensated,
        waveform: Waveform::Stream,
        samples: samples.len() as u32,
    });
    rig.ticks(latency.into());
    assert_eq!(rig.statistics().played, 0);
    let mut drives = Vec::new();
    for k in 0..samples.len() {
        drives.push(drive(rig.tick().code));
        if k % 64 == 0 {
            send(rig, 1);
        }
    }
    assert_eq!(rig.statistics().played, samples.len() as u32);
    // Then it holds.
    let last = rig.last.code;
    assert!(rig.ticks(100).iter().all(|output| output.code == last));
    assert_eq!(rig.statistics().state, State::Hold);
    drives
}

#[test]
fn a_stage_that_sees_the_rate_of_its_drive_follows_the_preview() {
    let reference = smooth(4_000, 40.0, 100.0);
    let worst = |record: ModelRecord, latency: u16| {
        let mut rig = Rig::new(bipolar());
        rig.tell(Command::SetSettings(wide()));
        rig.tick();
        rig.watch(wide());
        rig.step = f64::INFINITY;
        rig.tell(Command::SetModel(Some(record)));
        rig.tick();
        assert_eq!(rig.statistics().latency, latency);
        let drives = followed(&mut rig, &reference);
        assert_eq!(rig.statistics().limited, 0);
        let came = displacement(&drives);
        let errors = came.iter().zip(&reference).skip(500).map(|(y, v)| y - v);
        errors.fold(0.0, |worst: f64, error| worst.max(error.abs()))
    };
    let explicit = worst(published(), 0);
    let ahead = worst(previewed(PlantRate::Forward), 25);
    println!("largest error {explicit} um, {ahead} um with a preview");
    // A code is 1.5 mV, and the rate of a step of it widens the thresholds by 13 mV.
    assert!(explicit > 2.0 && ahead < 0.05, "{explicit} {ahead}");
}

#[test]
fn the_cascade_undoes_lag_delay_and_curvature() {
    let (tau, delay, c) = (3e-4, 2.5e-4, 4e-5);
    let record = with(published(), |chain| {
        (chain.beta_s, chain.gain_um_per_v, chain.offset_um) = (0.0, 0.8, 3.0);
        let effects = [
            Effect::AmplifierLag { tau_s: tau as f32 },
            Effect::TransportDelay {
                delay_s: delay as f32,
            },
            Effect::Cubic { c: c as f32 },
        ];
        chain.effects = heapless::Vec::from_slice(&effects).unwrap();
        chain.inverse = Inverse::Cascade(preview(PlantRate::Midpoint));
    });
    let reference: Vec<f64> = smooth(4_000, 25.0, 50.0).iter().map(|v| v + 3.0).collect();
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetSettings(wide()));
    rig.tick();
    rig.watch(wide());
    rig.step = f64::INFINITY;
    rig.tell(Command::SetModel(Some(record)));
    rig.tick();
    // Two samples of the lag, and four of a delay of two and a half.
    assert_eq!(rig.statistics().latency, 6);
    let drives = followed(&mut rig, &reference);
    // The stage in steps of a fiftieth: the lag by its equation, the delay by a queue.
    const FINE: usize = 50;
    let mut late = vec![0.0; (delay / H * FINE as f64).round() as usize];
    let (mut before, mut lagged, mut at) = (0.0, 0.0, 0);
    let thresholds = [9.715f32, 19.43, 29.145].map(f64::from);
    let weights = [0.2906f32, 0.0416, 0.1512].map(f64::from);
    let mut plays = [0.0f64; 3];
    let mut worst = 0.0f64;
    for (k, (&u, &wanted)) in drives.iter().zip(&reference).enumerate() {
        let mut input = 0.0;
        for i in 1..=FINE {
            let target: f64 = before + (u - before) * i as f64 / FINE as f64;
            lagged += (target - lagged) * (1.0 - (-H / FINE as f64 / tau).exp());
            input = std::mem::replace(&mut late[at], lagged);
            at = (at + 1) % late.len();
        }
        before = u;
        let mut w = f64::from(0.7236f32) * input;
        for i in 0..3 {
            plays[i] = input - (input - plays[i]).clamp(-thresholds[i], thresholds[i]);
            w += weights[i] * plays[i];
        }
        let y = 3.0 + 0.8 * (w + c * w * w * w);
        // Behind its end the reference rests, which leaps its rate: the drive knows that before.
        if k > 100 && k + 10 < reference.len() {
            worst = worst.max((y - wanted).abs());
        }
    }
    println!("largest error {worst} um");
    // The lag and the delay alone are 0.55 ms: 4 um at 50 Hz.
    assert!(worst < 0.05, "{worst}");
}

#[test]
fn the_cascade_undoes_backlash_and_interleaving() {
    let (width, g) = (2.0, 4e-3);
    let reference: Vec<f64> = smooth(4_000, 25.0, 50.0).iter().map(|v| v + 3.0).collect();
    let worst = |inverse| {
        let record = with(published(), |chain| {
            (chain.beta_s, chain.gain_um_per_v, chain.offset_um) = (0.0, 0.8, 3.0);
            let effects = [
                Effect::Backlash {
                    width: width as f32,
                },
                Effect::Interleaving { g: g as f32 },
            ];
            chain.effects = heapless::Vec::from_slice(&effects).unwrap();
            chain.inverse = inverse;
        });
        let mut rig = Rig::new(bipolar());
        rig.tell(Command::SetSettings(wide()));
        rig.tick();
        rig.watch(wide());
        rig.step = f64::INFINITY;
        rig.tell(Command::SetModel(Some(record)));
        rig.tick();
        assert_eq!(rig.statistics().latency, 0);
        let drives = followed(&mut rig, &reference);
        let thresholds = [9.715f32, 19.43, 29.145].map(f64::from);
        let weights = [0.2906f32, 0.0416, 0.1512].map(f64::from);
        let (mut plays, mut joint, mut product) = ([0.0f64; 3], 0.0f64, 0.0);
        let mut worst = 0.0f64;
        for (&u, &wanted) in drives.iter().zip(&reference) {
            let mut w = f64::from(0.7236f32) * u;
            for i in 0..3 {
                plays[i] = u - (u - plays[i]).clamp(-thresholds[i], thresholds[i]);
                w += weights[i] * plays[i];
            }
            joint = joint.clamp(w - width / 2.0, w + width / 2.0);
            let y = 0.8 * joint + product;
            product = g * y * u;
            worst = worst.max((3.0 + y - wanted).abs());
        }
        worst
    };
    let without = worst(Inverse::Explicit);
    let with = worst(Inverse::Cascade(preview(PlantRate::Midpoint)));
    println!("largest error {without} um, {with} um with the cascade");
    // A gap of 1.6 um, of which a turn may take a 256th; a product of a tenth; a code is 1.5 mV.
    assert!(without > 1.5 && with < 0.02, "{without} {with}");
}

/// The largest step of the codes between neighbouring samples.
fn largest_step(codes: &[u16]) -> u16 {
    let steps = codes.windows(2).map(|pair| pair[0].abs_diff(pair[1]));
    steps.max().unwrap()
}

fn codes(rig: &mut Rig, count: usize) -> Vec<u16> {
    rig.ticks(count).iter().map(|output| output.code).collect()
}

#[test]
fn the_fallback_goes_on_with_the_very_next_sample() {
    let start = |record: ModelRecord| {
        let mut rig = Rig::new(bipolar());
        rig.tell(Command::SetSettings(wide()));
        rig.tick();
        rig.watch(wide());
        rig.step = f64::INFINITY;
        rig.tell(Command::SetModel(Some(record)));
        rig.tick();
        rig.tell(Command::Start {
            path: Path::Compensated,
            waveform: sine(25.0, 20.0),
            samples: 0,
        });
        rig
    };
    let mut rig = start(previewed(PlantRate::Midpoint));
    rig.ticks(1_100);
    let usual = largest_step(&codes(&mut rig, 500));
    let played = rig.statistics().played;
    rig.tell(Command::SetModel(Some(published())));
    // One sample stood still, none was left out, and the next one is no larger a step than any other.
    assert_eq!(rig.statistics().played, played);
    let mut around = vec![rig.last.code];
    around.extend(codes(&mut rig, 4_000));
    assert_eq!(rig.statistics().played, played + 4_000);
    let ramp = exact_code(&wide(), 0.2) - exact_code(&wide(), 0.0);
    let allowed = f64::from(usual) + ramp + 2.0;
    let largest = largest_step(&around);
    assert!(f64::from(largest) <= allowed, "{largest} of {allowed}");
    // And it is where it would be if it had been the fallback from the beginning.
    let mut alone = start(published());
    alone.ticks(played as usize + 4_000);
    assert_eq!(alone.statistics().played, played + 4_000);
    assert_eq!(codes(&mut rig, 1_000), codes(&mut alone, 1_000));
}

#[test]
fn a_preview_takes_over_after_its_latency_without_a_jump() {
    let settings = Settings {
        slew_v_per_s: 20_000.0,
        ..wide()
    };
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetSettings(settings));
    rig.tick();
    rig.watch(settings);
    rig.step = firmware_rig::step_in_codes(&settings);
    rig.tell(Command::SetModel(Some(published())));
    rig.tick();
    rig.start(Path::Compensated, sine(25.0, 20.0));
    rig.ticks(1_123);
    for round in 0..20 {
        let played = rig.statistics().played;
        rig.tell(Command::SetModel(Some(previewed(PlantRate::Midpoint))));
        // The reference stands still for the latency, and the output but for what its bias fades by.
        let still = codes(&mut rig, 25);
        let ramp = exact_code(&settings, 0.2) - exact_code(&settings, 0.0);
        assert!(f64::from(largest_step(&still)) <= ramp + 1.0);
        assert_eq!(rig.statistics().played, played, "round {round}");
        rig.ticks(300 + round);
        assert_eq!(rig.statistics().played, played + 300 + round as u32);
        // Even before the first drive of its own has come, nothing of the reference is lost.
        rig.tell(Command::SetModel(Some(published())));
        rig.tick();
        rig.tell(Command::SetModel(Some(previewed(PlantRate::Backward))));
        rig.ticks(11);
        rig.tell(Command::SetModel(Some(published())));
        rig.ticks(200);
        assert_eq!(rig.statistics().played, played + 300 + round as u32 + 201);
    }
    assert_eq!(rig.statistics().state, State::Run);
}

#[test]
fn a_recording_begins_with_the_drive_of_the_first_sample() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetModel(Some(previewed(PlantRate::Midpoint))));
    rig.tick();
    rig.tell(Command::Record { every: 1 });
    rig.ticks(3);
    while rig.server.recorded(true).is_some() {}
    rig.start(Path::Compensated, sine(10.0, 100.0));
    let outputs = codes(&mut rig, 129);
    let mut frame = rig.server.recorded(true).unwrap().to_vec();
    frame.pop();
    let Message::Recorded { first, codes } = hysteron::link::decode(&mut frame).unwrap() else {
        panic!("no recording");
    };
    assert_eq!(first, 0);
    let recorded: Vec<u16> = codes.iter().map(|codes| codes.drive).collect();
    assert_eq!(recorded, outputs[25..25 + recorded.len()]);
    // Until then the stage rested where the reference begins.
    assert!(outputs[..26].iter().all(|&code| code == 0x8000));
    assert!(outputs[26] > 0x8000);
}

#[test]
fn a_stream_that_runs_dry_is_waited_for_and_goes_on() {
    let mut rig = Rig::new(bipolar());
    rig.tell(Command::SetModel(Some(previewed(PlantRate::Midpoint))));
    let samples: Vec<f32> = smooth(192, 20.0, 50.0).iter().map(|&v| v as f32).collect();
    for (chunk, samples) in samples[..128].chunks(64).enumerate() {
        rig.stream(chunk as u32 * 64, samples);
    }
    rig.start(Path::Compensated, Waveform::Stream);
    rig.ticks(150);
    // What the compensator looks at is still to come.
    assert_eq!(rig.statistics().played, 128 - 25);
    let held = rig.last.code;
    rig.stream(128, &samples[128..]);
    let after = codes(&mut rig, 64);
    assert_eq!(rig.statistics().played, 192 - 25);
    assert_eq!(rig.statistics().underruns, 1);
    assert!(after[0].abs_diff(held) <= 1);
}
