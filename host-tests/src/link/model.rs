//! A model file as the target takes it: the same stages in single precision, and how to invert them.

use hysteron::hysteresis::Parameters;
use hysteron::hysteresis::preview::{PlantRate, window_for};
use hysteron::record::{
    AsymmetryRecord, ChainRecord, DEAD_ZONES, EFFECTS, Effect, Inverse, ModelRecord,
    ModifiedPlayRecord, PLAYS, Preview, WINDOW, Zones,
};
use hysteron::settings::Settings;

use super::refusal;
use crate::error::Error;
use crate::model_file::{Asymmetry, ModelFile, ModifiedPlay, Stage};

/// Which compensator the target makes of a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// The analytic inverse with the rate of the reference; effects are left as they are.
    Explicit,
    /// The inverse with the rate of the drive itself, from a preview; effects are left as they are.
    Preview(PlantRate),
    /// Inverses of all stages, around that of [`Choice::Preview`] where there is a rate term.
    Cascade(PlantRate),
    /// Direct inverse multiplication, by the law that the model names.
    Dim,
}

impl Choice {
    /// What needs no preview: DIM for a modified play model, else the explicit inverse.
    pub fn without_preview(file: &ModelFile) -> Self {
        match file.modified_play() {
            Some(_) => Self::Dim,
            None => Self::Explicit,
        }
    }

    /// The name of the compensator, as on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Explicit => "explicit",
            Self::Preview(_) => "preview",
            Self::Cascade(_) => "cascade",
            Self::Dim => "dim",
        }
    }
}

/// A model on its way to a target.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// What is sent.
    pub record: ModelRecord,
    /// Samples that its compensator looks ahead.
    pub latency: usize,
    /// Stages of the file that no compensator undoes, limits of the amplifier and what only the sensor
    /// sees: the record is without them.
    pub left_out: Vec<&'static str>,
}

/// The record for a target with these settings, judged as the target will judge it.
///
/// # Errors
/// More plays, dead zones, effects or preview than the target has room for, a rate law, a congruency, elements,
/// a choice that does not suit the model, or a compensator that does not exist in single precision.
pub fn record(file: &ModelFile, settings: &Settings, choice: Choice) -> Result<Prepared, Error> {
    let sample_time = 1.0 / settings.sample_rate_hz;
    let record = convert(file, sample_time, choice)
        .map_err(|problem| Error::request(format!("model \"{}\" {problem}", file.name)))?;
    let compensator = record
        .compensator(sample_time)
        .map_err(|error| Error::request(refusal::model(error)))?;
    let left = file.effects().filter(|stage| !stage.inverted());
    Ok(Prepared {
        latency: compensator.latency(),
        record,
        left_out: left.map(Stage::name).collect(),
    })
}

fn convert(file: &ModelFile, sample_time: f32, choice: Choice) -> Result<ModelRecord, String> {
    match (file.modified_play(), choice) {
        (Some(model), Choice::Dim) => modified_play(model).map(ModelRecord::ModifiedPlay),
        (None, Choice::Dim) => {
            Err("has no stage modified-play, which dim needs; choose another --inverse".to_owned())
        }
        (Some(_), _) => {
            Err("is a modified play model, which only dim inverts; leave --inverse out".to_owned())
        }
        (None, _) => chain(file, sample_time, choice).map(ModelRecord::Chain),
    }
}

fn chain(file: &ModelFile, sample_time: f32, choice: Choice) -> Result<ChainRecord, String> {
    let hysteresis = file
        .hysteresis()
        .ok_or("has no stage hysteresis; identify it anew")?;
    let plays = hysteresis.thresholds_v.len();
    let room = || {
        format!(
            "has {plays} plays and the target room for {PLAYS}; identify it with --plays {PLAYS}"
        )
    };
    let (gain_um_per_v, offset_um) = file.output();
    let mut record = ChainRecord {
        thresholds_v: numbers(&hysteresis.thresholds_v).ok_or_else(room)?,
        weights: numbers(&hysteresis.weights).ok_or_else(room)?,
        beta_s: hysteresis.beta_s as f32,
        asymmetry: file.asymmetry().map(asymmetry).transpose()?,
        effects: heapless::Vec::new(),
        gain_um_per_v: gain_um_per_v as f32,
        offset_um: offset_um as f32,
        inverse: Inverse::Explicit,
    };
    for stage in file.effects().filter(|stage| stage.inverted()) {
        let effect = effect(stage).ok_or_else(|| {
            let name = stage.name();
            format!(
                "has a stage {name}, which the firmware cannot undo; compensate on the host with \
                 --inverse cascade, or identify it without that effect"
            )
        })?;
        record
            .effects
            .push(effect)
            .map_err(|_| format!("has more than {EFFECTS} effects; upload a model with fewer"))?;
    }
    record.inverse = match choice {
        Choice::Preview(rate) => Inverse::Preview(preview(&record, sample_time, rate)?),
        Choice::Cascade(rate) => Inverse::Cascade(preview(&record, sample_time, rate)?),
        Choice::Explicit | Choice::Dim => Inverse::Explicit,
    };
    Ok(record)
}

