//! Faults of sensor, values, models and time.

use hysteron::control::Path;
use hysteron::feedback::{Feedback, Gains, State};
use hysteron::link::{Answer, Command, Refusal};
use hysteron::record::ModelRecord;
use hysteron::reference::{Tone, Waveform};
use hysteron::safety::{Cause, Safety};
use hysteron::settings::{Settings, SettingsError};

use super::judge::{FAULT, OFF, RUN};
use super::material::{anywhere, furnish, model};
use super::rig::{Rig, Stop, Subject, broken};

/// Samples of a period at 10 kHz.
const PERIOD: usize = 200;
const FREQUENCY_HZ: f32 = 50.0;

/// The same motion with a good sensor and with one that `jumps`, or is stuck.
pub fn sensor<S: Subject>(rig: &mut Rig<S>, jumps: bool) -> Result<(), Stop> {
    let path = if rig.dice.one_in(2) {
        Path::Direct
    } else {
        Path::Compensated
    };
    let count = PERIOD / 2 + rig.dice.below(PERIOD);
    let mut motions = [Vec::new(), Vec::new()];
    let model = model(&mut rig.dice);
    for (bad, codes) in motions.iter_mut().enumerate() {
        // Anew, so that both begin with the same plays.
        rig.tell(&Command::SetModel(Some(model.clone())))?;
        rig.ticks(3)?;
        rig.start(path, rig.sine(FREQUENCY_HZ))?;
        rig.sensor = rig.dice.bits() as u16;
        for _ in 0..count {
            if bad == 1 && jumps {
                rig.sensor = rig.dice.bits() as u16;
            }
            codes.push(rig.tick(false)?.code);
        }
        rig.sensor = 2048;
        rig.rests()?;
    }
    let [good, bad] = motions;
    if good != bad {
        return broken("the drive depends on the sensor");
    }
    Ok(())
}

/// The feedback of the core, which the firmware of today does not close: NaN goes no further.
pub fn sensor_not_finite<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let limits = match rig.judge.settings().validate() {
        Ok(valid) => valid.limits,
        Err(error) => return broken(format!("settings in force are refused: {error:?}")),
    };
    let gains = Gains {
        proportional: 0.1,
        integral: 50.0,
        derivative: 0.0,
        filter: 0.0,
    };
    let feedback = Feedback::new(gains, 1e-4f32, limits.lowest, limits.highest)
        .map_err(|error| format!("feedback: {error:?}"))?;
    let mut state = State::at_rest(0.0);
    let mut safety = Safety::new(&limits);
    safety.run();
    let at = rig.dice.below(100);
    let wrong = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let wrong = wrong[rig.dice.below(3)];
    let mut last = safety.output();
    for k in 0..at + 1 + rig.way_to_rest() {
        let measured = if k == at {
            wrong
        } else {
            rig.dice.real(-1.0, 1.0)
        };
        let before = state;
        let drive = feedback.step(&mut state, 1.0, measured, limits.rest);
        if drive.is_ok() != measured.is_finite() || (drive.is_err() && state != before) {
            return broken(format!("the feedback makes {drive:?} of {measured}"));
        }
        let output = safety.step(&limits, Some(drive.unwrap_or(f32::NAN)));
        let moved = (f64::from(output) - f64::from(last)).abs();
        let within = (limits.lowest..=limits.highest).contains(&output);
        if !within || moved > f64::from(limits.slew) * (1.0 + 1e-5) {
            return broken(format!("{output} V, moved by {moved} V"));
        }
        last = output;
    }
    if safety.cause() != Some(Cause::NotFinite) || last != limits.rest {
        return broken(format!("ends at {last} V, cause {:?}", safety.cause()));
    }
    Ok(())
}

