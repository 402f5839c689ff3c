//! References: what the output is to follow, sample by sample.
//!
//! An oscillator is a 32-bit phase that wraps once a period, so its frequency is exact to
//! 2^-32 of the sample rate and nothing drifts. The sine is a polynomial of degree 9 on the folded
//! quarter period, exact to 1.2e-7 of the amplitude: no library call, no table, no division, the same
//! bits on host and target.

use core::f32::consts::PI;

use heapless::spsc::Consumer;
use serde::{Deserialize, Serialize};

/// Streamed samples that fit between host and interrupt, one less than this: 0.1 s at 10 kHz.
pub const STREAM_LEN: usize = 1024;

/// The interrupt's end of a stream of reference samples.
pub type Stream<'a> = Consumer<'a, f32, STREAM_LEN>;

/// A periodic component as it is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tone {
    /// Amplitude in the unit of the reference.
    pub amplitude: f32,
    /// Frequency in Hz, from zero to a quarter of the sample rate.
    pub frequency_hz: f32,
}

/// A reference as it is asked for; its unit is um with compensation and V of drive without.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Waveform {
    /// `offset + sum amplitude_i sin(2 pi f_i t)`: a sine, or with two tones major and minor loops.
    Tones {
        /// Mean.
        offset: f32,
        /// The two components; an amplitude of zero leaves one out.
        tones: [Tone; 2],
    },
    /// `offset` plus a triangle that starts like a sine.
    Triangle {
        /// Mean.
        offset: f32,
        /// Peak value and frequency.
        tone: Tone,
    },
    /// Samples streamed by the host.
    Stream,
}

/// What is wrong with a [`Waveform`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum WaveformError {
    /// An amplitude or offset is infinite or NaN.
    NotFinite,
    /// A frequency is not from zero to a quarter of the sample rate.
    Frequency,
}

/// A running oscillator.
#[derive(Clone, Copy, Debug)]
pub struct Oscillator {
    phase: u32,
    step: u32,
    amplitude: f32,
}

/// A running reference.
#[derive(Clone, Copy, Debug)]
pub enum Reference {
    /// One sine.
    Tone(f32, Oscillator),
    /// Sum of sines.
    Tones(f32, [Oscillator; 2]),
    /// Triangle.
    Triangle(f32, Oscillator),
    /// Samples from the stream.
    Stream,
}

impl Oscillator {
    /// An oscillator at phase zero, for samples at `sample_rate` Hz.
    ///
    /// # Errors
    /// See [`WaveformError`].
    pub fn new(tone: Tone, sample_rate: f32) -> Result<Self, WaveformError> {
        let Tone {
            amplitude,
            frequency_hz,
        } = tone;
        if !amplitude.is_finite() {
            return Err(WaveformError::NotFinite);
        }
        if !(0.0..=sample_rate * 0.25).contains(&frequency_hz) {
            return Err(WaveformError::Frequency);
        }
        // In double precision and outside the interrupt; a quarter of the rate is below 2^31.
        let step = f64::from(frequency_hz) / f64::from(sample_rate) * 4_294_967_296.0;
        Ok(Self {
            phase: 0,
            step: (step + 0.5) as u32,
            amplitude,
        })
    }

    /// Phase of this sample folded to a quarter period on each side of zero, in turns of 2^32.
    #[inline(always)]
    fn folded(&mut self) -> f32 {
        let phase = self.phase as i32;
        self.phase = self.phase.wrapping_add(self.step);
        // Beyond a quarter period the two topmost bits differ; there sin(pi - x) = sin(x) leads back:
        // half a turn less the phase.
        let folded = if phase ^ (phase << 1) < 0 {
            i32::MIN.wrapping_sub(phase)
        } else {
            phase
        };
        folded as f32
    }

    #[inline(always)]
    fn sine(&mut self) -> f32 {
        const RADIANS: f32 = PI / 2_147_483_648.0;
        // Minimax on the quarter period: off by at most 1.7e-8, a seventh of what rounding adds.
        const C3: f32 = -0.166_666_57;
        const C5: f32 = 0.008_333_017;
        const C7: f32 = -0.000_198_066_15;
        const C9: f32 = 0.000_002_600_054_8;
        let x = self.folded() * RADIANS;
        let square = x * x;
        let tail = C3 + square * (C5 + square * (C7 + square * C9));
        self.amplitude * (x + x * square * tail)
    }

    #[inline(always)]
    fn triangle(&mut self) -> f32 {
        const PER_QUARTER: f32 = 1.0 / 1_073_741_824.0;
        self.amplitude * (self.folded() * PER_QUARTER)
    }
}

impl Reference {
    /// The reference at its first sample, for samples at `sample_rate` Hz.
    ///
    /// # Errors
    /// See [`WaveformError`].
    pub fn new(waveform: &Waveform, sample_rate: f32) -> Result<Self, WaveformError> {
        let finite = |value: f32| {
            if value.is_finite() {
                Ok(value)
            } else {
                Err(WaveformError::NotFinite)
            }
        };
        Ok(match *waveform {
            Waveform::Tones {
                offset,
                tones: [first, second],
            } => {
                let offset = finite(offset)?;
                let first = Oscillator::new(first, sample_rate)?;
                let second = Oscillator::new(second, sample_rate)?;
                if second.amplitude == 0.0 {
                    Self::Tone(offset, first)
                } else {
                    Self::Tones(offset, [first, second])
                }
            }
            Waveform::Triangle { offset, tone } => {
                Self::Triangle(finite(offset)?, Oscillator::new(tone, sample_rate)?)
            }
            Waveform::Stream => Self::Stream,
        })
    }

    /// The next sample; `None` when the stream has run dry.
    #[inline(always)]
    pub fn next(&mut self, stream: &mut Stream<'_>) -> Option<f32> {
        match self {
            Self::Tone(offset, oscillator) => Some(*offset + oscillator.sine()),
            Self::Tones(offset, [first, second]) => {
                let sum = first.sine() + second.sine();
                Some(*offset + sum)
            }
            Self::Triangle(offset, oscillator) => Some(*offset + oscillator.triangle()),
            Self::Stream => stream.dequeue(),
        }
    }
}
