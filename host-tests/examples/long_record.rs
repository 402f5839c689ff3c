//! Writes a long record of a simulated stage as one CSV, sample by sample: a sine of changing
//! amplitude at 20 kHz, the displacement with noise and hum. The file is there once it is complete.
//!
//! `cargo run --release --example long_record -- SAMPLES HERTZ HUM_UM FILE`

use std::env;
use std::f64::consts::TAU;
use std::io::Write;

use hysteron_host::output::{AtomicFile, remove_unfinished_on_interrupt};
use hysteron_host::plant::{Reconstruction, Sensor, Stage};

const SAMPLE_TIME_S: f64 = 5e-5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [samples, hertz, hum_um, file] = arguments.as_slice() else {
        return Err("name samples, hertz, hum in um and a file".into());
    };
    let (samples, hertz): (u64, f64) = (samples.parse()?, hertz.parse()?);
    let hum_um: f64 = hum_um.parse()?;
    let stage = Stage {
        dac: None,
        reconstruction: Reconstruction::Ramp,
        amplifier_tau_s: 0.0,
        oversample: 1,
        sensor: Sensor {
            noise_um: 0.02,
            ..Stage::p753().sensor
        },
        ..Stage::p753()
    };
    let mut plant = stage.start(SAMPLE_TIME_S, 0.0)?;
    remove_unfinished_on_interrupt()?;
    let mut out = AtomicFile::create(file)?;
    writeln!(out, "time_s,drive_v,displacement_um")?;
    for k in 0..samples {
        let time = k as f64 * SAMPLE_TIME_S;
        // The amplitude goes up and down once in seventeen cycles.
        let amplitude = 25.0 + 15.0 * (TAU * hertz * time / 17.0).cos();
        let drive = amplitude * (TAU * hertz * time).sin();
        let hum = hum_um * (TAU * 50.0 * time).sin();
        let displacement = plant.step(drive)? + hum;
        writeln!(out, "{time:.5},{drive:.5},{displacement:.5}")?;
    }
    out.commit()?;
    Ok(())
}