/// Settings with one field that no target takes, and how it is named.
fn bad_settings<S: Subject>(rig: &mut Rig<S>) -> (Settings, SettingsError) {
    use SettingsError as E;
    let mut settings = rig.judge.settings();
    let wild = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][rig.dice.below(3)];
    let much = rig.dice.real(1.0, 1e6);
    let error = match rig.dice.below(13) {
        0 => {
            settings.version += 1 + much as u16 / 2;
            E::Version
        }
        1 => {
            settings.sample_rate_hz = wild;
            E::SampleRate
        }
        2 => {
            settings.sample_rate_hz = 20_000.0 + much;
            E::SampleRate
        }
        3 => {
            settings.amplifier_gain = 0.0;
            E::Amplifier
        }
        4 => {
            settings.amplifier_gain = f32::NAN;
            E::Amplifier
        }
        5 => {
            settings.sensor_um_per_v = wild;
            E::Sensor
        }
        6 => {
            settings.drive_max_v = wild;
            E::DriveRange
        }
        7 => {
            settings.drive_min_v = settings.drive_max_v + much;
            E::DriveRange
        }
        8 => {
            settings.drive_rest_v = settings.drive_max_v + much;
            E::Rest
        }
        9 => {
            settings.slew_v_per_s = wild;
            E::Slew
        }
        10 => {
            settings.ramp_v_per_s = settings.slew_v_per_s + much;
            E::Ramp
        }
        11 => {
            settings.ramp_v_per_s = -much;
            E::Ramp
        }
        _ => {
            settings.stale_s = 60.0 + much;
            E::Stale
        }
    };
    (settings, error)
}

/// Settings out of range, at rest.
pub fn settings_out_of_range<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let (settings, error) = bad_settings(rig);
    let answer = rig.insist(&Command::SetSettings(settings))?;
    if answer != Answer::Refused(Refusal::Settings(error)) {
        return broken(format!("{answer:?} where {error:?} was due: {settings:?}"));
    }
    Ok(())
}

/// A model out of range, in any state.
pub fn bad_model<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let state = anywhere(rig)?;
    let mut record = model(&mut rig.dice);
    let wild = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][rig.dice.below(3)];
    let at = rig.dice.below(3);
    if let ModelRecord::Chain(chain) = &mut record {
        match rig.dice.below(6) {
            0 => chain.thresholds_v[at] = wild,
            1 => chain.weights[at] = wild,
            2 => chain.beta_s = wild,
            3 => chain.gain_um_per_v = 0.0,
            4 => chain.thresholds_v[2] = chain.thresholds_v[0],
            _ => chain.weights[0] = -rig.dice.real(0.1, 9.0),
        }
    }
    let answer = rig.insist(&Command::SetModel(Some(record.clone())))?;
    if !matches!(answer, Answer::Refused(Refusal::Model(_))) {
        return broken(format!("{answer:?} to {record:?}"));
    }
    let now = rig.ticks(3)?.state;
    if now != state {
        return broken(format!("a refused model leads from state {state} to {now}"));
    }
    Ok(())
}

/// In a fault of this cause, or on the way to it; ramps to rest, and only Clear leaves it.
fn faults<S: Subject>(rig: &mut Rig<S>, cause: Cause) -> Result<(), Stop> {
    let way = rig.way_to_rest();
    let last = rig.ticks(way)?;
    let found = rig.statistics()?.cause;
    if last.state != FAULT || last.driver_enabled || found != Some(cause) {
        return broken(format!(
            "{last:?}, cause {found:?}, where {cause:?} was due"
        ));
    }
    let waveform = rig.sine(FREQUENCY_HZ);
    let start = Command::Start {
        path: Path::Direct,
        waveform,
        samples: 0,
    };
    for command in [start, Command::Hold] {
        let answer = rig.insist(&command)?;
        if answer != Answer::Refused(Refusal::State) {
            return broken(format!("{answer:?} in a fault, to {command:?}"));
        }
    }
    rig.tell(&Command::Stop)?;
    if rig.ticks(2)?.state != FAULT {
        return broken("Stop leaves a fault");
    }
    rig.tell(&Command::Clear)?;
    if rig.ticks(2)?.state != OFF {
        return broken("Clear does not leave a fault");
    }
    Ok(())
}

