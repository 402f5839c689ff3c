//! Records of the two papers' stages for worked examples of discovery, made by the simulated stages
//! of [`plant`](crate::plant), which share nothing with the models that are fitted to them.

use crate::dataset::{Dataset, LengthUnit, Record, Role, Zero};
use crate::error::Error;
use crate::plant::bimorph::Bimorph;
use crate::plant::{Stage, StageError};

use super::references::{
    Grid, Reference, ReferenceError, example_f, major_minor, multisine, sine, triangle,
};
use super::refused;

/// Largest drive of paper J, V.
const J_VOLTS: f64 = 40.0;
/// Highest sample rate of paper J, Hz.
const J_RATE_HZ: f64 = 10_000.0;

/// Al Janaideh and Krejci's stage, [`Stage::p753`], under the drives of their paper: sines of 40 V
/// from 1 to 100 Hz, triangles, two amplitudes, two tones. In volts and micrometres.
///
/// # Errors
/// None that the caller could cause: the drives and the stage are fixed.
pub fn paper_j() -> Result<Dataset, Error> {
    let sine_of = |hz: f64| wave(hz, |grid| sine(grid, J_VOLTS, hz, 0.0));
    let drives = [
        ("sine-1hz", Role::Fit, sine_of(1.0)),
        ("sine-10hz", Role::Fit, sine_of(10.0)),
        ("sine-50hz", Role::Fit, sine_of(50.0)),
        ("sine-100hz", Role::Fit, sine_of(100.0)),
        (
            "two-tones-60hz",
            Role::Fit,
            wave(60.0, |grid| example_f(grid, 60.0)),
        ),
        (
            "triangle-100hz",
            Role::Fit,
            wave(100.0, |grid| triangle(grid, J_VOLTS, 100.0, 0.0)),
        ),
        ("sine-25hz", Role::Select, sine_of(25.0)),
        ("sine-75hz", Role::Select, sine_of(75.0)),
        (
            "triangle-50hz",
            Role::Report,
            wave(50.0, |grid| triangle(grid, J_VOLTS, 50.0, 0.0)),
        ),
        (
            "two-tones-10hz",
            Role::Report,
            wave(10.0, |grid| example_f(grid, 10.0)),
        ),
        (
            "two-amplitudes-50hz",
            Role::Report,
            wave(50.0, |grid| major_minor(grid, J_VOLTS, 0.5 * J_VOLTS, 50.0)),
        ),
        ("sine-90hz", Role::Report, sine_of(90.0)),
    ];
    let mut stage = Stage::p753();
    records("paper J", LengthUnit::Micrometre, drives, |drive| {
        stage.sensor.seed += 1;
        stage.run(&drive.samples, drive.sample_time_s)
    })
}

/// Four cycles of a drive of this fundamental frequency, 200 points a cycle as in the paper where
/// the sample rate allows it.
fn wave(
    hz: f64,
    make: impl Fn(&Grid) -> Result<Reference, ReferenceError>,
) -> Result<Reference, ReferenceError> {
    const CYCLES: f64 = 4.0;
    const POINTS_A_CYCLE: f64 = 200.0;
    let rate_hz = (POINTS_A_CYCLE * hz).min(J_RATE_HZ);
    make(&Grid::for_cycles(1.0 / rate_hz, hz, CYCLES)?)
}

/// Morita, Fujii and Hosoda's bimorph, [`Bimorph::pzba`], at 5 kHz: sines of full drive at
/// frequencies of the paper, smaller ones, and multisines over its band of 110 Hz. Displacement in
/// millimetres, as there.
///
/// # Errors
/// None that the caller could cause: the drives and the bimorph are fixed.
pub fn paper_m() -> Result<Dataset, Error> {
    let full = Bimorph::FULL_DRIVE_V;
    let sine_of = |share: f64, hz: f64| -> Result<Reference, ReferenceError> {
        const SECONDS: f64 = 0.8;
        let grid = Grid::for_duration(Bimorph::SAMPLE_TIME_S, SECONDS)?;
        sine(&grid, share * full, hz, 0.0)
    };
    let noise_of = |share: f64, seed: u64| {
        const LOWEST_HZ: f64 = 2.5;
        let grid = Grid::for_cycles(Bimorph::SAMPLE_TIME_S, LOWEST_HZ, 2.0)?;
        multisine(&grid, share * full, LOWEST_HZ, 1..=44, seed)
    };
    let drives = [
        ("sine-5hz", Role::Fit, sine_of(1.0, 5.0)),
        ("sine-15hz", Role::Fit, sine_of(1.0, 15.0)),
        ("sine-25hz", Role::Fit, sine_of(1.0, 25.0)),
        ("half-sine-5hz", Role::Fit, sine_of(0.5, 5.0)),
        ("multisine-1", Role::Fit, noise_of(1.0, 1)),
        ("sine-10hz", Role::Select, sine_of(1.0, 10.0)),
        ("sine-35hz", Role::Select, sine_of(1.0, 35.0)),
        ("multisine-2", Role::Select, noise_of(1.0, 2)),
        ("sine-20hz", Role::Report, sine_of(1.0, 20.0)),
        ("sine-50hz", Role::Report, sine_of(1.0, 50.0)),
        ("multisine-3", Role::Report, noise_of(0.7, 3)),
    ];
    let mut bimorph = Bimorph::pzba();
    records("paper M", LengthUnit::Millimetre, drives, |drive| {
        bimorph.sensor.seed += 1;
        bimorph.run(&drive.samples, drive.sample_time_s)
    })
}

/// One record a drive, one after the other with a second of rest between.
fn records<const N: usize>(
    name: &str,
    output_unit: LengthUnit,
    drives: [(&str, Role, Result<Reference, ReferenceError>); N],
    mut measure: impl FnMut(&Reference) -> Result<Vec<f64>, StageError>,
) -> Result<Dataset, Error> {
    const REST_S: f64 = 1.0;
    let mut start_s = 0.0;
    let mut records = Vec::with_capacity(N);
    for (name, role, drive) in drives {
        let drive = drive.map_err(refused)?;
        let displacement_um = measure(&drive).map_err(refused)?;
        let time_s: Vec<f64> = (0..drive.samples.len())
            .map(|k| start_s + k as f64 * drive.sample_time_s)
            .collect();
        let end_s = start_s + drive.samples.len() as f64 * drive.sample_time_s;
        records.push(Record {
            name: name.to_owned(),
            role,
            start_s,
            sample_time_s: drive.sample_time_s,
            drive_v: drive.samples,
            displacement_um,
            continues: None,
            time_s,
        });
        start_s = end_s + REST_S;
    }
    Ok(Dataset {
        name: name.to_owned(),
        output_unit,
        zero: Zero::Shared,
        input_zero: Zero::Shared,
        records,
    })
}
