//! `hysteron demo`.

use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use clap::Args;

use hysteron_host::dataset::Dataset;
use hysteron_host::error::Error;
use hysteron_host::experiment::demo;
use hysteron_host::identify::{Options, identify};
use hysteron_host::output::OutputFolder;
use hysteron_host::plant::hidden::Protocol;

use super::progress;
use super::say::{self, say};

#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Draws the effect that is hidden, and the stage that has it; if not given, from the clock
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// The folder to write to
    #[arg(long, value_name = "DIR", default_value = OUT)]
    out: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  hysteron demo
  hysteron demo --seed 8 --out out/demo";

const OUT: &str = "out/demo";

impl Default for Arguments {
    fn default() -> Self {
        Self {
            seed: None,
            out: PathBuf::from(OUT),
        }
    }
}

/// Measures a simulated stage, identifies it from the records, drives it along references; hides an
/// effect in another and finds it.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let folder = OutputFolder::create(&arguments.out)?;
    match arguments.seed {
        Some(seed) => show(seed, folder),
        None => {
            let seed = from_the_clock();
            show(seed, folder).map_err(|error| with_seed(error, seed))
        }
    }
}

/// A failure that nobody could bring about again without the seed that was drawn.
fn with_seed(error: Error, seed: u64) -> Error {
    match error {
        Error::Interrupted => error,
        _ => Error::request(format!(
            "{error}; the seed drawn was {seed}, `hysteron demo --seed {seed}` does the same again"
        )),
    }
}

fn show(seed: u64, mut folder: OutputFolder) -> Result<(), Error> {
    let out = folder.path().to_owned();
    let data = out.join("data");
    let mut records = OutputFolder::create(&data)?;
    let steps = progress::steps("demonstration");
    steps.set_message("measuring a simulated stage");
    let measurements = demo::measure()?;
    records.add("dataset.toml", demo::dataset_toml(&measurements))?;
    for measurement in &measurements {
        records.add_columns(
            measurement.file,
            &[
                ("time_s", &measurement.time_s),
                ("drive_v", &measurement.drive_v),
                ("displacement_um", &measurement.displacement_um),
            ],
        )?;
    }
    records.commit()?;

    let dataset = Dataset::load(&data)?;
    let found = identify(&dataset, &Options::default(), &|step| {
        steps.set_message(format!("identifying: {step}"));
    })?;
    steps.set_message("driving the stage");
    let mut shown = demo::drive(found)?;
    let discovery = demo::discover(seed, Protocol::Full, &|step| {
        steps.set_message(format!("an effect is hidden: {step}"));
    })?;
    steps.finish_and_clear();
    let lines = discovery.summary();
    shown.discovery = Some(discovery);

    folder.add("model.toml", shown.found.model.to_toml_string())?;
    folder.add(
        "identification.json",
        format!("{:#}\n", shown.found.to_json()),
    )?;
    let json = shown.to_json();
    folder.add("demo.json", format!("{json:#}\n"))?;
    folder.add("report.html", shown.page().to_html())?;
    folder.commit()?;

    say::figures(&json);
    say!("{}", shown.found.describe_structure());
    say!("largest error (um)            straight line  compensated");
    for tracking in &shown.tracking {
        let [without, with] = tracking.largest_um;
        say!("{:<28} {without:>14.2} {with:>12.2}", tracking.name);
    }
    for line in lines {
        say!("{line}");
    }
    say!(
        "open {} (beside it: model.toml, identification.json, demo.json, data/)",
        out.join("report.html").display()
    );
    Ok(())
}

/// A seed of few digits that another run will not have.
fn from_the_clock() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |time| time.as_millis() as u64 % 1_000_000)
}
