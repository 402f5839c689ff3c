//! `hysteron blind`.

use std::path::PathBuf;

use clap::Args;

use hysteron_host::discover::blind::{self, Blind, Plan, Range, Share};
use hysteron_host::error::Error;
use hysteron_host::output::OutputFolder;
use hysteron_host::plant::hidden::{Protocol, Tier};

use super::{hide, progress};
use crate::cli::say::{self, say};

/// Hide effects in simulated data, diagnose them, and hold the answers against the truth.
///
/// Works on all cores, a case a core, and writes DIR/blind.json and DIR/report.html: confusion matrix,
/// false names, size of the ambiguity set, detection curve, gap closed, time, and every failure with
/// the command that repeats it. docs/blind.md defines the figures.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Number of cases.
    #[arg(long, value_name = "K", default_value = "40")]
    cases: usize,
    /// How far the truth is from the models, 1 (same structure) to 4 (another family).
    #[arg(long, value_name = "T", default_value = "1", value_parser = hide::tier)]
    tier: Tier,
    /// Seed of the first case; each further case has the next one.
    #[arg(long, value_name = "S", default_value = "1", value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: u64,
    /// Rms of the noise, percent of the stroke: a value, or two as LOW..HIGH to draw between.
    #[arg(long, value_name = "P", default_value = "0.02..0.5")]
    noise: Range,
    /// Size of each effect, percent of the stroke, a value or two as LOW..HIGH; if not given, from
    /// three times the noise, at least 0.3, to 3.
    #[arg(long, value_name = "X")]
    strength: Option<Range>,
    /// Effects in a case: 1, each of the library in turn; more, drawn at random.
    #[arg(long, value_name = "N", default_value = "1")]
    effects: usize,
    /// What is recorded: full, sines, slow or random.
    #[arg(long, value_name = "NAME", default_value = "full")]
    protocol: Protocol,
    /// Share of cases without effect, 0 to 1.
    #[arg(long, value_name = "SHARE", default_value = "0.1")]
    none_share: f64,
    /// Diagnose each case once more without the template of its effect; takes twice the time.
    #[arg(long)]
    leave_out: bool,
    /// The folder to write to.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  hysteron blind --cases 40 --tier 1 --out out/blind
  hysteron blind --cases 300 --tier 3 --none-share 1 --out out/none
  hysteron blind --cases 40 --tier 2 --effects 2 --noise 0.05 --strength 0.5..2 --out out/pairs
  hysteron blind --cases 72 --tier 3 --leave-out --out out/left-out";

/// Hides, diagnoses, scores, writes.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut folder = OutputFolder::create(&arguments.out)?;
    let plan = Plan {
        cases: arguments.cases,
        tier: arguments.tier,
        seed: arguments.seed,
        noise: arguments.noise,
        strength: arguments.strength,
        effects: arguments.effects,
        protocol: arguments.protocol,
        none_share: arguments.none_share,
        leave_out: arguments.leave_out,
    };
    let bar = progress::bar("blind trials", plan.cases as u64);
    let found = blind::run(&plan, &|| bar.inc(1))?;
    bar.finish_and_clear();
    let json = found.to_json()?;
    folder.add("blind.json", format!("{json:#}\n"))?;
    folder.add("report.html", found.page().to_html())?;
    folder.commit()?;
    say::figures(&json);
    summary(&found);
    say!(
        "written to {}: report.html, blind.json",
        arguments.out.display()
    );
    Ok(())
}

fn summary(found: &Blind) {
    let scores = &found.scores;
    let line = |what: &str, share: Share| {
        if let Some(rate) = share.rate() {
            let Share { count, of } = share;
            say!("{what:<40} {count:>5} of {of:<5} {:>5.1} %", 1e2 * rate);
        }
    };
    line("effects that must be found", scores.revealed);
    line("  named, truth first", scores.top_1);
    line("  truth in the set", scores.in_set);
    line("  all named and nothing else", scores.exact);
    line("  flagged without the template", scores.flagged);
    line("no effect: something named", scores.false_names);
    line("no effect: unknown", scores.false_alarms);
    line("diagnoses that failed", scores.errors);
    if let Some(size) = scores.mean_set_size {
        say!("{:<40} {size:>8.2}", "mean size of the set");
    }
    if let Some(closed) = scores.closed {
        say!("{:<40} {:>8.3}", "gap closed, median", closed.median);
    }
    if let Some(seconds) = scores.seconds {
        say!(
            "{:<40} {:>8.2} s, at most {:.2} s",
            "processor time of a case, median",
            seconds.median,
            seconds.largest
        );
    }
}
