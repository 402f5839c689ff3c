//! What moves the stage: start, record, stream.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use serde_json::json;

use hysteron::control::Path;
use hysteron::link::Command;
use hysteron::settings::Settings;
use hysteron_host::dataset::{NewRecord, Role, add_record};
use hysteron_host::error::Error;
use hysteron_host::interrupt::{self, Deferred};
use hysteron_host::link::{Client, Excitation, Played, Shape, play};
use hysteron_host::metrics::{max_abs_error, rms_error};
use hysteron_host::output::AtomicFile;
use hysteron_host::signals::{Quantity, Signal, read};

use super::waveform::{Built, Excitation as Kind, Tones};
use crate::cli::progress;
use crate::cli::say::{self, say};

/// How far the sample time of a CSV may be from the target's, as a share of it.
const SAMPLE_TIME_TOLERANCE: f64 = 1e-4;

#[derive(Debug, Args)]
pub struct Start {
    /// What to play.
    #[arg(long, value_enum, default_value_t)]
    waveform: Built,
    /// Past the compensator: the reference is the drive in V.
    #[arg(long)]
    direct: bool,
    #[command(flatten)]
    tones: Tones,
    /// Seconds to play before the output holds; without it until `stop`.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
}

impl Start {
    pub fn run(&self, client: &mut Client<'_>) -> Result<(), Error> {
        let settings = client.settings()?;
        let samples = match self.seconds {
            Some(seconds) => samples(seconds, &settings)?,
            None => 0,
        };
        let excitation = Excitation {
            path: path(self.direct),
            shape: self.tones.built(self.waveform),
            samples: samples.max(1),
        };
        excitation.check(&settings)?;
        client.tell(Command::Start {
            path: excitation.path,
            waveform: self.tones.waveform(self.waveform),
            samples,
        })
    }
}

#[derive(Debug, Args)]
pub struct Record {
    /// The data set's folder: begun where there is none, else added to.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What drives the stage, past the compensator.
    #[arg(long, value_enum)]
    excitation: Kind,
    /// What the record serves for.
    #[arg(long, value_enum, default_value_t)]
    role: RoleChoice,
    /// Length in seconds; of a file its own.
    #[arg(long, value_name = "S", default_value_t = 1.0)]
    seconds: f64,
    #[command(flatten)]
    tones: Tones,
    /// Lines of a multisine.
    #[arg(long, value_name = "N", default_value_t = 20)]
    lines: u32,
    /// Phases of a multisine.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// CSV with the columns time_s and drive_v, for `--excitation file`.
    #[arg(long, value_name = "DRIVE.csv", required_if_eq("excitation", "file"))]
    drive: Option<PathBuf>,
    /// Name of the record's file without its ending; made from the excitation when not given.
    #[arg(long, value_name = "NAME", value_parser = file_stem)]
    name: Option<String>,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum RoleChoice {
    #[default]
    Fit,
    Select,
    Report,
}

fn file_stem(text: &str) -> Result<String, String> {
    let plain = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    if text.is_empty() || text.starts_with('.') || !text.chars().all(plain) {
        return Err("letters, digits, '-', '_' and '.' only".to_owned());
    }
    Ok(text.to_owned())
}

impl Record {
    pub fn run(&self, client: &mut Client<'_>) -> Result<(), Error> {
        let settings = client.settings()?;
        let excitation = self.excitation(&settings)?;
        let name = self.name.clone().unwrap_or_else(|| self.default_name());
        let played = watched(client, &excitation, true, "recording")?;
        client.stop()?;
        let file = add_record(
            &self.out,
            &NewRecord {
                stem: &name,
                role: match self.role {
                    RoleChoice::Fit => Role::Fit,
                    RoleChoice::Select => Role::Select,
                    RoleChoice::Report => Role::Report,
                },
                start_s: played.start_s,
                sample_time_s: played.sample_time_s,
                drive_v: &played.signals.drive_v,
                displacement_um: &played.signals.displacement_um,
            },
        )?;
        note_limited(&played);
        say!(
            "{} samples in {}; the output ramps to rest",
            played.signals.drive_v.len(),
            self.out.join(file).display()
        );
        Ok(())
    }

    fn excitation(&self, settings: &Settings) -> Result<Excitation, Error> {
        let samples = samples(self.seconds, settings)?;
        let rate = f64::from(settings.sample_rate_hz);
        let shape = match self.excitation {
            Kind::Sine => self.tones.built(Built::Sine),
            Kind::Triangle => self.tones.built(Built::Triangle),
            Kind::TwoTone => self.tones.built(Built::TwoTone),
            Kind::Multi => self.tones.multi(self.lines, self.seed, rate, samples)?,
            Kind::Rest => Shape::sine(self.tones.offset, 0.0, 0.0),
            Kind::File => {
                let Some(file) = &self.drive else {
                    return Err(Error::request("--excitation file needs --drive DRIVE.csv"));
                };
                let drive = read(file, Quantity::Drive)?;
                same_rate(&drive, settings)?;
                return Excitation::streamed(Path::Direct, &drive.values);
            }
        };
        Ok(Excitation::drive(shape, samples))
    }

