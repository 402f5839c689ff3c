//! Settings of the target as a TOML file.

use std::path::Path;

use hysteron::dac;
use hysteron::settings::Settings;
use serde::{Deserialize, Serialize};
use toml::Spanned;
use toml::de::DeValue;

use super::refusal;
use crate::error::{Error, Place};
use crate::toml_text::{TomlText, read_text};

/// The keys of the file, named as in the firmware's settings; those that are left out stay as they
/// are.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    sample_rate_hz: Option<f32>,
    dac: Option<Dac>,
    amplifier_gain: Option<f32>,
    amplifier_offset_v: Option<f32>,
    sensor_um_per_v: Option<f32>,
    sensor_offset_um: Option<f32>,
    drive_min_v: Option<f32>,
    drive_max_v: Option<f32>,
    drive_rest_v: Option<f32>,
    slew_v_per_s: Option<f32>,
    ramp_v_per_s: Option<f32>,
    stale_s: Option<f32>,
    miss_limit: Option<u16>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Dac {
    Internal12,
    Bipolar16,
}

/// The settings as the text of a file.
///
/// # Errors
/// None for settings that a target accepts.
pub fn to_toml(settings: &Settings) -> Result<String, Error> {
    let Settings {
        version: _,
        sample_rate_hz,
        dac,
        amplifier_gain,
        amplifier_offset_v,
        sensor_um_per_v,
        sensor_offset_um,
        drive_min_v,
        drive_max_v,
        drive_rest_v,
        slew_v_per_s,
        ramp_v_per_s,
        stale_s,
        miss_limit,
    } = *settings;
    let file = File {
        sample_rate_hz: Some(sample_rate_hz),
        dac: Some(match dac {
            dac::Kind::Internal12 => Dac::Internal12,
            dac::Kind::Bipolar16 => Dac::Bipolar16,
        }),
        amplifier_gain: Some(amplifier_gain),
        amplifier_offset_v: Some(amplifier_offset_v),
        sensor_um_per_v: Some(sensor_um_per_v),
        sensor_offset_um: Some(sensor_offset_um),
        drive_min_v: Some(drive_min_v),
        drive_max_v: Some(drive_max_v),
        drive_rest_v: Some(drive_rest_v),
        slew_v_per_s: Some(slew_v_per_s),
        ramp_v_per_s: Some(ramp_v_per_s),
        stale_s: Some(stale_s),
        miss_limit: Some(miss_limit),
    };
    toml::to_string(&file)
        .map_err(|error| Error::request(format!("the settings cannot be shown: {error}")))
}

/// `now` with what a file changes.
///
/// # Errors
/// One line with file, line and key: not TOML, an unknown key, a value of another type; and values
/// out of their bounds, judged as the target judges them.
pub fn load(path: impl AsRef<Path>, now: &Settings) -> Result<Settings, Error> {
    let text = read_text(path.as_ref())?;
    let place = Place::file(path);
    let toml = TomlText::new(&text, place.clone());
    let table = toml.table()?;
    let span = table.span();
    let file: File = toml.typed(Spanned::new(span, DeValue::Table(table.into_inner())))?;
    let changed = file.over(now);
    changed
        .validate()
        .map_err(|error| place.error(refusal::setting(error)))?;
    Ok(changed)
}

impl File {
    fn over(self, now: &Settings) -> Settings {
        Settings {
            version: now.version,
            sample_rate_hz: self.sample_rate_hz.unwrap_or(now.sample_rate_hz),
            dac: match self.dac {
                Some(Dac::Internal12) => dac::Kind::Internal12,
                Some(Dac::Bipolar16) => dac::Kind::Bipolar16,
                None => now.dac,
            },
            amplifier_gain: self.amplifier_gain.unwrap_or(now.amplifier_gain),
            amplifier_offset_v: self.amplifier_offset_v.unwrap_or(now.amplifier_offset_v),
            sensor_um_per_v: self.sensor_um_per_v.unwrap_or(now.sensor_um_per_v),
            sensor_offset_um: self.sensor_offset_um.unwrap_or(now.sensor_offset_um),
            drive_min_v: self.drive_min_v.unwrap_or(now.drive_min_v),
            drive_max_v: self.drive_max_v.unwrap_or(now.drive_max_v),
            drive_rest_v: self.drive_rest_v.unwrap_or(now.drive_rest_v),
            slew_v_per_s: self.slew_v_per_s.unwrap_or(now.slew_v_per_s),
            ramp_v_per_s: self.ramp_v_per_s.unwrap_or(now.ramp_v_per_s),
            stale_s: self.stale_s.unwrap_or(now.stale_s),
            miss_limit: self.miss_limit.unwrap_or(now.miss_limit),
        }
    }
}
