//! `hysteron pil`.

use std::path::PathBuf;

use clap::Args;

use hysteron_host::error::Error;
use hysteron_host::interrupt;
use hysteron_host::output::OutputFolder;
use hysteron_host::pil::{self, Bench, Emulator, Hardware, Listener, experiment};
use hysteron_host::plant::Stage;

use super::progress;

/// Run the firmware in an emulator around a simulated stage.
///
/// Builds the firmware where that is needed, plays paper J's references with and without
/// compensation, compares every sample with the host's own computation and writes pil.json and
/// report.html. Needs qemu-system-arm and a compiler for thumbv7em-none-eabihf.
#[derive(Debug, Args)]
pub struct Arguments {
    /// The folder to write to.
    #[arg(long, value_name = "DIR", default_value = "out/pil")]
    out: PathBuf,
    /// A firmware built with the feature qemu, instead of building it.
    #[arg(long, value_name = "ELF")]
    firmware: Option<PathBuf>,
    /// No experiment: a stage to practise on with `hysteron link`, at tcp:HOST:PORT or unix:PATH.
    #[arg(long, value_name = "PORT", conflicts_with = "out")]
    serve: Option<String>,
}

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
    let outcome = experiment::run(&firmware, &|step| steps.set_message(step.to_owned()))?;
    steps.finish_and_clear();
    folder.add("pil.json", format!("{:#}\n", outcome.to_json()))?;
    folder.add("report.html", pil::page(&outcome).to_html())?;
    folder.commit()?;

    println!(
        "{:<24} {:>12} {:>12}",
        "largest error (um)", "without", "with"
    );
    for one in &outcome.followed {
        println!(
            "{:<24} {:>12.3} {:>12.3}",
            one.input.name, one.without.max_um, one.with.max_um
        );
    }
    let (min, median, max) = outcome.instruction_range();
    println!("instructions of a sample: {min} to {max}, median {median}");
    println!(
        "written to {}: pil.json, report.html",
        arguments.out.display()
    );
    match outcome.first_difference {
        None => {
            println!(
                "firmware and host agree bit for bit in {} samples",
                outcome.samples
            );
            Ok(())
        }
        Some(difference) => Err(Error::request(format!(
            "firmware and host do not agree: {difference}; see report.html"
        ))),
    }
}

fn serve(port: &str, firmware: &std::path::Path) -> Result<(), Error> {
    let hardware = Hardware::paper_j()?;
    let mut bench = Bench::new(Emulator::start(firmware)?, hardware, &Stage::p753())?;
    let _deferred = interrupt::Deferred::begin();
    let listener = Listener::bind(port)?;
    println!(
        "a simulated stage at {}, 10 kHz; settings that fit it:\n\n{}\nCtrl-C ends it",
        listener.name(),
        hysteron_host::link::settings::to_toml(&hardware.settings)?
    );
    pil::serve(&listener, &mut bench, &mut |_| interrupt::requested())
}
