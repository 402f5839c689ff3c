//! `hysteron hide`.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use hysteron_host::error::Error;
use hysteron_host::output::OutputFolder;
use hysteron_host::plant::hidden::{Choice, HiddenCase, Protocol, Tier};

use crate::cli::say::{self, say};

/// Hide an effect in simulated data.
///
/// Writes DIR/data, a data set of a stage drawn by the seed, and beside it DIR/truth.toml, which says
/// what is hidden in it. The diagnosis reads DIR/data alone. docs/hidden-data.md has the equations.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// none, random, random,N for N of them, or names joined by commas.
    #[arg(long, value_name = "NAME")]
    effect: Choice,
    /// Seed of everything random.
    #[arg(long, value_name = "S", default_value = "1", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: u64,
    /// How far the truth is from the models, 1 (same structure) to 4 (another family).
    #[arg(long, value_name = "T", default_value = "1", value_parser = tier)]
    tier: Tier,
    /// Size of each effect, percent of the stroke.
    #[arg(long, value_name = "X", default_value = "1")]
    strength: f64,
    /// Rms of the noise, percent of the stroke.
    #[arg(long, value_name = "P", default_value = "0.1")]
    noise: f64,
    /// What is recorded: full, sines, slow or random.
    #[arg(long, value_name = "NAME", default_value = "full")]
    protocol: Protocol,
    /// Whether the stage has a rate term before anything is hidden; drawn by the seed where not said.
    #[arg(long, value_name = "true|false")]
    rate_term: Option<bool>,
    /// The folder to write to.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

const EXAMPLES: &str = "\
Effects: saturation, slew-limit, amplifier-lag, transport-delay, rate-dependence, rate-law,
congruency, asymmetry, quadratic, cubic, backlash, resonance, creep, interleaving, sensor-lag,
drift, mains-hum, quantisation.

Examples:
  hysteron hide --effect creep --seed 3 --out out/creep
  hysteron hide --effect random,2 --seed 4 --tier 3 --strength 0.5 --noise 0.05 --out out/two
  hysteron hide --effect none --seed 5 --protocol sines --out out/none";

/// A tier by its number.
pub fn tier(text: &str) -> Result<Tier, Error> {
    let number: u8 = text
        .parse()
        .map_err(|_| Error::request(format!("\"{text}\" is no tier; name 1 to 4")))?;
    Tier::try_from(number)
}

/// Draws, simulates, writes.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut folder = OutputFolder::create(&arguments.out)?;
    let hidden = HiddenCase {
        choice: arguments.effect.clone(),
        seed: arguments.seed,
        tier: arguments.tier,
        strength: arguments.strength,
        noise_percent: arguments.noise,
        protocol: arguments.protocol,
        rate_term: arguments.rate_term,
    }
    .make()?;
    hidden.add_to(&mut folder)?;
    folder.commit()?;
    let samples: usize = hidden
        .dataset
        .records
        .iter()
        .map(|one| one.drive_v.len())
        .sum();
    say!(
        "{} records, {samples} samples; written to {}: data, truth.toml",
        hidden.dataset.records.len(),
        arguments.out.display()
    );
    say::figures(&json!({
        "records": hidden.dataset.records.len(),
        "samples": samples,
        "effects": hidden.truth.effects,
        "written_to": arguments.out,
    }));
    for effect in hidden.truth.details.iter().filter(|one| one.bounded) {
        say!(
            "one effect has reached its bound at {:.3} percent of the stroke instead of {}",
            effect.strength,
            arguments.strength
        );
    }
    Ok(())
}
