//! Plays a reference and records what the stage does meanwhile.

use std::time::Duration;

use hysteron::control::Path;
use hysteron::link::Command;
use hysteron::reference::Waveform;
use hysteron::safety::{Cause, State};
use hysteron::sensor;
use hysteron::settings::Settings;
use hysteron::telemetry::{Codes, Statistics};

use super::capture::Capture;
use super::client::Client;
use super::excitation::{Excitation, Shape};
use super::refusal;
use super::stream::Feed;
use crate::error::Error;

/// How long nothing is sent when there is nothing to send.
const PAUSE: Duration = Duration::from_millis(5);
/// How often the target is asked how it fares.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Recorded samples must come at least this often.
const SILENCE_LIMIT: Duration = Duration::from_secs(2);
/// Samples between `Record` and `Start` that may still be under way when the start is confirmed: what
/// the target's queue holds, and as many of an earlier recording.
const LEAD_LEN: usize = 2 * hysteron::telemetry::QUEUE_LEN;

/// A reference that was played to its end.
#[derive(Clone, Debug, PartialEq)]
pub struct Played {
    /// When its first sample was put out, in s since the target was switched on; exact to a sample.
    pub start_s: f64,
    /// Time between samples in s.
    pub sample_time_s: f64,
    /// What was recorded; empty unless it was asked for.
    pub signals: Signals,
    /// Samples in which the target's range or slew limit held the drive back.
    pub limited: u32,
}

/// Recorded signals, one value for each sample of the reference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// Drive at the actuator in V, as its converter put it out.
    pub drive_v: Vec<f64>,
    /// Displacement in um at the end of the sample: the answer to the drive beside it.
    pub displacement_um: Vec<f64>,
}

/// Stops the output unless the work came to its end, whatever that was.
struct Moving<'c, 'p> {
    client: &'c mut Client<'p>,
    arrived: bool,
}

impl Drop for Moving<'_, '_> {
    fn drop(&mut self) {
        if !self.arrived {
            // Only in a panic: there is nobody left to tell.
            let _ = self.client.stop();
        }
    }
}

/// Plays `excitation` from its first sample to its last, after which the output holds. `progress` is
/// told how many samples are done.
///
/// # Errors
/// What [`Excitation::check`] refuses, an output that is not Off or in Hold, a fault, a stream that
/// ran dry, recorded samples that were lost, a sensor at the end of its range while recording,
/// [`Error::Interrupted`]. After any of them the output was told to stop.
pub fn play(
    client: &mut Client<'_>,
    excitation: &Excitation,
    record: bool,
    progress: &mut dyn FnMut(u64),
) -> Result<Played, Error> {
    let settings = client.settings()?;
    excitation.check(&settings)?;
    let before = client.statistics()?;
    refuse_fault(&before)?;
    if before.state == State::Run {
        return Err(Error::request(
            "the output follows a reference already; `stop` it first",
        ));
    }
    let mut moving = Moving {
        client,
        arrived: false,
    };
    let played = run(moving.client, excitation, &settings, record, progress);
    moving.arrived = true;
    played.map_err(|error| match moving.client.stop() {
        Ok(()) => error,
        Err(_) => Error::request(format!(
            "{error}; nor could it be told to stop: a stream ramps to rest by itself, any other \
             reference goes on to its end"
        )),
    })
}

fn run(
    client: &mut Client<'_>,
    excitation: &Excitation,
    settings: &Settings,
    record: bool,
    progress: &mut dyn FnMut(u64),
) -> Result<Played, Error> {
    let rate = f64::from(settings.sample_rate_hz);
    let samples = excitation.samples;
    client.tell(Command::Record { every: 0 })?;
    let mut feed = match &excitation.shape {
        Shape::Sent(values) => Some(Feed::fill(client, values, rate)?),
        Shape::Built(_) => None,
    };
    client.take_blocks();
    let before = client.statistics()?;
    let mut capture = Capture::default();
    if record {
        client.tell(Command::Record { every: 1 })?;
    }
    client.tell(Command::Start {
        path: excitation.path,
        waveform: match &excitation.shape {
            Shape::Built(waveform) => *waveform,
            Shape::Sent(_) => Waveform::Stream,
        },
        samples,
    })?;
    collect(client, &mut capture)?;
    // As many samples in a row can only be those of the reference. The sensor answers a sample late,
    // hence one more.
    let enough = (samples as usize + 1).max(capture.len() + LEAD_LEN);
    let start_tick = start_tick(client, samples)?;

    let mut look_at = client.now();
    let mut heard = (capture.len(), client.now());
    loop {
        collect(client, &mut capture)?;
        if let Some(feed) = &mut feed {
            feed.pump(client)?;
        }
        if client.now() >= look_at {
            look_at = client.now() + LOOK_EVERY;
            let now = client.statistics()?;
            refuse_trouble(&before, &now)?;
            progress(u64::from(now.played.min(samples)));
            if now.state != State::Run && now.played >= samples && !record {
                break;
            }
        }
        if record {
            if capture.len() >= enough {
                break;
            }
            if capture.len() != heard.0 {
                heard = (capture.len(), client.now());
            } else if client.now() > heard.1 + SILENCE_LIMIT {
                return Err(Error::request(
                    "no more recorded samples come; check the line and start again",
                ));
            }
        }
        client.wait(PAUSE)?;
    }
    client.tell(Command::Record { every: 0 })?;
    let after = client.statistics()?;
    refuse_trouble(&before, &after)?;
    progress(u64::from(samples));
    let mut codes = capture.into_codes();
    codes.truncate(if record { samples as usize + 1 } else { 0 });
    Ok(Played {
        start_s: f64::from(start_tick) / rate,
        sample_time_s: 1.0 / rate,
        signals: signals(&codes, settings)?,
        limited: after.limited.wrapping_sub(before.limited),
    })
}

