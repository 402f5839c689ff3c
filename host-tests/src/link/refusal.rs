//! What a target's refusal means to the user.

use hysteron::link::Refusal;
use hysteron::record::RecordError;
use hysteron::reference::WaveformError;
use hysteron::settings::SettingsError;
use hysteron::store::{Kept, Unfit};

/// What is wrong and, after a semicolon, what to do.
pub(super) fn describe(refusal: &Refusal) -> String {
    match refusal {
        Refusal::Unknown => {
            "the target does not know this command; flash the firmware of this program's version"
                .to_owned()
        }
        Refusal::State => "not in the present state of the output; see `info`, then `stop` it, or \
                           `clear` a fault, and wait until the output is at rest"
            .to_owned(),
        Refusal::Busy => {
            "the target is busy with an earlier command and stays so; see whether its samples go on"
                .to_owned()
        }
        Refusal::Settings(error) => setting(*error),
        Refusal::Model(error) => model(*error),
        Refusal::NoModel => "the target has no model; `upload` one first".to_owned(),
        Refusal::Waveform(WaveformError::NotFinite) => {
            "an amplitude or the offset is not a finite number; correct it".to_owned()
        }
        Refusal::Waveform(WaveformError::Frequency) => {
            "a frequency is not from 0 to a quarter of the sample rate; lower it".to_owned()
        }
        Refusal::NotFinite => {
            "a sample of the reference is too large for single precision; correct it".to_owned()
        }
        Refusal::Gap => "the target lost a part of the stream; start it again".to_owned(),
        Refusal::Flash => {
            "the flash could not be written; what was saved before is still there, and \
                           settings and model stay in force until a reset"
                .to_owned()
        }
    }
}

/// What the flash holds beside what is in force, and why what it holds was refused.
pub fn kept(kept: Kept) -> String {
    match kept {
        Kept::Nothing => "nothing".to_owned(),
        Kept::InForce => "what is in force".to_owned(),
        Kept::Other => "something else; `save` what is in force, or lose it in a reset".to_owned(),
        Kept::Unfit(unfit) => match unfit {
            Unfit::Version(version) => {
                format!("refused: a record of version {version}; set up anew and `save`")
            }
            Unfit::Body => {
                "refused: not a record of this firmware; set up anew and `save`".to_owned()
            }
            Unfit::Settings(error) => format!("refused: {}", setting(error)),
            Unfit::Model(error) => format!("settings alone, no model: {}", model(error)),
        },
    }
}

/// Which setting is out of its bounds, and what they are.
pub(super) fn setting(error: SettingsError) -> String {
    match error {
        SettingsError::Version => {
            "settings of another version; flash the firmware of this program's version"
        }
        SettingsError::SampleRate => "sample_rate_hz: must be 100 to 20000",
        SettingsError::Amplifier => {
            "amplifier_gain, amplifier_offset_v: the converter must reach all of drive_min_v to \
             drive_max_v, and the gain must not be zero"
        }
        SettingsError::Sensor => "sensor_um_per_v: must not be zero",
        SettingsError::DriveRange => "drive_min_v: must be below drive_max_v",
        SettingsError::Rest => "drive_rest_v: must be from drive_min_v to drive_max_v",
        SettingsError::Slew => "slew_v_per_s: must be positive",
        SettingsError::Ramp => {
            "ramp_v_per_s: must be positive and at most slew_v_per_s, and not vanish beside the range"
        }
        SettingsError::Stale => "stale_s: must be 0 to 60",
    }
    .to_owned()
}

/// What makes a model useless to the target.
pub(super) fn model(error: RecordError) -> String {
    match error {
        RecordError::Order(index) => format!(
            "effect {index} of the model, counted from 0, is out of place; the order is \
             amplifier-lag, transport-delay, quadratic, cubic, backlash, resonance, creep, \
             output-quadratic, interleaving"
        ),
        RecordError::Window => format!(
            "the preview is not 2 to {} samples; lower sample_rate_hz or choose the explicit inverse",
            hysteron::record::WINDOW
        ),
        RecordError::SampleTime => {
            "the model holds at another sample rate than that of the settings; set sample_rate_hz to \
             one over its sample_time_s"
                .to_owned()
        }
        RecordError::Parameter(error) => {
            format!("the model has no compensator in single precision: {error}; identify it anew")
        }
    }
}
