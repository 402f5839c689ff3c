//! The demonstration: a simulated stage is measured, identified and driven.
//!
//! The stage is the simulated P-753 of [`crate::plant`], its displacement read from the middle of its
//! travel. It is measured in one session: each record starts in the state that the one before left
//! behind, as in a laboratory. Recorded is the voltage at the actuator, behind converter and
//! amplifier.
//!
//! In the end an effect is hidden in a stage of [`crate::plant::hidden`], found, named and added.

mod discovery;
mod page;

use serde_json::{Value, json};

use crate::dataset::Role;
use crate::error::Error;
use crate::identify::Identification;
use crate::metrics::{max_abs_error, rms_error};
use crate::plant::{Simulation, Stage};
use crate::report::Page;
use crate::stage;

use super::references::{Grid, Reference, major_minor, multisine, raster, sine, triangle};
use super::refused;

pub use discovery::{Discovery, discover};

/// Time between samples in s.
const SAMPLE_TIME_S: f64 = 1e-4;
/// Amplitude of the drive in the measurement, V.
const DRIVE_V: f64 = 40.0;
/// What the sensor reads where an untouched stage rests, um.
const SENSOR_ZERO_UM: f64 = 50.0;
/// Half the travel that the references ask for, um.
const TRAVEL_UM: f64 = 35.0;
/// Samples in which the drive goes to where a record starts.
const APPROACH: usize = 200;

/// A record as it was measured.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// Name of its CSV file.
    pub file: &'static str,
    /// What it serves for.
    pub role: Role,
    /// Time of each sample in s, on the clock of the session.
    pub time_s: Vec<f64>,
    /// Voltage at the actuator in V.
    pub drive_v: Vec<f64>,
    /// Sensor reading in um.
    pub displacement_um: Vec<f64>,
}

/// Measures the stage: sines, triangle, two amplitudes and a multisine.
///
/// # Errors
/// A signal or stage that is refused; the fixed ones of the demonstration are not.
pub fn measure() -> Result<Vec<Measurement>, Error> {
    let mut simulation = Stage::p753().start(SAMPLE_TIME_S, 0.0).map_err(refused)?;
    let mut clock_s = 0.0;
    commands()?
        .into_iter()
        .map(|(file, role, command)| {
            approach(&mut simulation, command.samples[0])?;
            clock_s += APPROACH as f64 * SAMPLE_TIME_S;
            let mut measurement = Measurement {
                file,
                role,
                time_s: Vec::with_capacity(command.samples.len()),
                drive_v: Vec::with_capacity(command.samples.len()),
                displacement_um: Vec::with_capacity(command.samples.len()),
            };
            for (k, &volts) in command.samples.iter().enumerate() {
                let displacement = simulation.step(volts).map_err(refused)?;
                measurement.time_s.push(clock_s + k as f64 * SAMPLE_TIME_S);
                measurement.drive_v.push(simulation.drive_v());
                measurement
                    .displacement_um
                    .push(SENSOR_ZERO_UM + displacement);
            }
            clock_s += command.samples.len() as f64 * SAMPLE_TIME_S;
            Ok(measurement)
        })
        .collect()
}