fn collect(client: &mut Client<'_>, capture: &mut Capture) -> Result<(), Error> {
    client
        .take_blocks()
        .into_iter()
        .try_for_each(|block| capture.take(block))
}

/// The tick in which the first sample of the reference was put out.
fn start_tick(client: &mut Client<'_>, samples: u32) -> Result<u32, Error> {
    let limit = client.now() + SILENCE_LIMIT;
    let confirmed_at = client.statistics()?.ticks;
    loop {
        let now = client.statistics()?;
        refuse_fault(&now)?;
        // A start is obeyed in the sample after it. Once the last sample was played, which only the
        // shortest references have by now, the ticks since then cannot be told.
        let obeyed = now.ticks.wrapping_sub(confirmed_at) >= 2;
        if obeyed && now.played > 0 && (now.state == State::Run || now.played >= samples) {
            return Ok(now.ticks.wrapping_sub(now.played - 1));
        }
        if client.now() > limit {
            return Err(Error::request(
                "the start was confirmed, but nothing is played; see whether the target's samples \
                 go on",
            ));
        }
        client.wait(Duration::from_millis(1))?;
    }
}

fn refuse_fault(now: &Statistics) -> Result<(), Error> {
    if now.state != State::Fault {
        return Ok(());
    }
    let why = match now.cause {
        Some(Cause::NotFinite) => "the reference or the model yields no finite drive",
        Some(Cause::Deadline) => "samples came too late",
        Some(Cause::NoModel) => "there is no model",
        None => "the target does not say why",
    };
    Err(Error::request(format!(
        "the output is in a fault: {why}; `clear` it"
    )))
}

fn refuse_trouble(before: &Statistics, now: &Statistics) -> Result<(), Error> {
    refuse_fault(now)?;
    if now.underruns != before.underruns {
        return Err(Error::request(
            "the stream ran dry; close other programs, use a faster line or lower sample_rate_hz",
        ));
    }
    if now.dropped != before.dropped {
        return Err(Error::request(format!(
            "the target dropped {} recorded samples; use a faster line or lower sample_rate_hz",
            now.dropped.wrapping_sub(before.dropped)
        )));
    }
    if now.state == State::Off {
        return Err(Error::request(
            "the output was told to stop by somebody else",
        ));
    }
    Ok(())
}

/// Codes in V and um: the sensor's code answers the drive of the sample before it.
fn signals(codes: &[Codes], settings: &Settings) -> Result<Signals, Error> {
    let valid = settings
        .validate()
        .map_err(|error| Error::request(refusal::setting(error)))?;
    let answers = codes.get(1..).unwrap_or_default();
    let at_end = answers
        .iter()
        .filter(|codes| codes.sensor == 0 || codes.sensor >= sensor::MAX_CODE)
        .count();
    if at_end > 0 {
        return Err(Error::request(format!(
            "the sensor is at the end of its range in {at_end} samples; check its wiring, or drive \
             the stage less far"
        )));
    }
    Ok(Signals {
        drive_v: codes
            .iter()
            .take(answers.len())
            .map(|codes| f64::from(valid.dac.drive(codes.drive)))
            .collect(),
        displacement_um: answers
            .iter()
            .map(|codes| f64::from(valid.sensor.displacement(codes.sensor)))
            .collect(),
    })
}

impl Excitation {
    /// A drive for `samples` samples.
    pub fn drive(shape: Shape, samples: u32) -> Self {
        Self {
            path: Path::Direct,
            shape,
            samples,
        }
    }

    /// A streamed reference.
    ///
    /// # Errors
    /// More samples than can be numbered.
    pub fn streamed(path: Path, values: &[f64]) -> Result<Self, Error> {
        let samples = u32::try_from(values.len()).map_err(|_| {
            Error::request("the reference is too long for one stream; play it in parts")
        })?;
        Ok(Self {
            path,
            shape: Shape::Sent(values.iter().map(|&value| value as f32).collect()),
            samples,
        })
    }
}
