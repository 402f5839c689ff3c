//! `hysteron compensate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use hysteron_host::error::Error;
use hysteron_host::model_file::{self, ModelFile, Stage};
use hysteron_host::output::AtomicFile;
use hysteron_host::signals::{Quantity, Signal, read};
use hysteron_host::stage;

/// Compute the drive that makes a modelled stage follow a reference.
///
/// The drive is the voltage at the actuator. The rate is that of the reference: backward difference,
/// zero at the first sample. Plays start at zero, or at the nearest admissible state when the first
/// sample is not zero. A modified play model is inverted by the law that it names, with the rate of the
/// drive itself, and within its range.
#[derive(Debug, Args)]
pub struct Arguments {
    /// A model.toml, or a built-in model: p753, p753-printed, example-f.
    #[arg(long, value_name = "M")]
    model: String,
    /// CSV with the columns time_s and reference_um.
    #[arg(long, value_name = "REF.csv")]
    reference: PathBuf,
    /// CSV to write, with the columns time_s and drive_v.
    #[arg(long, value_name = "OUT.csv")]
    out: PathBuf,
    /// Which inverse.
    #[arg(long, value_enum, default_value_t)]
    inverse: Inverse,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Inverse {
    /// The analytic inverse with the rate of the reference; of a modified play model, DIM.
    #[default]
    Explicit,
    /// The analytic inverse with the rate term left out.
    RateIndependent,
    /// Inverses of all stages of the model, lags, modes and delays undone ahead of time, the rate term
    /// with a preview; the drive is aligned with the reference.
    Cascade,
    /// Direct inverse multiplication, for a modified play model.
    Dim,
}

/// Reads, compensates, writes.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut file = model_file::resolve(&arguments.model)?;
    if let Inverse::RateIndependent = arguments.inverse {
        file = file.rate_independent();
    }
    let reference = read(&arguments.reference, Quantity::Reference)?;
    let drive = drive(&file, arguments.inverse, &reference)?;
    let mut out = AtomicFile::create(&arguments.out)?;
    out.write_columns(&[("time_s", &reference.time_s), ("drive_v", &drive)])?;
    out.commit()
}

fn drive(file: &ModelFile, inverse: Inverse, reference: &Signal) -> Result<Vec<f64>, Error> {
    let sample_time_s = reference.sample_time_s;
    match inverse {
        Inverse::Cascade => stage::drive_ahead(file, sample_time_s, &reference.values),
        Inverse::Dim if file.modified_play().is_none() => Err(Error::request(format!(
            "model \"{}\" has no stage modified-play, which dim needs; use another --inverse",
            file.name
        ))),
        Inverse::Explicit | Inverse::RateIndependent | Inverse::Dim => {
            let ignored: Vec<&str> = file.effects().map(Stage::name).collect();
            if !ignored.is_empty() {
                eprintln!(
                    "note: {} of model \"{}\" stays as it is; --inverse cascade undoes it",
                    ignored.join(", "),
                    file.name
                );
            }
            stage::drive(file, sample_time_s, &reference.values)
        }
    }
}
