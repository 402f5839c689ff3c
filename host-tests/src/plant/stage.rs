//! A stage as configured, and a stage that runs.

use rand_pcg::Pcg64;

use super::amplifier::{Amplifier, Reconstruction};
use super::dac::Dac;
use super::error::{StageError, require, require_drive};
use super::hysteresis::Hysteresis;
use super::memory::MemoryCurve;
use super::sensor::Sensor;

/// Configuration of a simulated stage; see the [module](super) for the signal chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Converter; `None` passes commands on unchanged.
    pub dac: Option<Dac>,
    /// How the drive goes from sample to sample.
    pub reconstruction: Reconstruction,
    /// Time constant of the amplifier's first-order lag, s; 0 for none.
    pub amplifier_tau_s: f64,
    /// The actuator.
    pub hysteresis: Hysteresis,
    /// The displacement sensor.
    pub sensor: Sensor,
    /// Fine steps in a sample time, 1 to 10 000.
    pub oversample: u32,
}

impl Stage {
    /// Fine steps in a sample time unless chosen otherwise.
    pub const OVERSAMPLE: u32 = 20;

    /// An actuator with a perfect converter, amplifier and sensor.
    pub fn ideal(hysteresis: Hysteresis) -> Self {
        Self {
            dac: None,
            reconstruction: Reconstruction::Ramp,
            amplifier_tau_s: 0.0,
            hysteresis,
            sensor: Sensor::default(),
            oversample: Self::OVERSAMPLE,
        }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// [`StageError::Parameter`] naming the first field that is out of range; a staircase drive
    /// with a rate term but no lag is an error of `amplifier_tau_s`.
    pub fn validate(&self) -> Result<(), StageError> {
        if let Some(dac) = &self.dac {
            dac.validate()?;
        }
        self.hysteresis.validate()?;
        self.sensor.validate()?;
        require(
            (0.0..=1e3).contains(&self.amplifier_tau_s),
            "amplifier_tau_s",
            self.amplifier_tau_s,
            "must be 0 to 1000 s",
        )?;
        require(
            self.reconstruction == Reconstruction::Ramp
                || self.hysteresis.rate_widening_s == 0.0
                || self.amplifier_tau_s > 0.0,
            "amplifier_tau_s",
            self.amplifier_tau_s,
            "must be above 0 where a held drive meets a rate term",
        )?;
        require(
            (1..=10_000).contains(&self.oversample),
            "oversample",
            f64::from(self.oversample),
            "must be 1 to 10000",
        )
    }

    /// Starts the stage at rest: from the virgin state it was brought to `rest_v` and left there.
    ///
    /// `sample_time_s` is the time between commands, 1e-9 to 1000 s.
    ///
    /// # Errors
    /// What [`validate`](Self::validate) finds, [`StageError::Parameter`] for the sample time,
    /// [`StageError::Drive`] for the resting voltage.
    pub fn start(&self, sample_time_s: f64, rest_v: f64) -> Result<Simulation, StageError> {
        self.validate()?;
        require(
            (1e-9..=1e3).contains(&sample_time_s),
            "sample_time_s",
            sample_time_s,
            "must be 1e-9 to 1000 s",
        )?;
        require_drive(0, rest_v)?;
        let rest_v = self.dac.map_or(rest_v, |dac| dac.quantise(rest_v));
        let fine_step_s = sample_time_s / f64::from(self.oversample);
        Ok(Simulation {
            fine_step_s,
            held_v: rest_v,
            amplifier: Amplifier::new(self.amplifier_tau_s, fine_step_s, rest_v),
            memory: self.hysteresis.at_rest(rest_v),
            noise: self.sensor.generator(),
            samples: 0,
            stage: self.clone(),
        })
    }

    /// Displacement samples in um, one for each command in `drive_v`; the stage starts at rest at
    /// the first command.
    ///
    /// # Errors
    /// As [`start`](Self::start) and [`Simulation::step`].
    pub fn run(&self, drive_v: &[f64], sample_time_s: f64) -> Result<Vec<f64>, StageError> {
        let mut simulation =
            self.start(sample_time_s, drive_v.first().copied().unwrap_or_default())?;
        drive_v
            .iter()
            .map(|&command| simulation.step(command))
            .collect()
    }
}

/// A running stage.
#[derive(Debug, Clone)]
pub struct Simulation {
    stage: Stage,
    fine_step_s: f64,
    /// Converter output during the last sample time, V.
    held_v: f64,
    amplifier: Amplifier,
    memory: MemoryCurve,
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
        let target_v = self
            .stage
            .dac
            .map_or(command_v, |dac| dac.quantise(command_v));
        let start_v = match self.stage.reconstruction {
            Reconstruction::Hold => target_v,
            Reconstruction::Ramp => self.held_v,
        };
        self.held_v = target_v;

        let steps = self.stage.oversample;
        let input_v = |step: u32| {
            target_v - (target_v - start_v) * (f64::from(steps - step) / f64::from(steps))
        };
        for step in 1..=steps {
            let before_v = self.amplifier.output_v();
            let drive_v = self.amplifier.advance(input_v(step - 1), input_v(step));
            let rate = (drive_v - before_v) / self.fine_step_s;
            self.stage
                .hysteresis
                .advance(&mut self.memory, drive_v, rate);
        }
        let displacement_um = self
            .stage
            .hysteresis
            .displacement_um(&self.memory, self.amplifier.output_v());
        Ok(self.stage.sensor.sample(&mut self.noise, displacement_um))
    }

    /// Drive at the actuator now, V.
    pub fn drive_v(&self) -> f64 {
        self.amplifier.output_v()
    }
}
