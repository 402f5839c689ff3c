//! `hysteron faults`.

use std::path::PathBuf;

use clap::Args;

use hysteron_host::campaign::{self, Outcome};
use hysteron_host::error::Error;
use hysteron_host::output::OutputFolder;
use hysteron_host::pil::{Emulator, Pair, Replica};

use super::progress;
use crate::cli::say::{self, say};

/// Inject faults into the firmware's control, safety and link, and judge all that comes of them.
///
/// Each run starts from power-on and injects every kind of fault in any order; docs/faults.md has the
/// kinds. Writes DIR/faults.json and DIR/report.html. What must hold and did not is told with the
/// command that repeats it, and the exit code is 2.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Number of runs, of some ninety faults each.
    #[arg(long, value_name = "N", default_value = "110", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    runs: u64,
    /// Seed of the first run; each further run has the next one.
    #[arg(long, value_name = "S", default_value = "1", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: u64,
    /// A firmware built with the feature qemu: in the emulator, too, compared with the host in every
    /// sample, with a forced panic and hard fault in each run. Slow.
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// The folder to write to.
    #[arg(long, value_name = "DIR", default_value = "out/faults")]
    out: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  hysteron faults --out out/faults
  hysteron faults --runs 1000 --seed 5000 --out out/more
  hysteron faults --runs 1 --seed 17 --out out/again
  hysteron faults --runs 4 --firmware firmware.elf --out out/emulated";

/// Injects, judges, writes.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut folder = OutputFolder::create(&arguments.out)?;
    let bar = progress::bar("runs", arguments.runs);
    let done = || bar.inc(1);
    let outcome = match &arguments.firmware {
        None => campaign::on_host(arguments.seed, arguments.runs, &done)?,
        Some(elf) => {
            let start = || Ok(Pair::new(Emulator::start(elf)?, Replica::power_on()?));
            campaign::emulated(&start, arguments.seed, arguments.runs, &done)?
        }
    };
    bar.finish_and_clear();
    let json = outcome.to_json();
    folder.add("faults.json", format!("{json:#}\n"))?;
    folder.add("report.html", campaign::page(&outcome).to_html())?;
    folder.commit()?;
    say::figures(&json);
    for row in &outcome.rows {
        say!("{:<76} {:>7}", row.name, row.injected);
    }
    say!(
        "{} faults of {} kinds; {} samples judged",
        outcome.injected(),
        outcome.rows.len(),
        outcome.samples
    );
    say!(
        "written to {}: report.html, faults.json",
        arguments.out.display()
    );
    verdict(&outcome, arguments)
}

/// The first thing that did not hold, with the command that repeats it.
fn verdict(outcome: &Outcome, arguments: &Arguments) -> Result<(), Error> {
    let Some(first) = outcome.failures.first() else {
        return Ok(());
    };
    let firmware = arguments
        .firmware
        .as_ref()
        .map_or_else(String::new, |elf| format!(" --firmware {}", elf.display()));
    Err(Error::request(format!(
        "{} of {} runs broke; the first at {}: {}; repeat it by 'hysteron faults --seed {} --runs \
         1{firmware}'",
        outcome.failures.len(),
        outcome.runs,
        first.fault,
        first.what,
        first.seed
    )))
}