/// References with NaN or infinity, and such that get there.
pub fn reference_not_finite<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let wild = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY][rig.dice.below(3)];
    let tone = |amplitude| Tone {
        amplitude,
        frequency_hz: FREQUENCY_HZ,
    };
    let tones = |amplitude| Waveform::Tones {
        offset: 0.0,
        tones: [tone(amplitude); 2],
    };
    match rig.dice.below(3) {
        0 => {
            let samples = [0.0, wild, 1.0].into_iter().collect();
            let answer = rig.ask(&Command::Stream { first: 0, samples })?;
            if answer != Answer::Refused(Refusal::NotFinite) {
                return broken(format!("{answer:?} to a stream with {wild}"));
            }
            Ok(())
        }
        1 => {
            let start = Command::Start {
                path: Path::Direct,
                waveform: tones(wild),
                samples: 0,
            };
            let answer = rig.insist(&start)?;
            if !matches!(answer, Answer::Refused(Refusal::Waveform(_))) {
                return broken(format!("{answer:?} to a tone of {wild}"));
            }
            Ok(())
        }
        _ => {
            // Each is finite, their sum at the crest is not.
            rig.start(Path::Direct, tones(3e38))?;
            rig.ticks(PERIOD / 2)?;
            faults(rig, Cause::NotFinite)
        }
    }
}

/// Another model at this phase of a cycle.
pub fn model_swap<S: Subject>(rig: &mut Rig<S>, phase: usize) -> Result<(), Stop> {
    rig.start(Path::Compensated, rig.sine(FREQUENCY_HZ))?;
    rig.ticks(PERIOD + phase % PERIOD)?;
    let model = model(&mut rig.dice);
    rig.tell(&Command::SetModel(Some(model)))?;
    let before = rig.statistics()?.played;
    let last = rig.ticks(1 + PERIOD)?;
    let now = rig.statistics()?;
    // The sample of the order and what the next compensator looks ahead.
    let least = PERIOD as u32 - u32::from(now.latency);
    if last.state != RUN || now.played.wrapping_sub(before) < least {
        return broken(format!("after a swap at phase {phase}: {last:?}, {now:?}"));
    }
    Ok(())
}

/// No model for what is being compensated.
pub fn model_removed<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    rig.start(Path::Compensated, rig.sine(FREQUENCY_HZ))?;
    let pause = 1 + rig.dice.below(2 * PERIOD);
    rig.ticks(pause)?;
    rig.tell(&Command::SetModel(None))?;
    rig.ticks(3)?;
    faults(rig, Cause::NoModel)
}

/// Settings and flash are for an output at rest.
pub fn settings_in_motion<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    rig.start(Path::Direct, rig.sine(FREQUENCY_HZ))?;
    let pause = 2 + rig.dice.below(PERIOD);
    rig.ticks(pause)?;
    match rig.dice.below(3) {
        0 => {}
        1 => rig.tell(&Command::Hold)?,
        _ => rig.tell(&Command::Stop)?,
    }
    if !rig.ticks(2)?.driver_enabled {
        // It was there already; in Hold it counts as moving wherever it stands.
        rig.tell(&Command::Hold)?;
        rig.ticks(2)?;
    }
    let settings = super::material::settings(&mut rig.dice);
    for command in [Command::SetSettings(settings), Command::Save] {
        let answer = rig.ask(&command)?;
        if answer != Answer::Refused(Refusal::State) {
            return broken(format!("{answer:?} in motion, to {command:?}"));
        }
    }
    Ok(())
}

/// Samples that come too late.
pub fn overrun<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    rig.start(Path::Direct, rig.sine(FREQUENCY_HZ))?;
    let pause = 1 + rig.dice.below(PERIOD);
    rig.ticks(pause)?;
    let limit = usize::from(rig.judge.settings().miss_limit);
    let late = 1 + rig.dice.below(2 * limit + 2);
    for _ in 0..late {
        rig.tick(true)?;
        let pause = 1 + rig.dice.below(3);
        rig.ticks(pause)?;
    }
    if late > limit {
        return faults(rig, Cause::Deadline);
    }
    let state = rig.tick(false)?.state;
    if state != RUN {
        return broken(format!("{late} late samples lead to state {state}"));
    }
    Ok(())
}

/// The watchdog resets the board, somewhere; what was saved is there again.
pub fn reset<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    if rig.dice.one_in(2) {
        rig.tell(&Command::Save)?;
        rig.tick(false)?;
    }
    anywhere(rig)?;
    let model = model(&mut rig.dice);
    rig.insist(&Command::SetModel(Some(model)))?;
    let pause = 1 + rig.dice.below(PERIOD);
    rig.ticks(pause)?;
    rig.reset()?;
    rig.ask(&Command::GetSettings)?;
    rig.ask(&Command::GetModel)?;
    furnish(rig)
}