/// Longest preview that a model may ask for. The target looks at [`WINDOW`] samples of it, which leave
/// 5e-3 of the guess at its end instead of the thousandth that a model asks for.
const ASKED_MOST: usize = 2 + (WINDOW - 2) * 13 / 10;

/// As long a preview as the model needs, or as the target has. Of one that the target will refuse anyway any will do.
fn preview(
    record: &ChainRecord,
    sample_time: f32,
    plant_rate: PlantRate,
) -> Result<Preview, String> {
    let built = Parameters {
        weights: &record.weights,
        thresholds: &record.thresholds_v,
        beta: record.beta_s,
    }
    .build::<PLAYS>(sample_time);
    let window = built.map_or(2, |model| window_for(&model));
    if window > ASKED_MOST && record.beta_s > 0.0 {
        return Err(format!(
            "needs a preview of {window} samples and the target can do with {ASKED_MOST}; lower \
             sample_rate_hz or upload it with --inverse explicit"
        ));
    }
    Ok(Preview {
        window: window.min(WINDOW) as u8,
        plant_rate,
    })
}

fn effect(stage: &Stage) -> Option<Effect> {
    Some(match stage {
        Stage::AmplifierLag(lag) => Effect::AmplifierLag {
            tau_s: lag.tau_s as f32,
        },
        Stage::TransportDelay(delay) => Effect::TransportDelay {
            delay_s: delay.delay_s as f32,
        },
        Stage::Quadratic(map) => Effect::Quadratic { q: map.q as f32 },
        Stage::Cubic(map) => Effect::Cubic { c: map.c as f32 },
        Stage::Resonance(mode) => Effect::Resonance {
            f_n_hz: mode.f_n_hz as f32,
            zeta: mode.zeta as f32,
        },
        Stage::Creep(creep) => Effect::Creep {
            gain_per_decade: creep.gain_per_decade as f32,
            tau_min_s: creep.tau_min_s as f32,
            tau_max_s: creep.tau_max_s as f32,
        },
        Stage::OutputQuadratic(map) => Effect::OutputQuadratic { q: map.q as f32 },
        Stage::Backlash(gap) => Effect::Backlash {
            width: gap.width as f32,
        },
        Stage::Interleaving(product) => Effect::Interleaving {
            g: product.g as f32,
        },
        _ => return None,
    })
}

fn asymmetry(map: &Asymmetry) -> Result<AsymmetryRecord, String> {
    let side = |thresholds: &[f64], slopes: &[f64]| {
        Some(Zones {
            thresholds: numbers(thresholds)?,
            slopes: numbers(slopes)?,
        })
    };
    let (thresholds, slopes) = (&map.thresholds, &map.slopes);
    let positive = side(&thresholds.positive, &slopes.positive);
    let negative = side(&thresholds.negative, &slopes.negative);
    match (positive, negative) {
        (Some(positive), Some(negative)) => Ok(AsymmetryRecord { positive, negative }),
        _ => Err(format!(
            "has more dead zones on a side than the target has room for ({DEAD_ZONES}); identify it \
             with --asymmetry none"
        )),
    }
}

fn modified_play(model: &ModifiedPlay) -> Result<ModifiedPlayRecord, String> {
    Ok(ModifiedPlayRecord {
        u_max_v: model.u_max_v as f32,
        slopes_um_per_v: numbers(&model.slopes_um_per_v).ok_or_else(|| {
            format!(
                "has {} slopes and the target room for {PLAYS}; identify it with fewer",
                model.slopes_um_per_v.len()
            )
        })?,
        offset_um: model.offset_um as f32,
        alpha_s: model.alpha_s as f32,
        beta_s: model.beta_s as f32,
        interleaving_per_v: model.interleaving_per_v as f32,
        feedback: model.feedback.map(|c| c as f32),
        frequency_hz: model.frequency_hz as f32,
        harmonics: model.harmonics.into(),
        sine: model.sine.map(|a| a as f32),
        cosine: model.cosine.map(|a| a as f32),
        sample_time_s: model.sample_time_s as f32,
        law: model.law.into(),
    })
}

fn numbers<const N: usize>(values: &[f64]) -> Option<heapless::Vec<f32, N>> {
    let mut numbers = heapless::Vec::new();
    for &value in values {
        numbers.push(value as f32).ok()?;
    }
    Some(numbers)
}
