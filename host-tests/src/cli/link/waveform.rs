//! References and excitations on the command line.

use clap::{Args, ValueEnum};

use hysteron::reference::Waveform;
use hysteron_host::error::Error;
use hysteron_host::link::{Shape, multisine};

/// A reference that the target computes itself; V of drive, or um through the compensator.
#[derive(Clone, Debug, Args)]
pub struct Tones {
    /// Peak value.
    #[arg(
        long,
        value_name = "A",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub amplitude: f64,
    /// Frequency in Hz; of a multisine its lowest line, the distance of all of them.
    #[arg(long, value_name = "HZ", default_value_t = 1.0)]
    pub frequency: f64,
    /// What it moves around.
    #[arg(
        long,
        value_name = "X",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub offset: f64,
    /// Peak value of the second tone.
    #[arg(
        long,
        value_name = "A",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub second_amplitude: f64,
    /// Frequency of the second tone in Hz.
    #[arg(long, value_name = "HZ", default_value_t = 0.0)]
    pub second_frequency: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Built {
    /// A sine.
    #[default]
    Sine,
    /// A triangle that starts like a sine.
    Triangle,
    /// The sum of two sines: major and minor loops.
    TwoTone,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Excitation {
    /// A sine.
    Sine,
    /// A triangle that starts like a sine.
    Triangle,
    /// The sum of two sines: major and minor loops.
    TwoTone,
    /// Equal lines with random phases, streamed.
    Multi,
    /// No motion: drift, hum and noise.
    Rest,
    /// The column drive_v of a CSV, streamed.
    File,
}

impl Tones {
    /// The shape of a reference that the target computes.
    pub fn built(&self, kind: Built) -> Shape {
        match kind {
            Built::Sine => Shape::sine(self.offset, self.amplitude, self.frequency),
            Built::Triangle => Shape::triangle(self.offset, self.amplitude, self.frequency),
            Built::TwoTone => Shape::two_tone(
                self.offset,
                (self.amplitude, self.frequency),
                (self.second_amplitude, self.second_frequency),
            ),
        }
    }

    /// The same as the target takes it.
    pub fn waveform(&self, kind: Built) -> Waveform {
        match self.built(kind) {
            Shape::Built(waveform) => waveform,
            Shape::Sent(_) => Waveform::Stream,
        }
    }

    /// A multisine of `lines` lines, `samples` long.
    pub fn multi(
        &self,
        lines: u32,
        seed: u64,
        sample_rate_hz: f64,
        samples: u32,
    ) -> Result<Shape, Error> {
        multisine(
            self.offset,
            self.amplitude,
            (self.frequency, lines),
            seed,
            (sample_rate_hz, samples),
        )
    }
}
