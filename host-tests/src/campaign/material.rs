//! What a trial works with: settings, models, states to be in, streams.

use hysteron::control::Path;
use hysteron::dac;
use hysteron::hysteresis::preview::PlantRate;
use hysteron::link::{Answer, CHUNK_LEN, Command};
use hysteron::record::{ChainRecord, Inverse, ModelRecord, Preview};
use hysteron::reference::Waveform;
use hysteron::settings::Settings;

use super::dice::Dice;
use super::judge::{RUN, played};
use super::rig::{Rig, Stop, Subject, broken};

/// A bench that a target accepts: both converters, both signs of the amplifier, wide and narrow.
pub fn settings(dice: &mut Dice) -> Settings {
    let wide = Settings {
        dac: dac::Kind::Bipolar16,
        drive_min_v: -45.0,
        drive_max_v: 45.0,
        slew_v_per_s: 30_000.0,
        ramp_v_per_s: 10_000.0,
        stale_s: 0.002,
        ..Settings::default()
    };
    match dice.below(4) {
        0 => wide,
        1 => Settings {
            amplifier_gain: -10.0,
            amplifier_offset_v: 2.0,
            drive_rest_v: -7.0,
            ..wide
        },
        2 => Settings {
            dac: dac::Kind::Internal12,
            drive_min_v: 0.0,
            drive_max_v: 30.0,
            drive_rest_v: 5.0,
            ..wide
        },
        _ => Settings {
            drive_min_v: -10.0,
            drive_max_v: 20.0,
            drive_rest_v: 3.0,
            slew_v_per_s: 2_500.0,
            ramp_v_per_s: 2_500.0,
            ..wide
        },
    }
}

/// A model that a target accepts: three plays with rate, inverted explicitly, from a preview, or in a
/// cascade.
pub fn model(dice: &mut Dice) -> ModelRecord {
    let scale = dice.real(0.5, 2.0);
    let ahead = Preview {
        window: 2 + dice.below(25) as u8,
        plant_rate: PlantRate::Midpoint,
    };
    ModelRecord::Chain(ChainRecord {
        thresholds_v: [9.715, 19.43, 29.145].into_iter().collect(),
        weights: [0.7236, 0.2906, 0.0416, 0.1512]
            .into_iter()
            .map(|weight: f32| weight * scale)
            .collect(),
        beta_s: 8.572e-4,
        asymmetry: None,
        effects: heapless::Vec::new(),
        gain_um_per_v: 1.0,
        offset_um: 0.0,
        inverse: match dice.below(4) {
            0 => Inverse::Preview(ahead),
            1 => Inverse::Cascade(ahead),
            _ => Inverse::Explicit,
        },
    })
}

/// A command that would change something if it arrived.
pub fn change(dice: &mut Dice) -> Command {
    match dice.below(3) {
        0 => Command::SetSettings(settings(dice)),
        1 => Command::SetModel(Some(model(dice))),
        _ => Command::SetModel(None),
    }
}

/// New settings and another model, with the output at rest.
pub fn furnish<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let settings = settings(&mut rig.dice);
    rig.tell(&Command::SetSettings(settings))?;
    let model = model(&mut rig.dice);
    rig.tell(&Command::SetModel(Some(model)))?;
    // The later order takes a sample, and the one after it obeys none.
    rig.ticks(3)?;
    Ok(())
}

/// Off, holding or running, somewhere on the way; tells the state.
pub fn anywhere<S: Subject>(rig: &mut Rig<S>) -> Result<u8, Stop> {
    let choice = rig.dice.below(4);
    if choice > 0 {
        let path = if choice == 1 {
            Path::Direct
        } else {
            Path::Compensated
        };
        rig.start(path, rig.sine(50.0))?;
    }
    let pause = 3 + rig.dice.below(200);
    rig.ticks(pause)?;
    if choice == 3 {
        rig.tell(&Command::Hold)?;
    }
    Ok(rig.ticks(2)?.state)
}

/// Samples from rest to the far side and back, within the slew limit, no two neighbours alike.
pub fn stream<S: Subject>(rig: &mut Rig<S>, len: usize) -> Vec<f32> {
    let settings = rig.judge.settings();
    let rest = settings.drive_rest_v;
    let (up, down) = (settings.drive_max_v - rest, settings.drive_min_v - rest);
    let far = if up > -down { up } else { down };
    let slew = settings.slew_v_per_s / settings.sample_rate_hz;
    let turn = std::f32::consts::TAU / len as f32;
    let swing = (0.4 * far.abs()).min(0.8 * slew / turn) * far.signum();
    (0..len)
        .map(|k| rest + swing * (1.0 - (turn * k as f32).cos()))
        .collect()
}

/// The commands that send a stream from number 0.
pub fn chunks(samples: &[f32]) -> Vec<Command> {
    let numbered = samples.chunks(CHUNK_LEN).enumerate();
    numbered
        .map(|(at, samples)| Command::Stream {
            first: (at * CHUNK_LEN) as u32,
            samples: samples.iter().copied().collect(),
        })
        .collect()
}

/// Sends a stream again from its beginning until all of it is acknowledged.
pub fn complete<S: Subject>(rig: &mut Rig<S>, samples: &[f32]) -> Result<(), Stop> {
    for chunk in chunks(samples) {
        let answer = rig.insist(&chunk)?;
        if !matches!(answer, Answer::Stream { .. }) {
            return broken(format!("{answer:?} to samples of a stream"));
        }
    }
    if rig.judge.stream().len() != samples.len() {
        return broken(format!(
            "{} samples of {} are acknowledged",
            rig.judge.stream().len(),
            samples.len()
        ));
    }
    Ok(())
}

/// Plays the acknowledged stream from rest, and what comes out must be just that.
pub fn play<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    rig.start(Path::Direct, Waveform::Stream)?;
    // The output stands still in the sample of the order.
    rig.tick(false)?;
    let stream = rig.judge.stream().to_vec();
    let mut codes = Vec::with_capacity(stream.len());
    for _ in 0..stream.len() {
        let ticked = rig.tick(false)?;
        if ticked.state == RUN {
            codes.push(ticked.code);
        }
    }
    played(&rig.judge.settings(), &stream, &codes)?;
    let count = rig.statistics()?.played;
    if count as usize != stream.len() {
        return broken(format!("{count} samples counted of {}", stream.len()));
    }
    Ok(())
}
