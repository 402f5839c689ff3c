//! A simulated stage between a target's converter and its sensor.

use std::io;
use std::time::Duration;

use hysteron::dac;
use hysteron::sensor;
use hysteron::settings::Settings;

use super::target::{Target, Ticked};
use crate::error::Error;
use crate::link::Port;
use crate::plant::Stage;

/// Samples between two looks at the link.
const BLOCK: u32 = 8;
/// State of the output while it follows a reference.
const RUN: u8 = 2;

/// A stage: takes the drive of a sample in V and gives the displacement at its end in um.
pub type Plant = Box<dyn FnMut(f64) -> Result<f64, Error>>;

/// What stands between the target's codes and the stage, described by the settings that fit it.
#[derive(Clone, Copy, Debug)]
pub struct Hardware {
    /// Settings that describe the parts.
    pub settings: Settings,
    dac: dac::Scale,
    sensor: sensor::Scale,
    sample_time_s: f64,
}

impl Hardware {
    /// The parts that `settings` describe.
    ///
    /// # Errors
    /// Settings that a target refuses.
    pub fn new(settings: Settings) -> Result<Self, Error> {
        let valid = settings
            .validate()
            .map_err(|error| Error::request(format!("the bench's settings: {error:?}")))?;
        Ok(Self {
            settings,
            dac: valid.dac,
            sensor: valid.sensor,
            sample_time_s: f64::from(valid.sample_time),
        })
    }

    /// Time between two samples in s.
    pub fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// A bipolar converter of 16 bit, an amplifier of ten for +-50 V, and a sensor that shows +-60 um
    /// on the whole range of its converter; 10 kHz.
    ///
    /// # Errors
    /// None.
    pub fn paper_j() -> Result<Self, Error> {
        Self::new(Settings {
            dac: dac::Kind::Bipolar16,
            amplifier_gain: 10.0,
            sensor_um_per_v: 120.0 / 3.3,
            sensor_offset_um: -60.0,
            drive_min_v: -50.0,
            drive_max_v: 50.0,
            slew_v_per_s: 1e6,
            ramp_v_per_s: 2_000.0,
            ..Settings::default()
        })
    }
}

/// A target with a simulated stage, in simulated time: samples pass while the link is waited for.
pub struct Bench<T> {
    target: T,
    hardware: Hardware,
    plant: Plant,
    displacement_um: f64,
    samples: u64,
    last: Option<Ticked>,
    to_host: Vec<u8>,
    counts: Vec<u32>,
}

impl<T: Target> Bench<T> {
    /// A target after power-on before a stage at rest. The parts are fixed: a target that has
    /// settings of other ones meets a bench that does not fit it. Converter and sensor of `stage`
    /// itself are left out, their place is taken by the target's own codes.
    ///
    /// # Errors
    /// A stage that is refused.
    pub fn new(target: T, hardware: Hardware, stage: &Stage) -> Result<Self, Error> {
        let mut stage = stage.clone();
        stage.dac = None;
        stage.sensor.step_um = 0.0;
        let told = |error| Error::request(format!("simulated stage: {error}"));
        let mut stage = stage.start(hardware.sample_time_s, 0.0).map_err(told)?;
        let plant = move |drive_v| stage.step(drive_v).map_err(told);
        Ok(Self::around(target, hardware, Box::new(plant)))
    }

    /// As [`Bench::new`] before any other stage, which shows 0 um until its first sample.
    pub fn around(target: T, hardware: Hardware, plant: Plant) -> Self {
        Self {
            target,
            hardware,
            plant,
            displacement_um: 0.0,
            samples: 0,
            last: None,
            to_host: Vec::new(),
            counts: Vec::new(),
        }
    }

    /// One sample. The sensor's code is read before it, and the drive arrives at its end.
    ///
    /// # Errors
    /// A target that failed.
    pub fn tick(&mut self) -> Result<Ticked, Error> {
        let code = self.hardware.sensor.code(self.displacement_um as f32);
        let ticked = self.target.tick(code, false)?;
        if ticked.state == RUN {
            self.counts.push(ticked.instructions);
        }
        let drive_v = self.drive_of(ticked);
        self.displacement_um = (self.plant)(drive_v)?;
        self.samples += 1;
        self.last = Some(ticked);
        Ok(ticked)
    }

    /// Drive at the amplifier's output in V: none while it is not enabled.
    pub fn drive_v(&self) -> f64 {
        self.last.map_or(0.0, |ticked| self.drive_of(ticked))
    }

    /// What the target did last.
    pub fn last(&self) -> Option<Ticked> {
        self.last
    }

    /// What the sensor sees, in um.
    pub fn displacement_um(&self) -> f64 {
        self.displacement_um
    }

    /// Samples since power-on.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Time between two samples in s.
    pub fn sample_time_s(&self) -> f64 {
        self.hardware.sample_time_s
    }

    /// The target.
    pub fn target(&self) -> &T {
        &self.target
    }

    /// The target alone.
    pub fn into_target(self) -> T {
        self.target
    }

    /// Instructions of every sample since the last call in which a reference was followed.
    pub fn take_instructions(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.counts)
    }

    /// Bytes from the host; the answer comes by [`Bench::heard`].
    ///
    /// # Errors
    /// A target that failed.
    pub fn hear(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let answer = self.target.link(bytes)?;
        self.to_host.extend(answer);
        Ok(())
    }

    /// What the target has sent since the last call.
    pub fn heard(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.to_host)
    }

    fn drive_of(&self, ticked: Ticked) -> f64 {
        if ticked.driver_enabled {
            f64::from(self.hardware.dac.drive(ticked.code))
        } else {
            0.0
        }
    }
}

impl<T: Target> Port for Bench<T> {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.hear(bytes).map_err(io::Error::other)
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        let until = self.now() + limit;
        while self.to_host.is_empty() && self.now() < until {
            for _ in 0..BLOCK {
                self.tick().map_err(io::Error::other)?;
            }
            self.hear(&[]).map_err(io::Error::other)?;
        }
        let len = self.to_host.len().min(buffer.len());
        buffer[..len].copy_from_slice(&self.to_host[..len]);
        self.to_host.drain(..len);
        Ok(len)
    }

    fn now(&self) -> Duration {
        Duration::from_secs_f64(self.samples as f64 * self.hardware.sample_time_s)
    }
}
