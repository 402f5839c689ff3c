//! `hysteron diagnose`.

use std::path::PathBuf;

use clap::Args;

use hysteron_host::dataset::long;
use hysteron_host::discover::{
    Baseline, Diagnosis, Options, diagnose, localise, next_record, page,
};
use hysteron_host::error::Error;
use hysteron_host::identify::{Effect, whole};
use hysteron_host::model_file::{self, BUILTIN_NAMES};
use hysteron_host::output::OutputFolder;
use hysteron_host::report::format_number;

use super::progress;
use crate::cli::say::{self, say};

/// Find what a baseline model misses of a data set: name the missing effect, add it, show the gap
/// shrink.
///
/// Writes report.html (evidence and plots), model.toml (the extended model) and diagnosis.json, all
/// or none. docs/discovery.md has the method and every key.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A folder with a dataset.toml, or one CSV, .npz or .npy file with time, drive and displacement.
    data: PathBuf,
    /// The folder to write to.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// What the data are held against: rdpi (plays with a rate term), pi (plays alone), or a model of
    /// your own, whose effects are not named again.
    #[arg(long, value_name = "rdpi|pi|MODEL", default_value = "rdpi")]
    baseline: String,
    /// Effects that may not be named, as a list with commas.
    #[arg(long, value_name = "EFFECT,...", value_delimiter = ',', value_parser = effect)]
    without: Vec<Effect>,
    /// Draw so many sets of records without effect to find the bar for a name, instead of half the noise.
    #[arg(long, value_name = "DRAWS", default_value_t = 0, value_parser = draws)]
    bootstrap: usize,
    /// Most samples to work on; at least 4096; longer data sets are condensed, and scored on
    /// every sample at the end.
    #[arg(long, value_name = "N", default_value_t = long::MOST_SAMPLES)]
    samples: usize,
}

const EXAMPLES: &str = "\
Examples:
  hysteron diagnose measured/ --out out/found
  hysteron diagnose measured/ --baseline pi --out out/found
  hysteron diagnose measured/ --baseline out/found/model.toml --out out/more
  hysteron diagnose out/creep/data --without creep --out out/unknown";

fn baseline(text: &str) -> Result<Baseline, Error> {
    match text {
        "rdpi" => Ok(Baseline::RateDependent),
        "pi" => Ok(Baseline::RateIndependent),
        _ if text.ends_with(".toml") || BUILTIN_NAMES.contains(&text) => {
            Ok(Baseline::Model(Box::new(model_file::resolve(text)?)))
        }
        _ => Err(Error::request(format!(
            "there is no such baseline; name rdpi, pi, a model.toml or a built-in model: {}",
            BUILTIN_NAMES.join(", ")
        ))),
    }
}

fn draws(text: &str) -> Result<usize, Error> {
    let count = text
        .parse()
        .ok()
        .filter(|n| *n == 0 || (20..=10_000).contains(n));
    count.ok_or_else(|| Error::request("draw 20 to 10000 sets, or 0 for none".to_owned()))
}

fn effect(text: &str) -> Result<Effect, Error> {
    Effect::named(text).ok_or_else(|| {
        let names: Vec<&str> = Effect::ALL.iter().map(|effect| effect.name()).collect();
        Error::request(format!("no such effect; there are {}", names.join(", ")))
    })
}

/// Diagnoses, writes the folder, prints the figures.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let baseline = baseline(&arguments.baseline)?;
    let mut folder = OutputFolder::create(&arguments.out)?;
    let steps = progress::steps("diagnosing");
    let tell = |step: &str| steps.set_message(step.to_owned());
    let loaded = long::load(&arguments.data, arguments.samples, &tell)?;
    let dataset = &loaded.dataset;
    let allowed = |effect: &Effect| !arguments.without.contains(effect);
    let options = Options {
        baseline,
        library: Effect::ALL.into_iter().filter(allowed).collect(),
        bootstrap: arguments.bootstrap,
    };
    let mut found = diagnose(dataset, &options, &tell)?;
    tell("weighing the next record");
    found.next_record = next_record(&found, dataset);
    if let Some(long) = &loaded.long {
        found.notes.extend(long.notes().iter().cloned());
        let score = |model| whole(long, model, &tell);
        let both = score(&found.baseline_model).and_then(|base| Ok([base, score(&found.model)?]));
        match both {
            Ok(both) => found.whole = Some(both),
            Err(error) => found
                .notes
                .push(format!("Not scored on every sample: {error}")),
        }
    }
    tell("writing the report");
    let places = localise::localise(&found);
    let json = found.to_json(&places);
    let html = page(&found, &places).to_html();
    steps.finish_and_clear();

    folder.add("model.toml", found.model.to_toml_string())?;
    folder.add("diagnosis.json", format!("{json:#}\n"))?;
    folder.add("report.html", html)?;
    folder.commit()?;
    say::figures(&json);
    print_summary(&found, &places);
    say!(
        "written to {}: report.html, model.toml, diagnosis.json",
        arguments.out.display()
    );
    Ok(())
}

fn print_summary(found: &Diagnosis, places: &[localise::Place]) {
    let unit = found.unit.symbol();
    let shown = |um: Option<f64>| match um {
        Some(um) => format_number(found.unit.from_um(um)),
        None => "-".to_owned(),
    };
    say!("{}", found.sentence());
    say!(
        "{:<26} {:>10} {:>10} {:>10}",
        format!("rms residual ({unit})"),
        "fit",
        "select",
        "report"
    );
    for (what, roles) in [
        ("baseline", Some(&found.baseline)),
        ("the same, fitted anew", found.refitted.as_ref()),
        ("extended model", Some(&found.extended)),
    ] {
        let Some(roles) = roles else { continue };
        say!(
            "{what:<26} {:>10} {:>10} {:>10}",
            shown(roles.fit),
            shown(roles.select),
            shown(roles.report)
        );
    }
    if let Some(all) = &found.whole {
        for (what, whole) in ["baseline", "extended"].iter().zip(all) {
            say!(
                "{:<26} {:>10} {:>10} {:>10}",
                format!("{what}, all samples"),
                shown(whole.rms.fit),
                shown(whole.rms.select),
                shown(whole.rms.report)
            );
        }
    }
    say!(
        "{:<26} {:>10}  {}",
        "noise floor",
        shown(Some(found.noise.0)),
        found.noise.1.describe()
    );
    if let Some(place) = places.first() {
        say!("where: {}", place.summary);
    }
    if let Some(next) = &found.next_record {
        say!("next record: {next}");
    }
}
