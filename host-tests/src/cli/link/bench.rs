//! What is known about the bench: identity, settings, model.

use std::path::Path;

use clap::{Args, ValueEnum};
use serde_json::json;

use hysteron::dim::Law;
use hysteron::hysteresis::preview::PlantRate;
use hysteron::link::{Command, Identity};
use hysteron::record::{self, ModelRecord};
use hysteron::settings::Settings;
use hysteron::store::Kept;
use hysteron_host::error::Error;
use hysteron_host::link::model::{Choice, Prepared};
use hysteron_host::link::{self, Client};
use hysteron_host::model_file::{self, ModelFile, Stage};

use super::{note_left_out, watch};
use crate::cli::compensate::Rate;
use crate::cli::say::{self, say};

/// Prints who is there.
pub fn info(client: &mut Client<'_>, identity: &Identity) -> Result<(), Error> {
    let [major, minor, patch] = identity.firmware;
    say!("firmware        {major}.{minor}.{patch}");
    say!(
        "room for        {} plays, {} dead zones on a side, {} samples of a stream, {} of a preview",
        identity.plays,
        identity.dead_zones,
        identity.stream,
        identity.window
    );
    let model = client.model()?;
    say!(
        "model           {}",
        model.as_ref().map_or("none".to_owned(), describe)
    );
    let settings = client.settings()?;
    say!("sample rate     {} Hz", settings.sample_rate_hz);
    say!(
        "drive           {} V to {} V, rest {} V",
        settings.drive_min_v,
        settings.drive_max_v,
        settings.drive_rest_v
    );
    let kept = link::describe_kept(client.kept()?);
    say!("saved           {kept}");
    let fields = watch::fields(&client.statistics()?, &settings)?;
    for (name, value) in &fields {
        say!("{name:<15} {}", watch::text(value));
    }
    say::figures(&json!({
        "firmware": format!("{major}.{minor}.{patch}"),
        "plays": identity.plays,
        "dead_zones": identity.dead_zones,
        "stream_samples": identity.stream,
        "preview_samples": identity.window,
        "model": model.as_ref().map(describe),
        "sample_rate_hz": settings.sample_rate_hz,
        "drive_min_v": settings.drive_min_v,
        "drive_max_v": settings.drive_max_v,
        "drive_rest_v": settings.drive_rest_v,
        "saved": kept,
        "now": watch::object(fields),
    }));
    Ok(())
}

/// Prints the settings, or changes them and reads them back.
pub fn settings(client: &mut Client<'_>, file: Option<&Path>) -> Result<(), Error> {
    let now = client.settings()?;
    let Some(file) = file else {
        let text = link::settings::to_toml(&now)?;
        say!("{}", text.trim_end());
        // The same keys; the text was just written from numbers.
        say::figures(&toml::from_str(&text).unwrap_or_default());
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
    say!("settings in force; `save` keeps them through a reset");
    Ok(())
}

/// Saves what is in force, and has the target read it back.
pub fn save(client: &mut Client<'_>) -> Result<(), Error> {
    client.tell(Command::Save)?;
    if client.kept()? != Kept::InForce {
        return Err(Error::request(
            "the target's flash holds something else than was saved; save again, and see `info`",
        ));
    }
    say!("settings and model saved: in force after a reset");
    Ok(())
}

#[derive(Debug, Args)]
pub struct Upload {
    /// A model.toml, or a built-in model: p753, p753-printed, example-f.
    model: String,
    /// Which compensator the target makes of it [default: explicit; dim for a modified play model].
    #[arg(long, value_enum)]
    inverse: Option<Inverse>,
    /// Which rate of its drive the stage sees, for preview and cascade [default: midpoint].
    #[arg(long, value_enum, value_name = "RATE")]
    plant_rate: Option<Rate>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Inverse {
    /// The analytic inverse with the rate of the reference; no latency.
    Explicit,
    /// The inverse with the rate of the drive itself; it looks ahead.
    Preview,
    /// Inverses of all stages of the model; it looks ahead.
    Cascade,
    /// Direct inverse multiplication, for a modified play model.
    Dim,
}

impl Upload {
    /// Sends a model and reads it back.
    pub fn run(&self, client: &mut Client<'_>) -> Result<(), Error> {
        let file = model_file::resolve(&self.model)?;
        let choice = self.choice(&file)?;
        let settings = client.settings()?;
        let Prepared {
            record,
            latency,
            left_out,
        } = link::model::record(&file, &settings, choice)?;
        client.tell(Command::SetModel(Some(record.clone())))?;
        if client.model()?.as_ref() != Some(&record) {
            return Err(Error::request(
                "the target keeps another model than was sent; flash the firmware of this \
                 program's version",
            ));
        }
        let left: Vec<&str> = match choice {
            Choice::Cascade(_) => Vec::new(),
            _ => {
                let undone = file.effects().filter(|stage| stage.inverted());
                undone.map(Stage::name).collect()
            }
        };
        if !left.is_empty() {
            eprintln!(
                "note: {} of model \"{}\" stays as it is; --inverse cascade undoes it",
                left.join(", "),
                file.name
            );
        }
        note_left_out(&left_out, &file.name);
        say!("model \"{}\" in force: {}", file.name, describe(&record));
        say!("latency: {}", samples_and_ms(latency, &settings));
        Ok(())
    }

    fn choice(&self, file: &ModelFile) -> Result<Choice, Error> {
        let rate = self.plant_rate.map_or(PlantRate::Midpoint, PlantRate::from);
        match (self.inverse, self.plant_rate) {
            (Some(Inverse::Preview), _) => Ok(Choice::Preview(rate)),
            (Some(Inverse::Cascade), _) => Ok(Choice::Cascade(rate)),
            (_, Some(_)) => Err(Error::request(
                "--plant-rate is for a preview; add --inverse preview or cascade, or leave it out",
            )),
            (Some(Inverse::Explicit), None) => Ok(Choice::Explicit),
            (Some(Inverse::Dim), None) => Ok(Choice::Dim),
            (None, None) => Ok(Choice::without_preview(file)),
        }
    }
}

fn samples_and_ms(samples: usize, settings: &Settings) -> String {
    let ms = samples as f64 / f64::from(settings.sample_rate_hz) * 1e3;
    format!("{samples} samples, {ms:.1} ms")
}

fn describe(model: &ModelRecord) -> String {
    match model {
        ModelRecord::ModifiedPlay(model) => format!(
            "modified play, N = {}, {} Hz, DIM {}",
            model.slopes_um_per_v.len(),
            model.frequency_hz,
            match model.law {
                Law::Printed => "as printed",
                Law::Exact => "exact",
            }
        ),
        ModelRecord::Chain(chain) => {
            let mut parts = vec![format!("{} plays", chain.thresholds_v.len())];
            if let Some(map) = &chain.asymmetry {
                parts.push(format!(
                    "asymmetry of {} and {} dead zones",
                    map.positive.thresholds.len(),
                    map.negative.thresholds.len()
                ));
            }
            if !chain.effects.is_empty() {
                parts.push(format!("{} effects", chain.effects.len()));
            }
            parts.push(format!("gain {} um/V", chain.gain_um_per_v));
            parts.push(match chain.inverse {
                record::Inverse::Explicit => "explicit inverse".to_owned(),
                record::Inverse::Preview(preview) => {
                    format!("preview inverse, window {}", preview.window)
                }
                record::Inverse::Cascade(preview) => format!("cascade, window {}", preview.window),
            });
            parts.join(", ")
        }
    }
}
