//! `hysteron experiment` and the demonstration.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use hysteron_host::error::Error;
use hysteron_host::output::OutputFolder;

use super::progress;

/// Reproduce a paper's experiments.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    experiment: Experiment,
}

#[derive(Debug, Subcommand)]
enum Experiment {
    /// Paper J: rate-dependent Prandtl-Ishlinskii model and inverse; writes j.json and report.html.
    J {
        /// The folder to write to.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
}

/// Runs one experiment.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    match &arguments.experiment {
        Experiment::J { out } => j(out),
    }
}
