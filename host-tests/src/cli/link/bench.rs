//! What is known about the bench: identity, settings, model.

use std::path::Path;

use hysteron::dim::Law;
use hysteron::link::{Command, Identity};
use hysteron::record::{ModelRecord, Stage};
use hysteron_host::error::Error;
use hysteron_host::link::{self, Client};
use hysteron_host::model_file;

use super::watch;

/// Prints who is there.
pub fn info(client: &mut Client<'_>, identity: &Identity) -> Result<(), Error> {
    let [major, minor, patch] = identity.firmware;
    println!("firmware        {major}.{minor}.{patch}");
    println!(
        "room for        {} plays, {} dead zones on a side, {} samples of a stream",
        identity.plays, identity.dead_zones, identity.stream
    );
    let model = client.model()?;
    println!(
        "model           {}",
        model.map_or("none".to_owned(), describe)
    );
    let settings = client.settings()?;
    println!("sample rate     {} Hz", settings.sample_rate_hz);
    println!(
        "drive           {} V to {} V, rest {} V",
        settings.drive_min_v, settings.drive_max_v, settings.drive_rest_v
    );
    let statistics = client.statistics()?;
    for (name, value) in watch::fields(&statistics, &settings)? {
        println!("{name:<15} {}", watch::text(&value));
    }
    Ok(())
}

/// Prints the settings, or changes them and reads them back.
pub fn settings(client: &mut Client<'_>, file: Option<&Path>) -> Result<(), Error> {
    let now = client.settings()?;
    let Some(file) = file else {
        print!("{}", link::settings::to_toml(&now)?);
        return Ok(());
    };
    let wanted = link::settings::load(file, &now)?;
    client.tell(Command::SetSettings(wanted))?;
    if client.settings()? != wanted {
        return Err(Error::request(
            "the target keeps other settings than were sent; flash the firmware of this program's \
             version",
        ));
    }
    println!("settings in force, until the target is switched off");
    Ok(())
}

/// Sends a model and reads it back.
pub fn upload(client: &mut Client<'_>, name: &str) -> Result<(), Error> {
    let file = model_file::resolve(name)?;
    let record = link::model::record(&file, &client.settings()?)?;
    client.tell(Command::SetModel(Some(record.clone())))?;
    if client.model()?.as_ref() != Some(&record) {
        return Err(Error::request(
            "the target keeps another model than was sent; flash the firmware of this program's \
             version",
        ));
    }
    println!("model \"{}\" in force: {}", file.name, describe(record));
    Ok(())
}

fn describe(model: ModelRecord) -> String {
    let stages: Vec<_> = model
        .stages
        .iter()
        .map(|stage| match stage {
            Stage::Hysteresis { thresholds_v, .. } => format!("{} plays", thresholds_v.len()),
            Stage::Asymmetry { positive, negative } => format!(
                "asymmetry of {} and {} dead zones",
                positive.thresholds.len(),
                negative.thresholds.len()
            ),
            Stage::Output { gain_um_per_v, .. } => format!("gain {gain_um_per_v} um/V"),
            Stage::ModifiedPlay {
                slopes_um_per_v,
                frequency_hz,
                law,
                ..
            } => format!(
                "modified play, N = {}, {frequency_hz} Hz, DIM {}",
                slopes_um_per_v.len(),
                match law {
                    Law::Printed => "as printed",
                    Law::Exact => "exact",
                }
            ),
        })
        .collect();
    stages.join(", ")
}
