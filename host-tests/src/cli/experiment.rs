//! `hysteron experiment`.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use hysteron_host::error::Error;
use hysteron_host::experiment::beyond;
use hysteron_host::experiment::j::{self, Plant};
use hysteron_host::experiment::m;
use hysteron_host::output::OutputFolder;
use hysteron_host::report::Page;
use serde_json::Value;

use super::progress;
use crate::cli::say::{self, say};

/// Reproduce a paper's experiments, or go beyond them.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(subcommand)]
    experiment: Experiment,
}

const EXAMPLES: &str = "\
Examples:
  hysteron experiment j --out out/j
  hysteron experiment m --out out/m
  hysteron experiment beyond --out out/beyond";

#[derive(Debug, Subcommand)]
enum Experiment {
    /// Paper J: rate-dependent Prandtl-Ishlinskii model and inverse; writes j.json and report.html.
    J {
        /// The folder to write to.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Paper M: modified play model, its identification and direct inverse multiplication, on a
    /// simulated bimorph; writes m.json and report.html.
    M {
        /// The folder to write to.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
    /// Every compensator over both papers' ranges on plants that none of them was derived from, with
    /// parameters identified and 10 % off, and with feedback; writes beyond.json and report.html.
    Beyond {
        /// The folder to write to.
        #[arg(long, value_name = "DIR")]
        out: PathBuf,
    },
}

/// Runs one experiment.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    match &arguments.experiment {
        Experiment::J { out } => paper_j(out),
        Experiment::M { out } => paper_m(out),
        Experiment::Beyond { out } => beyond_both(out),
    }
}

/// Figures and page of an experiment, both or neither.
fn write(mut folder: OutputFolder, name: &str, figures: &Value, page: &Page) -> Result<(), Error> {
    folder.add(name, format!("{figures:#}\n"))?;
    folder.add("report.html", page.to_html())?;
    folder.commit()?;
    say::figures(figures);
    Ok(())
}

fn paper_j(out: &Path) -> Result<(), Error> {
    let folder = OutputFolder::create(out)?;
    let bar = progress::bar("experiment j", j::PIECES);
    let results = j::run(&|| bar.inc(1))?;
    bar.finish_and_clear();
    write(folder, "j.json", &results.to_json(), &results.page())?;

    say!("hysteresis (%)        model  published");
    for percent in &results.percents {
        say!(
            "{:>5} Hz           {:>8.2} {:>10.2}",
            percent.frequency_hz,
            percent.model,
            percent.published
        );
    }
    say!("largest error (um), 0.05 to 100 Hz       no inverse  rate-independent  rate-dependent");
    for band in &results.bands {
        if let Plant::ModelOwnRate | Plant::StageLagRemoved | Plant::StageWrongLagRemovedMedian =
            band.plant
        {
            let range = |least: f64, most: f64| format!("{least:.2}-{most:.2}");
            say!(
                "{:<38} {:>12} {:>17} {:>15}",
                band.plant.describe(),
                range(band.least.none, band.most.none),
                range(band.least.rate_independent, band.most.rate_independent),
                range(band.least.rate_dependent, band.most.rate_dependent),
            );
        }
    }
    say!("written to {}: report.html, j.json", out.display());
    Ok(())
}

fn paper_m(out: &Path) -> Result<(), Error> {
    let folder = OutputFolder::create(out)?;
    let bar = progress::bar("experiment m", m::PIECES);
    let results = m::run(&|| bar.inc(1))?;
    bar.finish_and_clear();
    write(folder, "m.json", &results.to_json(), &results.page())?;

    let summary = &results.summary;
    let best = &summary.best_in_free_run;
    say!(
        "smallest RMSE in free run, of {} frequencies: proposed {}, without g {}, Bouc-Wen {}",
        m::HIGHEST_HZ,
        best.proposed,
        best.truncated,
        best.bouc_wen,
    );
    say!("rms error (um) of a 50 um sine, compensated   printed law   exact law");
    for at in &results.frequencies {
        if [1.0, 10.0, 20.0, 25.0, 50.0, 74.0, 95.0, 110.0].contains(&at.frequency_hz) {
            let law = &at.proposed;
            let exact = law.exact.as_ref().map_or("refused".to_owned(), |exact| {
                format!("{:.2}", 1e3 * exact.rms_error_mm)
            });
            say!(
                "{:>5} Hz {:>48.2} {exact:>11}",
                at.frequency_hz,
                1e3 * law.printed.rms_error_mm,
            );
        }
    }
    say!("written to {}: report.html, m.json", out.display());
    Ok(())
}

fn beyond_both(out: &Path) -> Result<(), Error> {
    let folder = OutputFolder::create(out)?;
    let frequencies_hz = beyond::paper_m_hz();
    let extent = beyond::Extent {
        against_dim_hz: &frequencies_hz,
        wanted: &|_, _| true,
        feedback_hz: &beyond::feedback::FREQUENCIES_HZ,
    };
    let bar = progress::bar("experiment beyond", extent.pieces());
    let results = beyond::run(&extent, &|| bar.inc(1))?;
    bar.finish_and_clear();
    write(folder, "beyond.json", &results.to_json(), &results.page())?;

    say!("median rms error (um)       identified   10 % off   best   broken     of");
    for standing in &results.standings {
        let figure = |um: Option<f64>| um.map_or("refused".to_owned(), |um| format!("{um:.2}"));
        say!(
            "{:<18}{:<17}{:>3} {:>10} {:>6} {:>8} {:>6}",
            standing.plant.title(),
            standing.compensator.name(),
            figure(standing.median_rms_um),
            figure(standing.median_rms_um_wrong),
            standing.best,
            standing.broken,
            standing.references,
        );
    }
    let found = &results.comparison;
    say!(
        "bimorph, 1 to 110 Hz: the cascade leaves {:.1} times less than DIM (median), at most {:.2} um",
        found.median_ratio,
        1e3 * found.worst_mm,
    );
    say!("written to {}: report.html, beyond.json", out.display());
    Ok(())
}
