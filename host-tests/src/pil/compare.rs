//! Two models' compensators in the emulated firmware, on one stage, along one reference.

use std::path::Path;
use std::time::Duration;

use hysteron::control;
use hysteron::link::Command;
use serde_json::{Value, json};

use super::bench::{Bench, Hardware, Plant};
use super::emulator::Emulator;
use super::experiment::Errors;
use super::replica::{Pair, Replica};
use crate::error::Error;
use crate::link::model::{self, Choice};
use crate::link::{Client, Excitation, play};
use crate::model_file::ModelFile;
use crate::stage;

/// What is compared.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'a> {
    /// Its name, for readers.
    pub name: &'a str,
    /// The model to beat.
    pub baseline: (&'a ModelFile, Choice),
    /// The model with what the other one lacks.
    pub extended: (&'a ModelFile, Choice),
    /// Converter, amplifier and sensor; their sample rate is that of plant and reference.
    pub hardware: Hardware,
    /// Reference in um.
    pub reference_um: &'a [f64],
    /// Samples at its beginning that do not count in the errors.
    pub skipped: usize,
}

/// What one compensator reached.
#[derive(Clone, Debug)]
pub struct Reached {
    /// Name of the model.
    pub model: String,
    /// Name of the compensator.
    pub inverse: &'static str,
    /// Displacement in um, a value for each sample of the reference.
    pub displacement_um: Vec<f64>,
    /// Error against the reference.
    pub error: Errors,
    /// Samples that the compensator looks ahead.
    pub latency: usize,
    /// Stages of the model that no compensator undoes.
    pub left_out: Vec<&'static str>,
    /// Least, median and most instructions of a sample.
    pub instructions: (u32, u32, u32),
    /// Samples in which range or slew of the settings held the drive back.
    pub limited: u32,
}

/// Both side by side.
#[derive(Clone, Debug)]
pub struct Compared {
    /// As in the [`Comparison`].
    pub name: String,
    /// As in the [`Comparison`].
    pub reference_um: Vec<f64>,
    /// With the model to beat.
    pub baseline: Reached,
    /// With the extended one.
    pub extended: Reached,
    /// Samples in which firmware and host were compared.
    pub samples: u64,
    /// Where firmware and host first differed; `None` when they agreed bit for bit.
    pub first_difference: Option<String>,
    /// Time between samples in s.
    pub sample_time_s: f64,
}

/// Plays the reference through both compensators, each after power-on before a new stage of `plant`.
///
/// # Errors
/// No emulator, a firmware that does not answer as it should, a model that it refuses, a plant that
/// fails, a displacement beyond the sensor.
pub fn compare(
    firmware: &Path,
    comparison: &Comparison<'_>,
    plant: &dyn Fn() -> Result<Plant, Error>,
) -> Result<Compared, Error> {
    let mut samples = 0;
    let mut first_difference = None;
    let mut follow = |(file, choice)| -> Result<Reached, Error> {
        let pair = Pair::new(Emulator::start(firmware)?, Replica::power_on()?);
        let mut bench = Bench::around(pair, comparison.hardware, plant()?);
        let reached = reach(&mut bench, comparison, file, choice)?;
        let pair = bench.into_target();
        samples += pair.samples();
        if first_difference.is_none() {
            first_difference = pair.first_difference().map(str::to_owned);
        }
        Ok(reached)
    };
    let baseline = follow(comparison.baseline)?;
    let extended = follow(comparison.extended)?;
    Ok(Compared {
        name: comparison.name.to_owned(),
        reference_um: comparison.reference_um.to_vec(),
        baseline,
        extended,
        samples,
        first_difference,
        sample_time_s: comparison.hardware.sample_time_s(),
    })
}

/// A plant that is a model itself, stepped at the control rate; at rest at 0 V.
///
/// # Errors
/// A model that the core refuses, or a modified play model.
pub fn model_plant(file: &ModelFile, sample_time_s: f64) -> Result<Plant, Error> {
    let chain = Box::new(stage::chain(file, sample_time_s)?);
    let mut state = Box::new(chain.start(0.0));
    Ok(Box::new(move |drive_v| Ok(chain.step(&mut state, drive_v))))
}

fn reach(
    bench: &mut Bench<Pair>,
    comparison: &Comparison<'_>,
    file: &ModelFile,
    choice: Choice,
) -> Result<Reached, Error> {
    let settings = comparison.hardware.settings;
    let prepared = model::record(file, &settings, choice)?;
    let excitation = Excitation::streamed(control::Path::Compensated, comparison.reference_um)?;
    let played = {
        let (mut client, _) = Client::connect(bench)?;
        // The first sample after power-on.
        client.wait(Duration::from_millis(1))?;
        client.tell(Command::SetSettings(settings))?;
        client.tell(Command::SetModel(Some(prepared.record)))?;
        play(&mut client, &excitation, true, &mut |_| {})?
    };
    let mut counts = bench.take_instructions();
    counts.sort_unstable();
    let at = |index: usize| counts.get(index).copied().unwrap_or_default();
    let displacement_um = played.signals.displacement_um;
    let from = comparison.skipped.min(displacement_um.len());
    let error = Errors::of(&displacement_um[from..], &comparison.reference_um[from..])
        .map_err(|error| Error::request(format!("{}: {error}", comparison.name)))?;
    Ok(Reached {
        model: file.name.clone(),
        inverse: choice.name(),
        displacement_um,
        error,
        latency: prepared.latency,
        left_out: prepared.left_out,
        instructions: (
            at(0),
            at(counts.len() / 2),
            at(counts.len().saturating_sub(1)),
        ),
        limited: played.limited,
    })
}

impl Reached {
    fn to_json(&self, sample_time_s: f64) -> Value {
        let (min, median, max) = self.instructions;
        json!({
            "model": self.model,
            "inverse": self.inverse,
            "error_um": { "max": self.error.max_um, "rms": self.error.rms_um },
            "left_out": self.left_out,
            "latency_samples": self.latency,
            "latency_s": self.latency as f64 * sample_time_s,
            "instructions_per_tick": { "min": min, "median": median, "max": max },
            "limited_samples": self.limited,
        })
    }
}

impl Compared {
    /// Whether firmware and host agreed in every sample and every link byte.
    pub fn bit_exact(&self) -> bool {
        self.first_difference.is_none()
    }

    /// The content of `pil.json` of a comparison.
    pub fn to_json(&self) -> Value {
        json!({
            "name": self.name,
            "bit_exact": self.bit_exact(),
            "samples": self.samples,
            "baseline": self.baseline.to_json(self.sample_time_s),
            "extended": self.extended.to_json(self.sample_time_s),
        })
    }
}
