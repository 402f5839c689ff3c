//! `hysteron compensate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use hysteron::hysteresis::preview::PlantRate;

use hysteron_host::error::Error;
use hysteron_host::model_file::{self, ModelFile, Stage};
use hysteron_host::output::AtomicFile;
use hysteron_host::signals::{Quantity, Signal, read};
use hysteron_host::stage;

/// Compute the drive that makes a modelled stage follow a reference.
///
/// The drive is the voltage at the actuator. Plays start at zero, or at the nearest admissible state
/// when the first sample is not zero.
///
/// The explicit inverse takes the rate of the reference: backward difference, zero at the first
/// sample. The stage sees that of the drive instead; the preview inverse takes that one, for which it
/// looks some milliseconds ahead in the reference. The drive is in line with the reference all the
/// same.
/// A modified play model is inverted by the law that it names, with the rate of the drive itself, and
/// within its range.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A model.toml, or a built-in model: p753, p753-printed, example-f.
    #[arg(long, value_name = "M")]
    model: String,
    /// CSV, .npz or .npy with the columns time_s and reference_um.
    #[arg(long, value_name = "REF")]
    reference: PathBuf,
    /// File to write, with the columns time_s and drive_v: arrays if it ends in .npz or .npy, else CSV.
    #[arg(long, value_name = "OUT")]
    out: PathBuf,
    /// Which inverse.
    #[arg(long, value_enum, default_value_t)]
    inverse: Inverse,
    /// Which rate of its drive the stage sees, for the preview inverse [default: midpoint].
    #[arg(long, value_enum, value_name = "RATE")]
    plant_rate: Option<Rate>,
}

const EXAMPLES: &str = "\
Examples:
  hysteron compensate --model p753 --reference scan.csv --out drive.csv
  hysteron compensate --model out/stage/model.toml --reference scan.npy --inverse cascade --out drive.npz";

#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Rate {
    /// That of the step to come.
    Forward,
    /// Something between the two: errs on none of them much.
    Midpoint,
    /// That of the step that led there: the drive is joined by straight lines.
    Backward,
}

impl From<Rate> for PlantRate {
    fn from(rate: Rate) -> Self {
        match rate {
            Rate::Forward => Self::Forward,
            Rate::Midpoint => Self::Midpoint,
            Rate::Backward => Self::Backward,
        }
    }
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
    /// The inverse with the rate of the drive itself, from a preview of the reference.
    Preview,
}

/// Reads, compensates, writes.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut file = model_file::resolve(&arguments.model)?;
    if let Inverse::RateIndependent = arguments.inverse {
        file = file.rate_independent();
    }
    let reference = read(&arguments.reference, Quantity::Reference)?;
    let drive = drive(&file, arguments, &reference)?;
    let mut out = AtomicFile::create(&arguments.out)?;
    out.write_columns(&[("time_s", &reference.time_s), ("drive_v", &drive)])?;
    out.commit()
}

fn drive(file: &ModelFile, arguments: &Arguments, reference: &Signal) -> Result<Vec<f64>, Error> {
    let (h, values) = (reference.sample_time_s, &reference.values);
    if arguments.plant_rate.is_some() && !matches!(arguments.inverse, Inverse::Preview) {
        return Err(Error::request(
            "--plant-rate is for the preview inverse; add --inverse preview or leave it out",
        ));
    }
    let cascade = matches!(arguments.inverse, Inverse::Cascade);
    let left = |inverted: bool| {
        let stages = file.effects().filter(|stage| stage.inverted() == inverted);
        let names: Vec<&str> = stages.map(Stage::name).collect();
        (!names.is_empty()).then(|| names.join(", "))
    };
    if let Some(left) = left(true).filter(|_| !cascade) {
        eprintln!(
            "note: {left} of model \"{}\" stays as it is; --inverse cascade undoes it",
            file.name
        );
    }
    if let Some(left) = left(false) {
        eprintln!(
            "note: {left} of model \"{}\" stays as it is; no inverse undoes it",
            file.name
        );
    }
    match arguments.inverse {
        Inverse::Cascade => stage::drive_ahead(file, h, values),
        Inverse::Preview => {
            let rate = arguments
                .plant_rate
                .map_or(PlantRate::Midpoint, PlantRate::from);
            let compensator = stage::preview_compensator(file, h, rate)?;
            stage::compensate_ahead(&compensator, values).map_err(|refused| {
                Error::request(format!("{}: {refused}", arguments.reference.display()))
            })
        }
        Inverse::Dim if file.modified_play().is_none() => Err(Error::request(format!(
            "model \"{}\" has no stage modified-play, which dim needs; use another --inverse",
            file.name
        ))),
        Inverse::Explicit | Inverse::RateIndependent | Inverse::Dim => {
            stage::drive(file, h, values)
        }
    }
}
