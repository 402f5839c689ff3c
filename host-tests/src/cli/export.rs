//! `hysteron export`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use hysteron_host::error::Error;
use hysteron_host::export::{Language, Options, Precision, export};
use hysteron_host::model_file;
use hysteron_host::output::AtomicFile;

use super::say::say;

/// Write a model as source code for a firmware of your own.
///
/// The file stands alone: coefficients, the model from drive to displacement and its explicit inverse.
/// Saturation, asymmetry and curvatures go with the hysteresis; any other stage is refused by name
/// unless --as-constants says that its numbers will do. docs/interchange.md has the functions.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A model.toml, or a built-in model: p753, p753-printed, example-f.
    #[arg(long, value_name = "M")]
    model: String,
    /// The language.
    #[arg(long, value_enum)]
    format: Format,
    /// Samples a second of the firmware, in Hz.
    #[arg(long, value_name = "HZ")]
    sample_rate: f64,
    /// The file to write.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// The floating-point type.
    #[arg(long, value_enum, default_value_t)]
    precision: Width,
    /// What names in C begin with.
    #[arg(long, value_name = "NAME", default_value = "hysteron")]
    prefix: String,
    /// Stages of which only the numbers are written, as a list with commas.
    #[arg(long, value_name = "STAGE,...", value_delimiter = ',')]
    as_constants: Vec<String>,
}

const EXAMPLES: &str = "\
Examples:
  hysteron export --model p753 --format c --sample-rate 10000 --out stage.h
  hysteron export --model out/stage/model.toml --format rust --sample-rate 20000 --out stage.rs
  hysteron export --model creeping.toml --format c --sample-rate 1000 --as-constants creep --out stage.h";

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Format {
    /// A header in C99.
    C,
    /// A module without std.
    Rust,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Width {
    /// 32 bits.
    #[default]
    Single,
    /// 64 bits.
    Double,
}

/// Writes the file.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let file = model_file::resolve(&arguments.model)?;
    if !(arguments.sample_rate > 0.0 && arguments.sample_rate.is_finite()) {
        return Err(Error::request(format!(
            "--sample-rate {} is no rate; give samples a second, more than 0",
            arguments.sample_rate
        )));
    }
    let options = Options {
        language: match arguments.format {
            Format::C => Language::C,
            Format::Rust => Language::Rust,
        },
        sample_time_s: 1.0 / arguments.sample_rate,
        precision: match arguments.precision {
            Width::Single => Precision::Single,
            Width::Double => Precision::Double,
        },
        prefix: arguments.prefix.clone(),
        as_constants: arguments.as_constants.clone(),
    };
    let text = export(&file, &options)?;
    let mut out = AtomicFile::create(&arguments.out)?;
    out.write_bytes(text.as_bytes())?;
    out.commit()?;
    say!("written to {}", arguments.out.display());
    Ok(())
}
