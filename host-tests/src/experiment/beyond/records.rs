//! What each compensator's parameters are identified from: records of the plant, at most ten seconds.

use std::f64::consts::TAU;

use crate::dataset::{Dataset, LengthUnit, Record, Role, Zero};
use crate::error::Error;
use crate::experiment::refused;

use super::plants::Plant;

/// Length of each broadband record, s; there are four.
const BROADBAND_S: f64 = 2.5;

/// Records of a plant under drives that are functions of time.
struct Measured {
    plant: Plant,
    records: Vec<Record>,
}

impl Measured {
    fn new(plant: Plant) -> Self {
        Self {
            plant,
            records: Vec::new(),
        }
    }

    fn add(
        &mut self,
        name: String,
        role: Role,
        duration_s: f64,
        drive: impl Fn(f64) -> f64,
    ) -> Result<(), Error> {
        let h = self.plant.sample_time_s();
        let samples = (duration_s / h).round() as usize;
        let time_s: Vec<f64> = (0..samples).map(|k| k as f64 * h).collect();
        let full = self.plant.full_drive_v();
        let drive_v: Vec<f64> = time_s.iter().map(|&t| full * drive(t)).collect();
        let device = self.plant.device(1 + self.records.len() as u64);
        self.records.push(Record {
            name,
            role,
            start_s: 0.0,
            sample_time_s: h,
            displacement_um: device.run(&drive_v, h).map_err(refused)?,
            drive_v,
            time_s,
            continues: None,
        });
        Ok(())
    }

    fn dataset(self) -> Dataset {
        Dataset {
            name: self.plant.title().to_lowercase(),
            output_unit: LengthUnit::Micrometre,
            zero: Zero::Shared,
            input_zero: Zero::Shared,
            records: self.records,
        }
    }
}

/// 2 Hz that die away, for operators without a rate: 3 s.
///
/// # Errors
/// A drive that the plant refuses.
pub fn slow(plant: Plant) -> Result<Dataset, Error> {
    let mut measured = Measured::new(plant);
    let dying = |t: f64| (1.0 - t / 2.1) * (TAU * 2.0 * t).sin();
    let other = |t: f64| 0.6 * (TAU * 2.0 * t).sin() + 0.3 * (TAU * 5.0 * t).sin();
    measured.add("dying".into(), Role::Fit, 2.0, dying)?;
    measured.add("two tones".into(), Role::Select, 1.0, other)?;
    Ok(measured.dataset())
}

/// Loops at several frequencies, as paper J measured them: up to 100 Hz, on the bimorph up to 20 Hz,
/// below what its mode bends.
///
/// # Errors
/// A drive that the plant refuses.
pub fn loops(plant: Plant) -> Result<Dataset, Error> {
    let mut measured = Measured::new(plant);
    let frequencies: [f64; 4] = match plant {
        Plant::Plays | Plant::Relays => [1.0, 20.0, 50.0, 100.0],
        Plant::Bimorph => [1.0, 5.0, 10.0, 20.0],
    };
    for f in frequencies {
        let duration_s = (4.0 / f).max(0.2);
        measured.add(format!("{f} Hz"), Role::Fit, duration_s, |t| {
            0.9 * (t / 0.1).min(1.0) * (TAU * f * t).sin()
        })?;
    }
    let f = frequencies[2];
    measured.add("two tones".into(), Role::Select, 0.5, |t| {
        (t / 0.1).min(1.0) * (0.5 * (TAU * f * t).sin() + 0.3 * (TAU * 0.3 * f * t).sin())
    })?;
    Ok(measured.dataset())
}

/// Slow loops, small tones up to beyond the mode, a sweep whose harmonics meet it: 10 s.
///
/// # Errors
/// A drive that the plant refuses.
pub fn broadband(plant: Plant) -> Result<Dataset, Error> {
    let mut measured = Measured::new(plant);
    let spacing_hz = match plant {
        Plant::Plays | Plant::Relays => 29.0,
        Plant::Bimorph => 7.0,
    };
    let tones = |start: f64| {
        move |t: f64| {
            let tone = |q: i32| {
                let q = f64::from(q);
                0.006 * (TAU * spacing_hz * q * t + start * q * q).sin()
            };
            let grown = (t / 0.2).min(1.0);
            0.6 * (TAU * 1.2 * t).sin() + grown * (1..=19).map(tone).sum::<f64>()
        }
    };
    let dying = |t: f64| (1.0 - t / 2.6) * (TAU * 2.0 * t).sin();
    let sweep = |t: f64| 0.5 * (t / 0.2).min(1.0) * (TAU * (8.0 * t + 10.4 * t * t)).sin();
    measured.add("slow".into(), Role::Fit, BROADBAND_S, dying)?;
    measured.add("tones".into(), Role::Fit, BROADBAND_S, tones(0.11))?;
    measured.add("sweep".into(), Role::Fit, BROADBAND_S, sweep)?;
    measured.add("other tones".into(), Role::Select, BROADBAND_S, tones(0.31))?;
    Ok(measured.dataset())
}
