//! `hysteron link`.

mod bench;
mod motion;
mod watch;
mod waveform;

use std::path::PathBuf;

use clap::{Args, Subcommand};

use hysteron::link::Command;
use hysteron_host::error::Error;
use hysteron_host::link::{self, Client};

/// Talk to the firmware: settings, model, references, recordings.
///
/// Ctrl-C while something is played or recorded tells the output to stop and leaves no half file.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A serial device, tcp:HOST:PORT or unix:PATH.
    #[arg(long, value_name = "P")]
    port: String,
    #[command(subcommand)]
    action: Action,
}

const EXAMPLES: &str = "\
Examples:
  hysteron link --port /dev/ttyUSB0 info
  hysteron link --port /dev/ttyUSB0 record --out measured --excitation sine --amplitude 5
  hysteron link --port /dev/ttyUSB0 upload out/stage/model.toml --inverse preview
  hysteron link --port tcp:127.0.0.1:5000 stream scan.csv --stop";

#[derive(Debug, Subcommand)]
enum Action {
    /// Who is there, and how it fares.
    Info,
    /// Print the settings as TOML, or set those that a file names.
    Settings {
        /// A TOML file with all of the settings or some of them; the output must be off and at rest.
        #[arg(long, value_name = "SETTINGS.toml")]
        set: Option<PathBuf>,
    },
    /// Put a model into the target; it takes over without a jump.
    Upload(bench::Upload),
    /// Save settings and model in the target's flash; the output must be off and at rest.
    Save,
    /// Play a reference that the target computes itself.
    Start(motion::Start),
    /// The output ramps to rest.
    Stop,
    /// The output stands still.
    Hold,
    /// Leave a fault.
    Clear,
    /// Play an excitation, record drive and displacement into a data set for `hysteron identify`.
    Record(motion::Record),
    /// Play a reference from a CSV, through the compensator.
    Stream(motion::Stream),
    /// Print how the target fares, until Ctrl-C.
    Watch(watch::Watch),
}

/// Connects and does what is asked.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut port = link::open(&arguments.port)?;
    let (mut client, identity) = Client::connect(port.as_mut())?;
    let client = &mut client;
    match &arguments.action {
        Action::Info => bench::info(client, &identity),
        Action::Settings { set } => bench::settings(client, set.as_deref()),
        Action::Upload(upload) => upload.run(client),
        Action::Save => bench::save(client),
        Action::Start(start) => start.run(client),
        Action::Stop => client.stop(),
        Action::Hold => client.tell(Command::Hold),
        Action::Clear => client.tell(Command::Clear),
        Action::Record(record) => record.run(client),
        Action::Stream(stream) => stream.run(client),
        Action::Watch(watch) => watch.run(client),
    }
}

/// Tells of stages of a model that the target does without.
pub fn note_left_out(stages: &[&str], model: &str) {
    if !stages.is_empty() {
        let stages = stages.join(", ");
        eprintln!("note: {stages} of model \"{model}\" left out, no compensator undoes it");
    }
}
