//! Streams random references to the firmware in its emulator for as long as it is told to, with the
//! host computing every sample and link answer beside it; ends at the first thing that is wrong.
//!
//! `cargo run --release --example soak -- ELF SECONDS`, the ELF built with the feature `qemu`

use std::env;
use std::f64::consts::TAU;
use std::path::Path;
use std::time::{Duration, Instant};

use hysteron::control;
use hysteron::hysteresis::preview::PlantRate;
use hysteron::link::Command;
use hysteron_host::link::model::{self, Choice};
use hysteron_host::link::{Client, Excitation, play};
use hysteron_host::metrics::rms_error;
use hysteron_host::model_file::builtin;
use hysteron_host::pil::{Bench, Emulator, Hardware, Pair, Replica};
use hysteron_host::plant::Stage;
use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};

/// Length of a reference.
const PIECE_S: f64 = 20.0;
/// What does not count in its error: model and stage begin in different states.
const SKIPPED_S: f64 = 0.5;
const CHOICES: [Choice; 3] = [
    Choice::Explicit,
    Choice::Preview(PlantRate::Midpoint),
    Choice::Cascade(PlantRate::Midpoint),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [firmware, seconds] = arguments.as_slice() else {
        return Err("name the firmware's ELF and how many seconds it shall last".into());
    };
    let length = Duration::from_secs(seconds.parse()?);
    let hardware = Hardware::paper_j()?;
    let file = builtin("p753").ok_or("there is no built-in p753")?;
    let pair = Pair::new(Emulator::start(Path::new(firmware))?, Replica::power_on()?);
    let mut bench = Bench::new(pair, hardware, &Stage::p753())?;
    {
        let (mut client, _) = Client::connect(&mut bench)?;
        client.wait(Duration::from_millis(1))?;
        client.tell(Command::SetSettings(hardware.settings))?;
    }
    let begun = Instant::now();
    let mut instructions = 0;
    // Of each compensator: references, least and largest error.
    let mut errors = CHOICES.map(|choice| (choice, 0, f64::INFINITY, 0.0_f64));
    for piece in 0_u64.. {
        if begun.elapsed() >= length {
            break;
        }
        let mut rng = SmallRng::seed_from_u64(piece);
        let (choice, references, least, largest) = &mut errors[piece as usize % CHOICES.len()];
        let reference = reference(&mut rng, hardware.sample_time_s());
        let played = {
            let (mut client, _) = Client::connect(&mut bench)?;
            let record = model::record(&file, &hardware.settings, *choice)?.record;
            client.tell(Command::SetModel(Some(record)))?;
            let streamed = Excitation::streamed(control::Path::Compensated, &reference)?;
            play(&mut client, &streamed, true, &mut |_| {})?
        };
        if let Some(difference) = bench.target().first_difference() {
            return Err(difference.into());
        }
        if played.signals.displacement_um.len() != reference.len() {
            return Err("fewer samples were recorded than were streamed".into());
        }
        let from = (SKIPPED_S / hardware.sample_time_s()) as usize;
        let error = rms_error(&played.signals.displacement_um[from..], &reference[from..])?;
        *references += 1;
        *least = least.min(error);
        *largest = largest.max(error);
        instructions = bench
            .take_instructions()
            .into_iter()
            .fold(instructions, u32::max);
        if piece % 10 == 0 {
            eprintln!(
                "{:6.0} s: {} references, {} samples",
                begun.elapsed().as_secs_f64(),
                piece + 1,
                bench.samples()
            );
        }
    }
    let firmware_s = bench.samples() as f64 * hardware.sample_time_s();
    let pair = bench.into_target();
    println!(
        "{:.0} s, {firmware_s:.0} s of the firmware's time, {} samples compared, none differs",
        begun.elapsed().as_secs_f64(),
        pair.samples()
    );
    for (choice, references, least, largest) in errors.into_iter().filter(|(_, n, ..)| *n > 0) {
        println!(
            "{}: {references} references, error {least:.4} to {largest:.4} um rms",
            choice.name()
        );
    }
    println!("instructions of a sample: {instructions} at most");
    println!("stack: {} bytes", pair.into_emulator().stack_bytes()?);
    Ok(())
}

/// A sum of sines from 0.5 Hz to 80 Hz that starts at rest, 10 um to 40 um at most.
fn reference(rng: &mut SmallRng, sample_time_s: f64) -> Vec<f64> {
    let lines: [(f64, f64, f64); 6] = std::array::from_fn(|_| {
        let hertz = 0.5 * 160_f64.powf(rng.random::<f64>());
        (1.0 / hertz.sqrt(), hertz, TAU * rng.random::<f64>())
    });
    let sum: f64 = lines.iter().map(|(amplitude, ..)| amplitude).sum();
    let peak_um = 10.0 + 30.0 * rng.random::<f64>();
    let samples = (PIECE_S / sample_time_s) as usize;
    (0..samples)
        .map(|k| {
            let time = k as f64 * sample_time_s;
            let rise = (time / SKIPPED_S).min(1.0);
            let value: f64 = lines
                .iter()
                .map(|(amplitude, hertz, phase)| amplitude * (TAU * hertz * time + phase).sin())
                .sum();
            rise * peak_um * value / sum
        })
        .collect()
}