/// What the converter is told for each record, V.
fn commands() -> Result<[(&'static str, Role, Reference); 7], Error> {
    let grid = |hz, cycles| Grid::for_cycles(SAMPLE_TIME_S, hz, cycles).map_err(refused);
    let tone = |hz, cycles| sine(&grid(hz, cycles)?, DRIVE_V, hz, 0.0).map_err(refused);
    let two =
        |hz, cycles| major_minor(&grid(hz, cycles)?, DRIVE_V, 0.5 * DRIVE_V, hz).map_err(refused);
    let rise_and_fall = triangle(&grid(25.0, 6.0)?, 0.75 * DRIVE_V, 25.0, 0.0).map_err(refused)?;
    let rich = multisine(&grid(5.0, 4.0)?, DRIVE_V, 5.0, 1..=10, 1).map_err(refused)?;
    Ok([
        ("sine_2hz.csv", Role::Fit, tone(2.0, 4.0)?),
        ("sine_50hz.csv", Role::Fit, tone(50.0, 8.0)?),
        ("sine_100hz.csv", Role::Fit, tone(100.0, 8.0)?),
        ("two_amplitudes_10hz.csv", Role::Fit, two(10.0, 6.0)?),
        ("triangle_25hz.csv", Role::Select, rise_and_fall),
        ("two_amplitudes_40hz.csv", Role::Select, two(40.0, 10.0)?),
        ("multisine_5_to_50hz.csv", Role::Report, rich),
    ])
}

/// Ramps the drive to `volts`.
fn approach(simulation: &mut Simulation, volts: f64) -> Result<(), Error> {
    let from = simulation.drive_v();
    for k in 1..=APPROACH {
        let share = k as f64 / APPROACH as f64;
        simulation
            .step(from + share * (volts - from))
            .map_err(refused)?;
    }
    Ok(())
}

/// The `dataset.toml` of these records.
pub fn dataset_toml(measurements: &[Measurement]) -> String {
    let mut text = String::from(
        "name = \"simulated P-753\"\n\n[signals]\n\
         time   = { column = \"time_s\", unit = \"s\" }\n\
         input  = { column = \"drive_v\", unit = \"V\" }\n\
         output = { column = \"displacement_um\", unit = \"um\" }\n",
    );
    for measurement in measurements {
        let role = match measurement.role {
            Role::Fit => "fit",
            Role::Select => "select",
            Role::Report => "report",
        };
        text += &format!(
            "\n[[record]]\nfile = \"{}\"\nrole = \"{role}\"\n",
            measurement.file
        );
    }
    text
}

/// How the stage follows one reference.
#[derive(Clone, Debug)]
pub struct Tracking {
    /// The reference in words.
    pub name: &'static str,
    /// Time in s.
    pub time_s: Vec<f64>,
    /// The reference in um.
    pub reference_um: Vec<f64>,
    /// Sensor reading in um under the drive of a straight line.
    pub without_um: Vec<f64>,
    /// Sensor reading in um under the compensated drive.
    pub with_um: Vec<f64>,
    /// Samples at the start that are not scored: the first period, in which the stage leaves the
    /// state that it was found in.
    pub settled: usize,
    /// Largest error without and with compensation, um.
    pub largest_um: [f64; 2],
    /// Rms error without and with compensation, um.
    pub rms_um: [f64; 2],
}

/// All that the demonstration shows.
#[derive(Clone, Debug)]
pub struct Demonstration {
    /// What was identified from the records.
    pub found: Identification,
    /// Slope in um/V and reading at zero drive in um of the best straight line, which drives the
    /// stage without compensation.
    pub line: (f64, f64),
    /// How the stage follows each reference.
    pub tracking: Vec<Tracking>,
    /// An effect hidden in another stage and looked for, where that was done.
    pub discovery: Option<Discovery>,
}

/// Drives the stage along a raster and a sine, by the identified model and by a straight line.
///
/// # Errors
/// An identified model that cannot be inverted.
pub fn drive(found: Identification) -> Result<Demonstration, Error> {
    let line = straight_line(&found);
    let grid = Grid::for_cycles(SAMPLE_TIME_S, 50.0, 8.0).map_err(refused)?;
    let tone = sine(&grid, TRAVEL_UM, 50.0, 0.0).map_err(refused)?;
    let scan = raster(SAMPLE_TIME_S, 2.0 * TRAVEL_UM, 1.0, 6, 10.0).map_err(refused)?;
    let references = [
        ("raster of 10 lines a second", scan.fast, -TRAVEL_UM, 10.0),
        ("sine of 50 Hz", tone, 0.0, 50.0),
    ];
    let tracking = references
        .into_iter()
        .map(|(name, reference, shift, hz)| {
            let reference_um = reference
                .samples
                .iter()
                .map(|sample| sample + shift + SENSOR_ZERO_UM)
                .collect();
            let settled = (1.0 / (hz * SAMPLE_TIME_S)).round() as usize;
            track(&found, line, name, reference_um, settled)
        })
        .collect::<Result<_, _>>()?;
    Ok(Demonstration {
        found,
        line,
        tracking,
        discovery: None,
    })
}

fn track(
    found: &Identification,
    (slope, zero): (f64, f64),
    name: &'static str,
    reference_um: Vec<f64>,
    settled: usize,
) -> Result<Tracking, Error> {
    let compensator = stage::compensator(&found.model, SAMPLE_TIME_S)?;
    let compensated = stage::compensate(&compensator, &reference_um).map_err(refused)?;
    let straight: Vec<f64> = reference_um.iter().map(|v| (v - zero) / slope).collect();
    let [without_um, with_um] = [read(&straight)?, read(&compensated)?];
    let wanted = &reference_um[settled..];
    let largest = |y: &[f64]| max_abs_error(wanted, &y[settled..]).map_err(refused);
    let rms = |y: &[f64]| rms_error(wanted, &y[settled..]).map_err(refused);
    Ok(Tracking {
        name,
        time_s: (0..reference_um.len())
            .map(|k| k as f64 * SAMPLE_TIME_S)
            .collect(),
        settled,
        largest_um: [largest(&without_um)?, largest(&with_um)?],
        rms_um: [rms(&without_um)?, rms(&with_um)?],
        reference_um,
        without_um,
        with_um,
    })
}

/// Sensor readings along a drive, the stage coming from rest at 0 V.
fn read(drive_v: &[f64]) -> Result<Vec<f64>, Error> {
    let mut simulation = Stage::p753().start(SAMPLE_TIME_S, 0.0).map_err(refused)?;
    approach(&mut simulation, drive_v[0])?;
    drive_v
        .iter()
        .map(|&volts| Ok(SENSOR_ZERO_UM + simulation.step(volts).map_err(refused)?))
        .collect()
}

/// Slope and value at zero of the least-squares line through the records for fitting.
fn straight_line(found: &Identification) -> (f64, f64) {
    let samples = || {
        found
            .records
            .iter()
            .filter(|record| record.role == Role::Fit)
            .flat_map(|record| record.drive_v.iter().zip(&record.measured_um))
    };
    let count = samples().count() as f64;
    let (sum_u, sum_y) = samples().fold((0.0, 0.0), |(u, y), (du, dy)| (u + du, y + dy));
    let (mean_u, mean_y) = (sum_u / count, sum_y / count);
    let (uu, uy) = samples().fold((0.0, 0.0), |(uu, uy), (u, y)| {
        let du = u - mean_u;
        (uu + du * du, uy + du * (y - mean_y))
    });
    let slope = uy / uu;
    (slope, mean_y - slope * mean_u)
}

impl Demonstration {
    /// The contents of `demo.json`: lengths in um.
    pub fn to_json(&self) -> Value {
        let references: Vec<Value> = self
            .tracking
            .iter()
            .map(|tracking| {
                let both = |[straight_line, compensated]: [f64; 2]| {
                    json!({ "straight_line": straight_line, "compensated": compensated })
                };
                json!({
                    "name": tracking.name,
                    "largest_error_um": both(tracking.largest_um),
                    "rms_error_um": both(tracking.rms_um),
                })
            })
            .collect();
        json!({
            "identification": {
                "noise_floor_um": self.found.noise.map(|(um, _)| um),
                "report_rms_um": self.found.rms.report,
                "straight_line_report_rms_um": self.found.line_rms.report,
            },
            "straight_line": { "slope_um_per_v": self.line.0, "zero_um": self.line.1 },
            "references": references,
            "discovery": self.discovery.as_ref().map(Discovery::to_json),
        })
    }

    /// The page.
    pub fn page(&self) -> Page {
        page::page(self)
    }
}
