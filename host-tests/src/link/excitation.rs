//! What a target is asked to play.

use hysteron::control::Path;
use hysteron::reference::{Tone, Waveform};
use hysteron::settings::Settings;

use crate::error::Error;
use crate::experiment::references::{self, Grid};

/// A reference and what it means.
#[derive(Clone, Debug, PartialEq)]
pub struct Excitation {
    /// Displacement in um through the compensator, or drive in V.
    pub path: Path,
    /// Its samples.
    pub shape: Shape,
    /// How many of them.
    pub samples: u32,
}

/// How the samples come about.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Computed by the target.
    Built(Waveform),
    /// Sent by the host, as many as are to be played.
    Sent(Vec<f32>),
}

impl Shape {
    /// `offset + amplitude sin(2 pi frequency_hz t)`.
    pub fn sine(offset: f64, amplitude: f64, frequency_hz: f64) -> Self {
        Self::two_tone(offset, (amplitude, frequency_hz), (0.0, 0.0))
    }

    /// The sum of two sines, each an amplitude and a frequency in Hz: major and minor loops.
    pub fn two_tone(offset: f64, first: (f64, f64), second: (f64, f64)) -> Self {
        Self::Built(Waveform::Tones {
            offset: offset as f32,
            tones: [tone(first), tone(second)],
        })
    }

    /// A triangle that starts like a sine.
    pub fn triangle(offset: f64, amplitude: f64, frequency_hz: f64) -> Self {
        Self::Built(Waveform::Triangle {
            offset: offset as f32,
            tone: tone((amplitude, frequency_hz)),
        })
    }

    /// Lowest and highest value that it can take.
    fn range(&self) -> (f32, f32) {
        let around = |offset: f32, peak: f32| (offset - peak, offset + peak);
        match self {
            Self::Built(Waveform::Tones { offset, tones }) => around(
                *offset,
                tones.iter().map(|tone| tone.amplitude.abs()).sum::<f32>(),
            ),
            Self::Built(Waveform::Triangle { offset, tone }) => {
                around(*offset, tone.amplitude.abs())
            }
            Self::Built(Waveform::Stream) => (0.0, 0.0),
            Self::Sent(samples) => samples.iter().fold(
                (f32::INFINITY, f32::NEG_INFINITY),
                |(low, high), &sample| (low.min(sample), high.max(sample)),
            ),
        }
    }
}

impl Excitation {
    /// Refuses what the target would cut off or could not play: no samples, samples that are not
    /// finite, a drive beyond the range of the settings.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self, settings: &Settings) -> Result<(), Error> {
        if self.samples == 0 {
            return Err(Error::request(
                "the reference has no samples; make it longer than a sample time",
            ));
        }
        if let Shape::Sent(samples) = &self.shape
            && let Some(at) = samples.iter().position(|sample| !sample.is_finite())
        {
            return Err(Error::request(format!(
                "sample {at} of the reference is beyond single precision; correct it"
            )));
        }
        let (low, high) = self.shape.range();
        let within = low >= settings.drive_min_v && high <= settings.drive_max_v;
        if self.path == Path::Direct && !within {
            return Err(Error::request(format!(
                "the drive would go from {low} V to {high} V and the settings allow {} V to {} V; \
                 choose another amplitude or offset, or change the settings",
                settings.drive_min_v, settings.drive_max_v
            )));
        }
        Ok(())
    }
}

/// Equal lines at 1 to `lines` times `fundamental_hz` with phases from `seed`, of this peak, around
/// `offset`; `samples` of them at `sample_rate_hz`.
///
/// # Errors
/// A frequency or a length that makes no signal.
pub fn multisine(
    offset: f64,
    peak: f64,
    (fundamental_hz, lines): (f64, u32),
    seed: u64,
    (sample_rate_hz, samples): (f64, u32),
) -> Result<Shape, Error> {
    let sample_time_s = 1.0 / sample_rate_hz;
    let signal = Grid::for_duration(sample_time_s, f64::from(samples) * sample_time_s)
        .and_then(|grid| references::multisine(&grid, peak, fundamental_hz, 1..=lines, seed))
        .map_err(|refused| Error::request(format!("multisine: {refused}")))?;
    Ok(Shape::Sent(
        signal.samples.iter().map(|x| (x + offset) as f32).collect(),
    ))
}

fn tone((amplitude, frequency_hz): (f64, f64)) -> Tone {
    Tone {
        amplitude: amplitude as f32,
        frequency_hz: frequency_hz as f32,
    }
}
