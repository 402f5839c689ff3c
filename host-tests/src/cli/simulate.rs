//! `hysteron simulate`.

use std::path::PathBuf;

use clap::Args;

use hysteron_host::error::Error;
use hysteron_host::output::AtomicFile;
use hysteron_host::signals::{Quantity, read};
use hysteron_host::{model_file, stage};

/// Compute the displacement of a modelled stage.
///
/// The rate is that of the drive itself: backward difference, zero at the first sample. Plays start
/// at zero, or at the nearest admissible state when the first sample is not zero. A modified play model
/// runs free: its feedback is of its own outputs.
#[derive(Debug, Args)]
pub struct Arguments {
    /// A model.toml, or a built-in model: p753, p753-printed, example-f.
    #[arg(long, value_name = "M")]
    model: String,
    /// CSV with the columns time_s and drive_v.
    #[arg(long, value_name = "IN.csv")]
    input: PathBuf,
    /// CSV to write, with the columns time_s and displacement_um.
    #[arg(long, value_name = "OUT.csv")]
    out: PathBuf,
}

/// Reads, simulates, writes.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let file = model_file::resolve(&arguments.model)?;
    let drive = read(&arguments.input, Quantity::Drive)?;
    let displacement = stage::displacement(&file, drive.sample_time_s, &drive.values)?;
    let mut out = AtomicFile::create(&arguments.out)?;
    out.write_columns(&[
        ("time_s", &drive.time_s),
        ("displacement_um", &displacement),
    ])?;
    out.commit()
}
