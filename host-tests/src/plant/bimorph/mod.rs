//! A simulated bimorph: the independent truth for paper M (Morita, Fujii and Hosoda, Actuators 2020).
//!
//! ```text
//! command -> DAC -> hold -> amplifier -> relays -> mode -> bend -> sensor
//!   V         V      V(t)      u(t), V    um        um     um      um
//! ```
//!
//! The hysteresis is Preisach's plane of relays ([`RelayDensity`]), neither a sum of plays nor the
//! differential equation of Bouc and Wen, so that neither of the models that are compared on it is
//! its own plant. Behind it one bending [`Mode`] and a mild even nonlinearity ([`Asymmetry`]). The
//! command of a sample time is held through it and the sensor is read at its end; inside, everything
//! runs `oversample` times finer, the linear parts exactly for an input that is linear over a fine
//! step.
//!
//! ```
//! use hysteron_host::plant::bimorph::Bimorph;
//!
//! let drive_v: Vec<f64> = (0..500).map(|k| 5.0 * (0.0314 * f64::from(k)).sin()).collect();
//! let displacement_um = Bimorph::pzba().run(&drive_v, Bimorph::SAMPLE_TIME_S)?;
//! assert_eq!(displacement_um.len(), drive_v.len());
//! # Ok::<(), hysteron_host::plant::StageError>(())
//! ```

mod mode;
mod relays;

use rand_pcg::Pcg64;

use super::amplifier::Amplifier;
use super::dac::Dac;
use super::error::{StageError, require, require_drive};
use super::sensor::Sensor;
use mode::Bend;
pub(in crate::plant) use mode::Vibration;

pub use mode::{Asymmetry, Mode};
pub use relays::{RelayDensity, Relays};

/// Configuration of a simulated bimorph; see the [module](self) for the signal chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Bimorph {
    /// Converter; it also limits the drive.
    pub dac: Dac,
    /// Time constant of the amplifier's first-order lag, s; 0 for none.
    pub amplifier_tau_s: f64,
    /// Displacement without hysteresis, um/V.
    pub gain_um_per_v: f64,
    /// The hysteresis, added to that.
    pub relays: RelayDensity,
    /// The resonance that both drive.
    pub mode: Mode,
    /// The even nonlinearity of the bend.
    pub asymmetry: Asymmetry,
    /// The displacement sensor.
    pub sensor: Sensor,
    /// Fine steps in a sample time, 1 to 10 000.
    pub oversample: u32,
}

impl Bimorph {
    /// Sample time of the published experiments, s.
    pub const SAMPLE_TIME_S: f64 = 2e-4;
    /// Largest drive of the published experiments, V: 1 in the symbols of the paper.
    pub const FULL_DRIVE_V: f64 = 5.0;

    /// A bimorph like the PZBA-00030 of the paper, in what is published of it: resonance, harmonics
    /// at 15, 25 and 35 Hz, a loop that crosses itself at 80 Hz and an asymmetric clockwise loop at
    /// 95 Hz, all at full drive; 20 nm of sensor noise, +-5 V.
    ///
    /// Nothing else of it is published in numbers. Displacement (0.08 mm at full drive, at rest), the
    /// 16 bits of the converter and the form of the even part are assumed. The amplifier's lag is
    /// what makes the fundamental lag by 180 degrees at 80 Hz.
    pub fn pzba() -> Self {
        Self {
            dac: Dac {
                bits: 16,
                min_v: -Self::FULL_DRIVE_V,
                max_v: Self::FULL_DRIVE_V,
            },
            amplifier_tau_s: 5.3e-4,
            gain_um_per_v: 14.08,
            relays: RelayDensity {
                density_um_per_v2: 0.0869,
                widening_per_v: 0.08,
                tilt_per_v: 0.0,
                reach_v: 12.5,
            },
            mode: Mode {
                frequency_hz: 74.2,
                damping: 0.018,
            },
            asymmetry: Asymmetry {
                share: 0.14,
                knee_um: 24.0,
                relaxation_s: 1e-3,
            },
            sensor: Sensor {
                noise_um: 0.02,
                step_um: 0.0,
                seed: 30,
            },
            oversample: 10,
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`StageError::Parameter`] naming the first field that is out of range.
    pub fn validate(&self) -> Result<(), StageError> {
        self.dac.validate()?;
        require(
            (0.0..=1e3).contains(&self.amplifier_tau_s),
            "amplifier_tau_s",
            self.amplifier_tau_s,
            "must be 0 to 1000 s",
        )?;
        require(
            self.gain_um_per_v.abs() <= 1e6,
            "gain_um_per_v",
            self.gain_um_per_v,
            "must be finite and within +-1e6 um/V",
        )?;
        self.relays.validate()?;
        self.mode.validate()?;
        self.asymmetry.validate()?;
        self.sensor.validate()?;
        require(
            (1..=10_000).contains(&self.oversample),
            "oversample",
            f64::from(self.oversample),
            "must be 1 to 10000",
        )
    }

    /// Starts the bimorph in the virgin state at 0 V; `sample_time_s` is 1e-9 to 1000 s.
    ///
    /// # Errors
    /// What [`validate`](Self::validate) finds and [`StageError::Parameter`] for the sample time.
    pub fn start(&self, sample_time_s: f64) -> Result<Simulation, StageError> {
        self.validate()?;
        require(
            (1e-9..=1e3).contains(&sample_time_s),
            "sample_time_s",
            sample_time_s,
            "must be 1e-9 to 1000 s",
        )?;
        let step_s = sample_time_s / f64::from(self.oversample);
        Ok(Simulation {
            amplifier: Amplifier::new(self.amplifier_tau_s, step_s, 0.0),
            relays: Relays::new(self.relays),
            vibration: Vibration::new(self.mode, step_s),
            bend: Bend::new(self.asymmetry, step_s),
            noise: self.sensor.generator(),
            samples: 0,
            bimorph: self.clone(),
        })
    }

    /// Displacement samples in um, one for each command in `drive_v`, from the virgin state.
    ///
    /// # Errors
    /// As [`start`](Self::start) and [`Simulation::step`].
    pub fn run(&self, drive_v: &[f64], sample_time_s: f64) -> Result<Vec<f64>, StageError> {
        let mut simulation = self.start(sample_time_s)?;
        drive_v
            .iter()
            .map(|&command_v| simulation.step(command_v))
            .collect()
    }
}

/// A running bimorph.
#[derive(Debug, Clone)]
pub struct Simulation {
    bimorph: Bimorph,
    amplifier: Amplifier,
    relays: Relays,
    vibration: Vibration,
    bend: Bend,
    noise: Pcg64,
    samples: u64,
}

impl Simulation {
    /// Takes the command for one sample time, V, and returns the sensor sample at its end, um.
    ///
    /// # Errors
    /// [`StageError::Drive`] for a command that is not finite or absurdly large; the state is then
    /// unchanged.
    pub fn step(&mut self, command_v: f64) -> Result<f64, StageError> {
        require_drive(self.samples, command_v)?;
        self.samples += 1;
        let held_v = self.bimorph.dac.quantise(command_v);
        let mut displacement_um = 0.0;
        for _ in 0..self.bimorph.oversample {
            let drive_v = self.amplifier.advance(held_v, held_v);
            let actuation_um = self.bimorph.gain_um_per_v * drive_v + self.relays.advance(drive_v);
            displacement_um = self.bend.advance(self.vibration.advance(actuation_um));
        }
        Ok(self.bimorph.sensor.sample(&mut self.noise, displacement_um))
    }
}
