//! `hysteron pil`.

use std::path::{Path, PathBuf};

use clap::Args;

use hysteron::hysteresis::preview::PlantRate;
use hysteron_host::error::Error;
use hysteron_host::interrupt;
use hysteron_host::link::model::Choice;
use hysteron_host::model_file::{self, ModelFile};
use hysteron_host::output::OutputFolder;
use hysteron_host::pil::{
    self, Bench, Compared, Comparison, Emulator, Hardware, Listener, experiment,
};
use hysteron_host::plant::Stage;
use hysteron_host::signals::{Quantity, read};

use super::link::note_left_out;
use super::progress;
use crate::cli::say::{self, say};

/// Run the firmware in an emulator around a simulated stage.
///
/// Builds the firmware where that is needed, plays paper J's references with and without
/// compensation, compares every sample with the host's own computation and writes pil.json and
/// report.html. Needs qemu-system-arm and a compiler for thumbv7em-none-eabihf.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The folder to write to.
    #[arg(long, value_name = "DIR", default_value = "out/pil")]
    out: PathBuf,
    /// A firmware built with the feature qemu, instead of building it.
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// No experiment: a stage to practise on with `hysteron link`, at tcp:HOST:PORT or unix:PATH.
    #[arg(long, value_name = "PORT", conflicts_with_all = ["out", "model"])]
    serve: Option<String>,
    /// Another experiment: the compensators of this model and of --extended along --reference, on the
    /// stage that --plant describes. Each is a cascade where the model has effects, else preview.
    #[arg(long, value_name = "M", requires_all = ["extended", "reference"])]
    model: Option<String>,
    /// The model with what --model lacks.
    #[arg(long, value_name = "M", requires = "model")]
    extended: Option<String>,
    /// The model that is the stage, stepped at 10 kHz [default: that of --extended].
    #[arg(long, value_name = "M", requires = "model")]
    plant: Option<String>,
    /// CSV with the columns time_s and reference_um, 10 kHz.
    #[arg(long, value_name = "REF.csv", requires = "model")]
    reference: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  hysteron pil --out out/pil
  hysteron pil --serve tcp:127.0.0.1:5000
  hysteron pil --model out/stage/model.toml --extended out/found/model.toml --reference scan.csv";

/// Builds, runs, writes; or serves until Ctrl-C.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let steps = progress::steps("processor in the loop");
    let firmware = match &arguments.firmware {
        Some(firmware) => firmware.clone(),
        None => {
            steps.set_message("building the firmware");
            pil::build()?
        }
    };
    if let Some(port) = &arguments.serve {
        steps.finish_and_clear();
        return serve(port, &firmware);
    }
    let mut folder = OutputFolder::create(&arguments.out)?;
    if let (Some(model), Some(extended), Some(reference)) =
        (&arguments.model, &arguments.extended, &arguments.reference)
    {
        steps.set_message("comparing");
        let plant = arguments.plant.as_ref().unwrap_or(extended);
        let compared = compare(&firmware, [model, extended, plant], reference)?;
        steps.finish_and_clear();
        let json = compared.to_json();
        folder.add("pil.json", format!("{json:#}\n"))?;
        folder.add("report.html", pil::comparison_page(&compared).to_html())?;
        folder.commit()?;
        say::figures(&json);
        return told(&compared, &arguments.out);
    }
    let outcome = experiment::run(&firmware, &|step| steps.set_message(step.to_owned()))?;
    steps.finish_and_clear();
    let json = outcome.to_json();
    folder.add("pil.json", format!("{json:#}\n"))?;
    folder.add("report.html", pil::page(&outcome).to_html())?;
    folder.commit()?;
    say::figures(&json);

    say!(
        "{:<24} {:>12} {:>12}",
        "largest error (um)",
        "without",
        "with"
    );
    for one in &outcome.followed {
        say!(
            "{:<24} {:>12.3} {:>12.3}",
            one.input.name,
            one.without.max_um,
            one.with.max_um
        );
    }
    let (min, median, max) = outcome.instruction_range();
    say!("instructions of a sample: {min} to {max}, median {median}");
    say!(
        "written to {}: pil.json, report.html",
        arguments.out.display()
    );
    agreed(
        outcome.first_difference.as_deref(),
        outcome.samples,
        "; see report.html",
    )
}

/// For the names of three models: baseline, extended, plant.
fn compare(
    firmware: &Path,
    [model, extended, plant]: [&String; 3],
    reference: &Path,
) -> Result<Compared, Error> {
    let hardware = Hardware::paper_j()?;
    let files = [model, extended, plant].map(|name| model_file::resolve(name));
    let [model, extended, plant] = files;
    let (model, extended, plant) = (model?, extended?, plant?);
    let signal = read(reference, Quantity::Reference)?;
    let sample_time_s = hardware.sample_time_s();
    if (signal.sample_time_s / sample_time_s - 1.0).abs() > 1e-4 {
        return Err(Error::request(format!(
            "{}: has a sample every {} s and the firmware here every {sample_time_s} s; resample it",
            reference.display(),
            signal.sample_time_s
        )));
    }
    let choice = |file: &ModelFile| match (file.modified_play(), file.effects().next()) {
        (Some(_), _) => Choice::Dim,
        (None, Some(_)) => Choice::Cascade(PlantRate::Midpoint),
        (None, None) => Choice::Preview(PlantRate::Midpoint),
    };
    let comparison = Comparison {
        name: &extended.name,
        baseline: (&model, choice(&model)),
        extended: (&extended, choice(&extended)),
        hardware,
        reference_um: &signal.values,
        skipped: 0,
    };
    pil::compare(firmware, &comparison, &|| {
        pil::model_plant(&plant, sample_time_s)
    })
}

fn told(compared: &Compared, out: &Path) -> Result<(), Error> {
    say!(
        "{:<24} {:>9} {:>12} {:>12} {:>9} {:>13}",
        "model",
        "inverse",
        "largest (um)",
        "rms (um)",
        "latency",
        "instructions"
    );
    for one in [&compared.baseline, &compared.extended] {
        say!(
            "{:<24} {:>9} {:>12.3} {:>12.3} {:>9} {:>13}",
            one.model,
            one.inverse,
            one.error.max_um,
            one.error.rms_um,
            one.latency,
            one.instructions.2
        );
        note_left_out(&one.left_out, &one.model);
    }
    say!("written to {}: pil.json, report.html", out.display());
    agreed(
        compared.first_difference.as_deref(),
        compared.samples,
        "; see report.html",
    )
}

/// What host and firmware had in common.
fn agreed(difference: Option<&str>, samples: u64, see: &str) -> Result<(), Error> {
    match difference {
        None => {
            say!("firmware and host agree bit for bit in {samples} samples");
            Ok(())
        }
        Some(difference) => Err(Error::request(format!(
            "firmware and host do not agree: {difference}{see}"
        ))),
    }
}

fn serve(port: &str, firmware: &Path) -> Result<(), Error> {
    let hardware = Hardware::paper_j()?;
    let mut bench = Bench::new(Emulator::start(firmware)?, hardware, &Stage::p753())?;
    let _deferred = interrupt::Deferred::begin();
    let listener = Listener::bind(port)?;
    say::figures(&serde_json::json!({ "address": listener.name() }));
    say!(
        "a simulated stage at {}, 10 kHz; settings that fit it:\n\n{}\nCtrl-C ends it",
        listener.name(),
        hysteron_host::link::settings::to_toml(&hardware.settings)?
    );
    pil::serve(&listener, &mut bench, &mut |_| interrupt::requested())
}
