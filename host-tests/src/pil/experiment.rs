//! Paper J's references on the emulated firmware, with and without compensation.

use std::path::Path;

use hysteron::control;
use hysteron::link::Command;
use serde_json::{Value, json};

use super::bench::{Bench, Hardware};
use super::emulator::Emulator;
use super::firmware::{Sizes, sizes};
use super::replica::{Pair, Replica};
use crate::error::Error;
use crate::experiment::references::{self, Grid, Reference};
use crate::link::model::{self, Choice};
use crate::link::{Client, Excitation, Shape, play};
use crate::metrics::{MetricError, max_abs_error, rms_error};
use crate::model_file::{ModelFile, builtin};
use crate::plant::Stage;

/// Amplitude of the references in um; of the smaller periods in [`Kind::TwoAmplitude`] half of it.
pub const AMPLITUDE_UM: f64 = 40.0;

/// A reference of the paper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input {
    /// Its key in `pil.json`.
    pub key: &'static str,
    /// Its name for readers.
    pub name: &'static str,
    /// Its shape.
    pub kind: Kind,
    /// Periods a second.
    pub frequency_hz: f64,
    /// Whole periods that are played. The first one, with two amplitudes the first two, does not
    /// count in the error: model and stage begin in different states.
    pub periods: u32,
}

/// Shape of a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From the target's oscillator.
    Sine,
    /// From the target's oscillator.
    Triangle,
    /// Periods of two amplitudes in turn, major and minor loops; streamed by the host.
    TwoAmplitude,
}

/// What is played, in this order.
pub const INPUTS: [Input; 6] = [
    input("sine_1hz", "sine 1 Hz", Kind::Sine, 1.0, 2),
    input("sine_10hz", "sine 10 Hz", Kind::Sine, 10.0, 4),
    input("sine_50hz", "sine 50 Hz", Kind::Sine, 50.0, 10),
    input("sine_100hz", "sine 100 Hz", Kind::Sine, 100.0, 20),
    input("triangle_50hz", "triangle 50 Hz", Kind::Triangle, 50.0, 10),
    input(
        "two_amplitude_50hz",
        "two amplitudes 50 Hz",
        Kind::TwoAmplitude,
        50.0,
        12,
    ),
];

const fn input(
    key: &'static str,
    name: &'static str,
    kind: Kind,
    frequency_hz: f64,
    periods: u32,
) -> Input {
    Input {
        key,
        name,
        kind,
        frequency_hz,
        periods,
    }
}

/// Error of the displacement against the reference in um, after the first periods.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Largest.
    pub max_um: f64,
    /// Root of the mean square.
    pub rms_um: f64,
}

impl Errors {
    /// Of a displacement against a reference, both in um.
    ///
    /// # Errors
    /// Signals of unequal lengths, or of none.
    pub fn of(displacement_um: &[f64], reference_um: &[f64]) -> Result<Self, MetricError> {
        Ok(Self {
            max_um: max_abs_error(displacement_um, reference_um)?,
            rms_um: rms_error(displacement_um, reference_um)?,
        })
    }
}

/// One reference, followed both ways.
#[derive(Clone, Debug)]
pub struct Followed {
    /// The reference.
    pub input: Input,
    /// Its samples in um, those that count.
    pub reference_um: Vec<f64>,
    /// Displacement in um when the drive is the reference over the model's steepest slope.
    pub without_um: Vec<f64>,
    /// Displacement in um through the compensator.
    pub with_um: Vec<f64>,
    /// Error without compensation.
    pub without: Errors,
    /// Error with it.
    pub with: Errors,
    /// Samples in which range or slew of the settings held a drive back.
    pub limited: u32,
}

/// What the run yields.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Where firmware and host first differed; `None` when they agreed bit for bit.
    pub first_difference: Option<String>,
    /// Samples that were compared.
    pub samples: u64,
    /// Instructions of each sample with compensation, ascending.
    pub instructions: Vec<u32>,
    /// The references.
    pub followed: Vec<Followed>,
    /// Flash and static RAM of the firmware that ran.
    pub sizes: Sizes,
    /// Bytes of stack that it ever used.
    pub stack_bytes: u32,
    /// Time between samples in s.
    pub sample_time_s: f64,
}

/// Runs everything on the firmware of this ELF; `step` is told what is done now.
///
/// # Errors
/// No emulator, and what to install; a firmware that fails or does not answer as it should.
pub fn run(firmware: &Path, step: &dyn Fn(&str)) -> Result<Outcome, Error> {
    let sizes = sizes(firmware)?;
    let pair = Pair::new(Emulator::start(firmware)?, Replica::power_on()?);
    let hardware = Hardware::paper_j()?;
    let mut bench = Bench::new(pair, hardware, &Stage::p753())?;
    let file = builtin("p753").ok_or_else(|| Error::request("there is no built-in p753"))?;
    {
        let (mut client, _) = Client::connect(&mut bench)?;
        // The first sample after power-on.
        client.wait(std::time::Duration::from_millis(1))?;
        client.tell(Command::SetSettings(hardware.settings))?;
    }
    let mut instructions = Vec::new();
    let mut followed = Vec::new();
    for input in INPUTS {
        step(input.name);
        followed.push(follow(&mut bench, &file, input, &mut instructions)?);
    }
    instructions.sort_unstable();
    let sample_time_s = bench.sample_time_s();
    let pair = bench.into_target();
    let samples = pair.samples();
    let first_difference = pair.first_difference().map(str::to_owned);
    let stack_bytes = pair.into_emulator().stack_bytes()?;
    Ok(Outcome {
        first_difference,
        samples,
        instructions,
        followed,
        sizes,
        stack_bytes,
        sample_time_s,
    })
}

