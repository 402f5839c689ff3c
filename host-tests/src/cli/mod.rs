//! The subcommands: arguments in, files and a short summary out.

mod blind;
mod compensate;
mod demo;
mod diagnose;
mod experiment;
mod export;
mod faults;
mod hide;
mod identify;
mod link;
mod pil;
mod progress;
mod say;
#[cfg(test)]
mod shown;
mod simulate;

use clap::{Parser, Subcommand};

use hysteron_host::error::Error;
use hysteron_host::output::remove_unfinished_on_interrupt;

/// Cancel the hysteresis of a piezo stage: identify it from measured data, compute the drive that
/// makes it follow a reference.
///
/// Without a command: `hysteron demo`.
#[derive(Debug, Parser)]
#[command(name = "hysteron", version, after_help = EXAMPLES)]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
    /// Print the figures as JSON, one object a line, in place of a summary.
    #[arg(long, global = true)]
    json: bool,
}

const EXAMPLES: &str = "\
Examples:
  hysteron demo --seed 3
  hysteron identify measured/ --out out/stage
  hysteron diagnose measured/ --out out/found
  hysteron compensate --model out/stage/model.toml --reference scan.csv --out drive.csv
  hysteron simulate --model p753 --input drive.csv --out displacement.csv
  hysteron export --model out/stage/model.toml --format c --sample-rate 10000 --out stage.h
  hysteron experiment j --out out/j
  hysteron experiment m --out out/m
  hysteron link --port /dev/ttyUSB0 record --out measured --excitation sine --amplitude 5
  hysteron hide --effect random --seed 3 --out out/hidden
  hysteron blind --cases 40 --tier 2 --out out/blind
  hysteron pil --out out/pil
  hysteron faults --out out/faults

Exit codes: 0 done, 2 bad input or a file that cannot be read or written, 130 interrupted.";

#[derive(Debug, Subcommand)]
enum Command {
    /// Show it all on simulated stages: identify, compensate, find a hidden effect.
    Demo(demo::Arguments),
    /// Fit a model to a data set: model.toml, identification.json, report.html.
    Identify(identify::Arguments),
    /// Find what a model misses of a data set and add it: report.html, model.toml, diagnosis.json.
    Diagnose(diagnose::Arguments),
    /// Displacement of a modelled stage for a drive.
    Simulate(simulate::Arguments),
    /// Drive that makes a modelled stage follow a reference.
    Compensate(compensate::Arguments),
    /// Write a model as a C header or a Rust module for a firmware of your own.
    Export(export::Arguments),
    /// Reproduce a paper's experiments: a JSON file and a page.
    Experiment(experiment::Arguments),
    /// Talk to the firmware over a serial device or a socket.
    Link(link::Arguments),
    /// Hide an effect in simulated data, for a diagnosis to find.
    Hide(hide::Arguments),
    /// Hide and diagnose in bulk, hold the answers against the truth: blind.json and a page.
    Blind(blind::Arguments),
    /// Run the firmware in an emulator: pil.json and a page.
    Pil(pil::Arguments),
    /// Inject faults by the thousand into the firmware: faults.json and a page.
    Faults(faults::Arguments),
}

/// Parses the command line and does what it says.
pub fn run() -> Result<(), Error> {
    let arguments = Arguments::parse();
    if arguments.json {
        say::set_json();
    }
    remove_unfinished_on_interrupt()?;
    let done = match arguments.command {
        None => demo::run(&demo::Arguments::default()),
        Some(Command::Demo(arguments)) => demo::run(&arguments),
        Some(Command::Identify(arguments)) => identify::run(&arguments),
        Some(Command::Diagnose(arguments)) => diagnose::run(&arguments),
        Some(Command::Simulate(arguments)) => simulate::run(&arguments),
        Some(Command::Compensate(arguments)) => compensate::run(&arguments),
        Some(Command::Export(arguments)) => export::run(&arguments),
        Some(Command::Experiment(arguments)) => experiment::run(&arguments),
        Some(Command::Link(arguments)) => link::run(&arguments),
        Some(Command::Hide(arguments)) => hide::run(&arguments),
        Some(Command::Blind(arguments)) => blind::run(&arguments),
        Some(Command::Pil(arguments)) => pil::run(&arguments),
        Some(Command::Faults(arguments)) => faults::run(&arguments),
    };
    done.and_then(|()| say::refusal())
}
