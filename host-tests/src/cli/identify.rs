//! `hysteron identify`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use hysteron_host::dataset::long;
use hysteron_host::error::Error;
use hysteron_host::identify::{
    Effect, Identification, Options, RecordWeights, Thresholds, identify, page, whole,
};
use hysteron_host::output::OutputFolder;
use hysteron_host::report::format_number;

use super::progress;
use crate::cli::say::{self, say};

/// Fit a rate-dependent Prandtl-Ishlinskii model to a data set.
///
/// Writes model.toml (the model), identification.json (figures) and report.html (plots).
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// A folder with a dataset.toml, or one CSV, .npz or .npy file with time, drive and displacement.
    data: PathBuf,
    /// The folder to write to.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Number of plays; chosen on the select records when not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=64))]
    plays: Option<u16>,
    /// Thresholds: multiples of one spacing, each on its own, or whichever explains more.
    #[arg(long, value_enum, default_value_t)]
    thresholds: ThresholdsChoice,
    /// Rate term: fitted where the records show it, always, or never.
    #[arg(long, value_enum, default_value_t)]
    beta: Choice,
    /// Asymmetry map: added where it helps, or never.
    #[arg(long, value_enum, default_value_t)]
    asymmetry: Asymmetry,
    /// Weight of the records: the same for all, or by hysteresis percent as in paper J.
    #[arg(long, value_enum, default_value_t)]
    record_weights: Weights,
    /// Effects to fit together with the hysteresis, as a list with commas.
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LIST")]
    effects: Vec<EffectChoice>,
    /// Most samples to work on; at least 4096; longer data sets are condensed, and scored on
    /// every sample at the end.
    #[arg(long, value_name = "N", default_value_t = long::MOST_SAMPLES)]
    samples: usize,
}

const EXAMPLES: &str = "\
Examples:
  hysteron identify measured/ --out out/stage
  hysteron identify record.csv --plays 8 --out out/eight
  hysteron identify measured/ --effects resonance,amplifier-lag --out out/stage";

#[derive(Clone, Copy, Debug, ValueEnum)]
enum EffectChoice {
    AmplifierLag,
    TransportDelay,
    Quadratic,
    Cubic,
    Resonance,
    Creep,
    OutputQuadratic,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum ThresholdsChoice {
    #[default]
    Auto,
    Spaced,
    Free,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Choice {
    #[default]
    Auto,
    Fit,
    Zero,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Asymmetry {
    #[default]
    Auto,
    None,
}

#[derive(Clone, Copy, Debug, Default, ValueEnum)]
enum Weights {
    #[default]
    Equal,
    Hysteresis,
}

impl From<EffectChoice> for Effect {
    fn from(choice: EffectChoice) -> Self {
        match choice {
            EffectChoice::AmplifierLag => Self::AmplifierLag,
            EffectChoice::TransportDelay => Self::TransportDelay,
            EffectChoice::Quadratic => Self::Quadratic,
            EffectChoice::Cubic => Self::Cubic,
            EffectChoice::Resonance => Self::Resonance,
            EffectChoice::Creep => Self::Creep,
            EffectChoice::OutputQuadratic => Self::OutputQuadratic,
        }
    }
}

impl Arguments {
    fn options(&self) -> Options {
        Options {
            plays: self.plays.map(usize::from),
            thresholds: match self.thresholds {
                ThresholdsChoice::Auto => None,
                ThresholdsChoice::Spaced => Some(Thresholds::Spaced),
                ThresholdsChoice::Free => Some(Thresholds::Free),
            },
            beta: match self.beta {
                Choice::Auto => None,
                Choice::Fit => Some(true),
                Choice::Zero => Some(false),
            },
            asymmetry: matches!(self.asymmetry, Asymmetry::Auto),
            weights: match self.record_weights {
                Weights::Equal => RecordWeights::Equal,
                Weights::Hysteresis => RecordWeights::Hysteresis,
            },
            effects: self.effects.iter().map(|&effect| effect.into()).collect(),
        }
    }
}

/// Identifies, writes the folder, prints the figures.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut folder = OutputFolder::create(&arguments.out)?;
    let steps = progress::steps("identifying");
    let tell = |step: &str| steps.set_message(step.to_owned());
    let loaded = long::load(&arguments.data, arguments.samples, &tell)?;
    let mut found = identify(&loaded.dataset, &arguments.options(), &tell)?;
    if let Some(long) = &loaded.long {
        found.condensed = long.notes().to_vec();
        match whole(long, &found.model, &tell) {
            Ok(all) => found.whole = Some(all),
            Err(error) => found
                .condensed
                .push(format!("Not scored on every sample: {error}")),
        }
    }
    steps.finish_and_clear();

    folder.add("model.toml", found.model.to_toml_string())?;
    let json = found.to_json();
    folder.add("identification.json", format!("{json:#}\n"))?;
    folder.add("report.html", page(&found).to_html())?;
    folder.commit()?;
    say::figures(&json);
    print_summary(&found);
    say!(
        "written to {}: model.toml, identification.json, report.html",
        arguments.out.display()
    );
    Ok(())
}

fn print_summary(found: &Identification) {
    let unit = found.unit.symbol();
    let shown = |um: Option<f64>| match um {
        Some(um) => format_number(found.unit.from_um(um)),
        None => "-".to_owned(),
    };
    let row = |what: &str, fit, select, report| {
        say!(
            "{what:<26} {:>10} {:>10} {:>10}",
            shown(fit),
            shown(select),
            shown(report)
        );
    };
    say!(
        "{:<26} {:>10} {:>10} {:>10}",
        format!("rms residual ({unit})"),
        "fit",
        "select",
        "report"
    );
    row(
        "straight line",
        found.line_rms.fit,
        found.line_rms.select,
        found.line_rms.report,
    );
    row("model", found.rms.fit, found.rms.select, found.rms.report);
    if let Some(whole) = &found.whole {
        let what = format!("on all {} samples", whole.samples);
        row(&what, whole.rms.fit, whole.rms.select, whole.rms.report);
    }
    if let Some((noise, source)) = found.noise {
        say!(
            "{:<26} {:>10}  {}",
            "noise floor",
            shown(Some(noise)),
            source.describe()
        );
    }
    for note in &found.condensed {
        say!("{note}");
    }
    say!("{}", found.describe_structure());
}