    fn default_name(&self) -> String {
        let hz = self.tones.frequency;
        match self.excitation {
            Kind::Sine => format!("sine-{hz}hz"),
            Kind::Triangle => format!("triangle-{hz}hz"),
            Kind::TwoTone => format!("two-tone-{hz}hz-{}hz", self.tones.second_frequency),
            Kind::Multi => format!("multi-{hz}hz-{}", self.lines),
            Kind::Rest => "rest".to_owned(),
            Kind::File => "file".to_owned(),
        }
    }
}

#[derive(Debug, Args)]
pub struct Stream {
    /// CSV with the columns time_s and reference_um, or drive_v with --direct.
    reference: PathBuf,
    /// Past the compensator: the reference is the drive in V.
    #[arg(long)]
    direct: bool,
    /// CSV to write what happened to: time_s, the reference, drive_v, displacement_um.
    #[arg(long, value_name = "OUT.csv")]
    record: Option<PathBuf>,
    /// Ramp to rest at the end; without it the output holds.
    #[arg(long)]
    stop: bool,
}

impl Stream {
    pub fn run(&self, client: &mut Client<'_>) -> Result<(), Error> {
        let settings = client.settings()?;
        let quantity = match path(self.direct) {
            Path::Direct => Quantity::Drive,
            Path::Compensated => Quantity::Reference,
        };
        let reference = read(&self.reference, quantity)?;
        same_rate(&reference, &settings)?;
        let excitation = Excitation::streamed(path(self.direct), &reference.values)?;
        // Before anything moves: can it be written?
        let out = self.record.as_ref().map(AtomicFile::create).transpose()?;
        let played = watched(client, &excitation, out.is_some(), "streaming")?;
        if self.stop {
            client.stop()?;
        }
        if let Some(mut out) = out {
            let signals = &played.signals;
            let name = if self.direct {
                "reference_v"
            } else {
                "reference_um"
            };
            out.write_columns(&[
                ("time_s", &reference.time_s),
                (name, &reference.values),
                ("drive_v", &signals.drive_v),
                ("displacement_um", &signals.displacement_um),
            ])?;
            out.commit()?;
            if !self.direct
                && let (Ok(max), Ok(rms)) = (
                    max_abs_error(&signals.displacement_um, &reference.values),
                    rms_error(&signals.displacement_um, &reference.values),
                )
            {
                say!("error: largest {max:.4} um, rms {rms:.4} um");
                say::figures(&json!({ "error_um": { "largest": max, "rms": rms } }));
            }
        }
        note_limited(&played);
        say!(
            "{} samples played; the output {}",
            reference.values.len(),
            if self.stop { "ramps to rest" } else { "holds" }
        );
        Ok(())
    }
}

/// Plays with a bar on the terminal, and stops the stage first when Ctrl-C comes.
fn watched(
    client: &mut Client<'_>,
    excitation: &Excitation,
    record: bool,
    title: &'static str,
) -> Result<Played, Error> {
    let _deferred = Deferred::begin();
    let bar = progress::bar(title, u64::from(excitation.samples));
    let played = play(client, excitation, record, &mut |done| {
        bar.set_position(done);
    });
    bar.finish_and_clear();
    if interrupt::requested() {
        client.stop()?;
        return Err(Error::Interrupted);
    }
    played
}

fn note_limited(played: &Played) {
    if played.limited > 0 {
        say!(
            "note: range or slew limit held the drive back in {} samples; what was recorded is what \
             was put out",
            played.limited
        );
    }
}

fn path(direct: bool) -> Path {
    if direct {
        Path::Direct
    } else {
        Path::Compensated
    }
}

fn samples(seconds: f64, settings: &Settings) -> Result<u32, Error> {
    let samples = (seconds * f64::from(settings.sample_rate_hz)).round();
    if !(1.0..=1e8).contains(&samples) {
        return Err(Error::request(format!(
            "{seconds} s are {samples} samples; choose 1 to 1e8 of them"
        )));
    }
    Ok(samples as u32)
}

fn same_rate(signal: &Signal, settings: &Settings) -> Result<(), Error> {
    let sample_time_s = 1.0 / f64::from(settings.sample_rate_hz);
    if (signal.sample_time_s / sample_time_s - 1.0).abs() <= SAMPLE_TIME_TOLERANCE {
        return Ok(());
    }
    Err(Error::request(format!(
        "the file has a sample every {} s and the target every {sample_time_s} s; resample it or \
         set sample_rate_hz",
        signal.sample_time_s
    )))
}
