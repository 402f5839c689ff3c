//! The stages that are driven: simulated, and of another make than any of the compensators' models.

use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use serde::Serialize;

use crate::plant::bimorph::{self, Asymmetry, Bimorph, Mode, RelayDensity};
use crate::plant::{self, Dac, Sensor, StageError};

/// Relative error of every parameter of a wrong plant.
pub const WRONG: f64 = 0.1;

/// A simulated plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Plant {
    /// Paper J's stage: a density of plays that widens with the rate of its own drive at every
    /// instant, where the models have a few plays and a rate a sample.
    Plays,
    /// A stack of Preisach relays in front of a mode of 400 Hz: what widens its loops is lag, not a
    /// threshold.
    Relays,
    /// Paper M's bimorph: relays, a mode of 74 Hz, a bend.
    Bimorph,
}

/// All of them.
pub const PLANTS: [Plant; 3] = [Plant::Plays, Plant::Relays, Plant::Bimorph];

impl Plant {
    /// Its name in a heading.
    pub fn title(self) -> &'static str {
        match self {
            Self::Plays => "Stage of plays",
            Self::Relays => "Stack of relays",
            Self::Bimorph => "Bimorph",
        }
    }

    /// What it is.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Plays => {
                "paper J's stage: a density of play thresholds that widens with the rate of its own \
                 drive, stepped 20 times finer, amplifier lag of 0.04 ms, 16 bits, 10 nm of noise and \
                 1.5 nm of rounding; 10 kHz"
            }
            Self::Relays => {
                "a stack of Preisach relays whose density depends on where they lie, amplifier lag of \
                 0.04 ms, a mode of 400 Hz with damping 0.15, a bend of 2 % behind 0.2 ms, 16 bits held, \
                 stepped 10 times finer, 10 nm of noise and 1.5 nm of rounding; 10 kHz"
            }
            Self::Bimorph => {
                "paper M's bimorph: Preisach relays, amplifier lag of 0.53 ms, a mode of 74.2 Hz with \
                 damping 0.018, a bend of 14 % behind 1 ms, 16 bits over ±5 V held, stepped 10 times \
                 finer, 20 nm of noise; 5 kHz"
            }
        }
    }

    /// Time between samples in s, that of the paper whose range it is driven over.
    pub fn sample_time_s(self) -> f64 {
        match self {
            Self::Plays | Self::Relays => 1e-4,
            Self::Bimorph => Bimorph::SAMPLE_TIME_S,
        }
    }

    /// Amplitude of the references in um, likewise.
    pub fn amplitude_um(self) -> f64 {
        match self {
            Self::Plays | Self::Relays => 40.0,
            Self::Bimorph => 50.0,
        }
    }

    /// Largest drive that it is identified with, V.
    pub fn full_drive_v(self) -> f64 {
        match self {
            Self::Plays | Self::Relays => 50.0,
            Self::Bimorph => Bimorph::FULL_DRIVE_V,
        }
    }

    /// The plant itself; `noise` chooses the sensor's noise.
    pub fn device(self, noise: u64) -> Device {
        match self {
            Self::Plays => {
                let mut stage = plant::Stage::p753();
                stage.sensor.seed = noise;
                Device::Stage(stage)
            }
            Self::Relays => {
                let mut stack = stack();
                stack.sensor.seed = noise;
                Device::Bimorph(stack)
            }
            Self::Bimorph => {
                let mut bimorph = Bimorph::pzba();
                bimorph.sensor.seed = noise;
                Device::Bimorph(bimorph)
            }
        }
    }

    /// The plant with every parameter [`WRONG`] up or down as drawn from `seed`.
    pub fn wrong(self, seed: u64) -> Device {
        match self.device(seed) {
            Device::Stage(_) => Device::Stage(plant::Stage::p753_perturbed(WRONG, seed)),
            Device::Bimorph(nominal) => Device::Bimorph(perturbed(nominal, seed)),
        }
    }
}

/// A stack in the range of paper J's stage: 1 um/V, 40 V, loops of about 13 % at 1 Hz.
fn stack() -> Bimorph {
    Bimorph {
        dac: Dac {
            bits: 16,
            min_v: -100.0,
            max_v: 100.0,
        },
        amplifier_tau_s: 3.9e-5,
        gain_um_per_v: 0.74,
        relays: RelayDensity {
            tilt_per_v: 0.0,
            density_um_per_v2: 0.0033,
            widening_per_v: 0.004,
            reach_v: 120.0,
        },
        mode: Mode {
            frequency_hz: 400.0,
            damping: 0.15,
        },
        asymmetry: Asymmetry {
            share: 0.02,
            knee_um: 15.0,
            relaxation_s: 2e-4,
        },
        sensor: Sensor {
            noise_um: 0.01,
            step_um: 100.0 / 65_536.0,
            seed: 0,
        },
        oversample: 10,
    }
}

fn perturbed(mut plant: Bimorph, seed: u64) -> Bimorph {
    let mut generator = Pcg64::seed_from_u64(seed);
    let values = [
        &mut plant.amplifier_tau_s,
        &mut plant.gain_um_per_v,
        &mut plant.relays.density_um_per_v2,
        &mut plant.relays.widening_per_v,
        &mut plant.relays.reach_v,
        &mut plant.mode.frequency_hz,
        &mut plant.mode.damping,
        &mut plant.asymmetry.share,
        &mut plant.asymmetry.knee_um,
        &mut plant.asymmetry.relaxation_s,
    ];
    for value in values {
        let up: bool = StandardUniform.sample(&mut generator);
        *value *= if up { 1.0 + WRONG } else { 1.0 - WRONG };
    }
    plant
}

/// A plant as configured.
#[derive(Clone, Debug)]
pub enum Device {
    /// A stage of plays.
    Stage(plant::Stage),
    /// Relays, a mode and a bend.
    Bimorph(Bimorph),
}

/// A plant that runs.
#[derive(Clone, Debug)]
pub enum Running {
    /// A stage of plays.
    Stage(Box<plant::Simulation>),
    /// Relays, a mode and a bend.
    Bimorph(Box<bimorph::Simulation>),
}

impl Device {
    /// The plant at rest at 0 V.
    ///
    /// # Errors
    /// Parameters that the plant refuses.
    pub fn start(&self, sample_time_s: f64) -> Result<Running, StageError> {
        Ok(match self {
            Self::Stage(stage) => Running::Stage(Box::new(stage.start(sample_time_s, 0.0)?)),
            Self::Bimorph(plant) => Running::Bimorph(Box::new(plant.start(sample_time_s)?)),
        })
    }

    /// Displacement in um along a drive in V, from rest at 0 V.
    ///
    /// # Errors
    /// A drive that is not finite or absurdly large.
    pub fn run(&self, drive_v: &[f64], sample_time_s: f64) -> Result<Vec<f64>, StageError> {
        let mut running = self.start(sample_time_s)?;
        drive_v.iter().map(|&u| running.step(u)).collect()
    }
}

impl Running {
    /// The sensor sample in um at the end of a sample time with this command in V.
    ///
    /// # Errors
    /// A command that is not finite or absurdly large.
    pub fn step(&mut self, command_v: f64) -> Result<f64, StageError> {
        match self {
            Self::Stage(stage) => stage.step(command_v),
            Self::Bimorph(plant) => plant.step(command_v),
        }
    }
}