fn follow(
    bench: &mut Bench<Pair>,
    file: &ModelFile,
    input: Input,
    instructions: &mut Vec<u32>,
) -> Result<Followed, Error> {
    let sample_time_s = bench.sample_time_s();
    let reference = input.reference(sample_time_s)?;
    let samples = reference.samples.len() as u32;
    // Where all plays slide, the model's slope is the sum of its weights.
    let slope: f64 = file
        .hysteresis()
        .map_or(1.0, |hysteresis| hysteresis.weights.iter().sum());
    let mut limited = 0;
    let mut once = |path, scale: f64| -> Result<Vec<f64>, Error> {
        bench.take_instructions();
        let (mut client, _) = Client::connect(bench)?;
        // From rest, with plays at zero.
        client.stop()?;
        while client.statistics()?.driver_enabled {
            client.wait(std::time::Duration::from_millis(20))?;
        }
        let record = model::record(file, &client.settings()?, Choice::Explicit)?.record;
        client.tell(Command::SetModel(Some(record)))?;
        let excitation = Excitation {
            path,
            shape: input.shape(&reference, scale),
            samples,
        };
        let played = play(&mut client, &excitation, true, &mut |_| {})?;
        limited += played.limited;
        Ok(played.signals.displacement_um)
    };
    let without_um = once(control::Path::Direct, 1.0 / slope)?;
    let with_um = once(control::Path::Compensated, 1.0)?;
    instructions.extend(bench.take_instructions());

    let counted = |signal: &[f64]| signal[input.skipped(sample_time_s)..].to_vec();
    let reference_um = counted(&reference.samples);
    let (without_um, with_um) = (counted(&without_um), counted(&with_um));
    let scored = |displacement: &[f64]| {
        Errors::of(displacement, &reference_um)
            .map_err(|error| Error::request(format!("{}: {error}", input.name)))
    };
    Ok(Followed {
        input,
        without: scored(&without_um)?,
        with: scored(&with_um)?,
        reference_um,
        without_um,
        with_um,
        limited,
    })
}

impl Input {
    /// Its samples in um.
    fn reference(&self, sample_time_s: f64) -> Result<Reference, Error> {
        let periods = f64::from(self.periods);
        Grid::for_cycles(sample_time_s, self.frequency_hz, periods)
            .and_then(|grid| match self.kind {
                Kind::Sine => references::sine(&grid, AMPLITUDE_UM, self.frequency_hz, 0.0),
                Kind::Triangle => references::triangle(&grid, AMPLITUDE_UM, self.frequency_hz, 0.0),
                Kind::TwoAmplitude => references::major_minor(
                    &grid,
                    AMPLITUDE_UM,
                    AMPLITUDE_UM / 2.0,
                    self.frequency_hz,
                ),
            })
            .map_err(|refused| Error::request(format!("{}: {refused}", self.name)))
    }

    /// As the target plays it, scaled.
    fn shape(&self, reference: &Reference, scale: f64) -> Shape {
        let amplitude = AMPLITUDE_UM * scale;
        match self.kind {
            Kind::Sine => Shape::sine(0.0, amplitude, self.frequency_hz),
            Kind::Triangle => Shape::triangle(0.0, amplitude, self.frequency_hz),
            Kind::TwoAmplitude => Shape::Sent(
                reference
                    .samples
                    .iter()
                    .map(|um| (um * scale) as f32)
                    .collect(),
            ),
        }
    }

    /// Samples at the beginning that are not counted.
    fn skipped(&self, sample_time_s: f64) -> usize {
        let periods = match self.kind {
            Kind::Sine | Kind::Triangle => 1.0,
            Kind::TwoAmplitude => 2.0,
        };
        (periods / self.frequency_hz / sample_time_s).round() as usize
    }
}

impl Outcome {
    /// Whether firmware and host agreed in every sample and every link byte.
    pub fn bit_exact(&self) -> bool {
        self.first_difference.is_none()
    }

    /// Least, median and most instructions of a sample with compensation.
    pub fn instruction_range(&self) -> (u32, u32, u32) {
        let at = |index: usize| self.instructions.get(index).copied().unwrap_or_default();
        let len = self.instructions.len();
        (at(0), at(len / 2), at(len.saturating_sub(1)))
    }

    /// Bytes of RAM: variables, and the stack at its deepest.
    pub fn ram_bytes(&self) -> u64 {
        self.sizes.ram_bytes + u64::from(self.stack_bytes)
    }

    /// Whether compensation lowered the error on every reference.
    pub fn improved(&self) -> bool {
        self.followed
            .iter()
            .all(|followed| followed.with.max_um < followed.without.max_um)
    }

    /// The content of `pil.json`; errors are the largest.
    pub fn to_json(&self) -> Value {
        let (min, median, max) = self.instruction_range();
        let errors: serde_json::Map<String, Value> = self
            .followed
            .iter()
            .map(|followed| {
                let value = json!({
                    "without": followed.without.max_um,
                    "with": followed.with.max_um,
                });
                (followed.input.key.to_owned(), value)
            })
            .collect();
        json!({
            "bit_exact": self.bit_exact(),
            "samples": self.samples,
            "instructions_per_tick": { "min": min, "median": median, "max": max },
            "error_um": errors,
            "flash_bytes": self.sizes.flash_bytes,
            "ram_bytes": self.ram_bytes(),
        })
    }
}
