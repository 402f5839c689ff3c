//! `hysteron simulate`.

use std::num::NonZeroU16;
use std::path::PathBuf;

use clap::{Args, ValueEnum};

use hysteron_host::error::Error;
use hysteron_host::model_file::{self, ModelFile};
use hysteron_host::output::AtomicFile;
use hysteron_host::signals::{Quantity, Signal, read};
use hysteron_host::stage;

/// Compute the displacement of a modelled stage.
///
/// The rate is that of the drive itself, zero at the ends of the record. Plays start at zero, or at
/// the nearest admissible state when the first sample is not zero.
/// A modified play model runs free: its feedback is of its own outputs.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A model.toml, or a built-in model: p753, p753-printed, example-f.
    #[arg(long, value_name = "M")]
    model: String,
    /// CSV, .npz or .npy with the columns time_s and drive_v.
    #[arg(long, value_name = "IN")]
    input: PathBuf,
    /// File to write, with the columns time_s and displacement_um: arrays if it ends in .npz or .npy, else
    /// CSV.
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Which rate of the drive the stage sees.
    #[arg(long, value_enum, default_value_t)]
    rate: Rate,
    /// Join the drive by straight lines and step this many times finer; still one row out for each
    /// row in.
    #[arg(long, value_name = "K", default_value = "1")]
    oversample: NonZeroU16,
}

const EXAMPLES: &str = "\
Examples:
  hysteron simulate --model p753 --input drive.csv --out displacement.csv
  hysteron simulate --model out/stage/model.toml --input drive.npz --out displacement.npz";

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Rate {
    /// That of the step that led to the sample: backward difference.
    #[default]
    Backward,
    /// That of the step to come: forward difference.
    Forward,
}

/// Reads, simulates, writes.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let file = model_file::resolve(&arguments.model)?;
    let drive = read(&arguments.input, Quantity::Drive)?;
    let displacement = displacement(&file, arguments, &drive)?;
    let mut out = AtomicFile::create(&arguments.out)?;
    out.write_columns(&[
        ("time_s", &drive.time_s),
        ("displacement_um", &displacement),
    ])?;
    out.commit()
}

fn displacement(
    file: &ModelFile,
    arguments: &Arguments,
    drive: &Signal,
) -> Result<Vec<f64>, Error> {
    let factor = usize::from(arguments.oversample.get());
    if factor > 1 && file.modified_play().is_some() {
        return Err(Error::request(
            "a modified play model holds at its own sample time; leave --oversample out",
        ));
    }
    let h = drive.sample_time_s / factor as f64;
    let fine = stage::refine(&drive.values, factor);
    let displacement = match arguments.rate {
        Rate::Backward => stage::displacement(file, h, &fine)?,
        Rate::Forward if file.effects().next().is_some() => {
            return Err(Error::request(
                "--rate forward is for models without effects around the hysteresis; leave it out",
            ));
        }
        Rate::Forward => stage::simulate_forward(&stage::model(file, h)?, &fine),
    };
    Ok(displacement.into_iter().step_by(factor).collect())
}
