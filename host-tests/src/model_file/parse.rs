//! Reads a `model.toml` and checks its form.

use std::path::Path;

use hysteron::chain::MODES;
use hysteron::hysteresis::elements::ELEMENTS;
use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::{Format, ModelFile, Stage, TwoSided, Units, VERSION};
use crate::error::{Error, Place, quoted};
use crate::toml_text::{Step, Steps, TomlText, read_text};

/// Stage names in the order in which they stand; `modified-play` stands alone.
pub const ORDER: [&str; 21] = [
    "saturation",
    "slew-limit",
    "amplifier-lag",
    "transport-delay",
    "hysteresis",
    "bouc-wen",
    "rate-law",
    "congruency",
    "asymmetry",
    "quadratic",
    "cubic",
    "backlash",
    "resonance",
    "creep",
    "output-quadratic",
    "output",
    "interleaving",
    "sensor-lag",
    "drift",
    "mains-hum",
    "quantisation",
];
/// The name of the stage that stands alone.
const ALONE: &str = "modified-play";

/// Everything but the stages.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    format: Format,
    version: u32,
    name: String,
    units: Units,
}

/// Loads a model file.
///
/// # Errors
/// Those of [`parse`], and when the file cannot be read or is not UTF-8.
pub fn load(path: impl AsRef<Path>) -> Result<ModelFile, Error> {
    let text = read_text(path.as_ref())?;
    parse(&text, path)
}

/// Reads a model from the text of a `model.toml`; `file` names it in messages.
///
/// # Errors
/// One line with file, line and key: not TOML, a key unknown or missing, another format, a newer
/// version, other units, stages unknown, doubled, out of order or without a hysteresis, arrays of
/// lengths that do not fit, numbers that are not finite.
pub fn parse(text: &str, file: impl AsRef<Path>) -> Result<ModelFile, Error> {
    let toml = TomlText::new(text, Place::file(file));
    let table = toml.table()?;
    let span = table.span();
    let mut table = table.into_inner();
    check_version(&table, &toml)?;
    let stages = table.remove("stage");
    let head: Head = toml.typed(Spanned::new(span.clone(), DeValue::Table(table)))?;
    let Some(stages) = stages else {
        return Err(toml
            .at(span.start)
            .error("there is no [[stage]]; add a hysteresis stage"));
    };
    let span = stages.span();
    let DeValue::Array(array) = stages.into_inner() else {
        return Err(toml
            .at(span.start)
            .error("stage is not a list; write it as [[stage]]"));
    };
    let model = ModelFile {
        format: head.format,
        version: head.version,
        name: head.name,
        units: head.units,
        stages: array
            .into_iter()
            .map(|stage| read_stage(stage, &toml))
            .collect::<Result<_, _>>()?,
    };
    check_order(&model.stages, &toml)?;
    for (index, stage) in model.stages.iter().enumerate() {
        check_stage(stage).map_err(|fault| {
            let inside = [Step::Key("stage"), Step::Index(index)];
            let steps: Vec<_> = inside
                .into_iter()
                .chain(fault.steps.iter().copied())
                .collect();
            let key = Steps(&fault.steps);
            toml.place_of(&steps)
                .error(format!("{}.{key}: {}", stage.name(), fault.problem))
        })?;
    }
    Ok(model)
}

/// Comes before everything else: a newer file may hold keys that this program does not know.
fn check_version(table: &DeTable<'_>, toml: &TomlText<'_>) -> Result<(), Error> {
    let place = |key| toml.place_of(&[Step::Key(key)]);
    match table.get("format").map(|value| value.get_ref()) {
        None => {
            let problem = "not a model file: there is no format = \"hysteron-model\"; add it or \
                           name another file";
            return Err(toml.at(0).error(problem));
        }
        Some(value) if value.as_str() != Some("hysteron-model") => {
            let problem = "not a model file: format is not \"hysteron-model\"; name another file";
            return Err(place("format").error(problem));
        }
        Some(_) => {}
    }
    let Some(integer) = table
        .get("version")
        .and_then(|value| value.get_ref().as_integer())
    else {
        // Missing or of another type: serde says so.
        return Ok(());
    };
    let version = i64::from_str_radix(integer.as_str(), integer.radix()).unwrap_or(i64::MAX);
    let known = i64::from(VERSION);
    if version > known {
        return Err(place("version").error(format!(
            "model version {version} is newer than this program knows ({known}); use a newer \
             program"
        )));
    }
    if version < 1 {
        return Err(place("version").error(format!(
            "there is no model version {version}; write version = {known}"
        )));
    }
    Ok(())
}

fn read_stage<'a>(stage: Spanned<DeValue<'a>>, toml: &TomlText<'a>) -> Result<Stage, Error> {
    let span = stage.span();
    let DeValue::Table(mut table) = stage.into_inner() else {
        return Err(toml
            .at(span.start)
            .error("a stage is not a table; write it as [[stage]]"));
    };
    let known = format!("{}, {ALONE}", ORDER.join(", "));
    let Some(name) = table.remove("name") else {
        let problem = format!("the stage has no name; give it one of {known}");
        return Err(toml.at(span.start).error(problem));
    };
    let place = toml.at(name.span().start);
    let body = Spanned::new(span, DeValue::Table(table));
    match name.get_ref().as_str() {
        Some("saturation") => toml.typed(body).map(Stage::Saturation),
        Some("slew-limit") => toml.typed(body).map(Stage::SlewLimit),
        Some("amplifier-lag") => toml.typed(body).map(Stage::AmplifierLag),
        Some("transport-delay") => toml.typed(body).map(Stage::TransportDelay),
        Some("hysteresis") => toml.typed(body).map(Stage::Hysteresis),
        Some("rate-law") => toml.typed(body).map(Stage::RateLaw),
        Some("bouc-wen") => toml.typed(body).map(Stage::BoucWen),
        Some("congruency") => toml.typed(body).map(Stage::Congruency),
        Some("asymmetry") => toml.typed(body).map(Stage::Asymmetry),
        Some("quadratic") => toml.typed(body).map(Stage::Quadratic),
        Some("cubic") => toml.typed(body).map(Stage::Cubic),
        Some("backlash") => toml.typed(body).map(Stage::Backlash),
        Some("resonance") => toml.typed(body).map(Stage::Resonance),
        Some("creep") => toml.typed(body).map(Stage::Creep),
        Some("output-quadratic") => toml.typed(body).map(Stage::OutputQuadratic),
        Some("output") => toml.typed(body).map(Stage::Output),
        Some("interleaving") => toml.typed(body).map(Stage::Interleaving),
        Some("sensor-lag") => toml.typed(body).map(Stage::SensorLag),
        Some("drift") => toml.typed(body).map(Stage::Drift),
        Some("mains-hum") => toml.typed(body).map(Stage::MainsHum),
        Some("quantisation") => toml.typed(body).map(Stage::Quantisation),
        Some(ALONE) => toml.typed(body).map(Stage::ModifiedPlay),
        Some(other) => Err(place.error(format!(
            "there is no stage {}; the stages are {known}",
            quoted(other)
        ))),
        None => Err(place.error(format!(
            "the stage's name is not a string; use one of {known}"
        ))),
    }
}

fn check_order(stages: &[Stage], toml: &TomlText<'_>) -> Result<(), Error> {
    let place = |index| toml.place_of(&[Step::Key("stage"), Step::Index(index)]);
    if let (Some(index), [_, _, ..]) = (
        stages.iter().position(|stage| stage.name() == ALONE),
        stages,
    ) {
        let problem = format!("stage {ALONE} is a whole model; leave the other stages out");
        return Err(place(index).error(problem));
    }
    for (index, pair) in stages.windows(2).enumerate() {
        let (before, after) = (pair[0].name(), pair[1].name());
        if before == after && !["resonance", "bouc-wen"].contains(&after) {
            let problem = format!("a second stage {after}; keep one");
            return Err(place(index + 1).error(problem));
        }
        if pair[0].place() > pair[1].place() {
            return Err(place(index + 1).error(format!(
                "stage {after} stands after {before}; the order is {}",
                ORDER.join(", ")
            )));
        }
    }
    for (name, most) in [("resonance", MODES), ("bouc-wen", ELEMENTS)] {
        if stages.iter().filter(|stage| stage.name() == name).count() > most {
            return Err(place(0).error(format!("more than {most} stages {name}; keep {most}")));
        }
    }
    let core = |stage: &Stage| matches!(stage, Stage::Hysteresis(_) | Stage::ModifiedPlay(_));
    if stages.iter().any(core) {
        Ok(())
    } else {
        Err(place(0).error("there is no stage hysteresis; add it"))
    }
}

/// What is wrong with a stage, and under which of its keys.
struct Fault {
    steps: Vec<Step>,
    problem: String,
}

fn check_stage(stage: &Stage) -> Result<(), Fault> {
    match stage {
        Stage::Hysteresis(hysteresis) => {
            check_finite(&[Step::Key("thresholds_v")], &hysteresis.thresholds_v)?;
            check_finite(&[Step::Key("weights")], &hysteresis.weights)?;
            check_number(&[Step::Key("beta_s")], hysteresis.beta_s)?;
            check_one_more(
                &[Step::Key("weights")],
                &hysteresis.weights,
                &hysteresis.thresholds_v,
            )
        }
        Stage::Asymmetry(asymmetry) => {
            let side = |all: &TwoSided, side: &str| match side {
                "positive" => all.positive.clone(),
                _ => all.negative.clone(),
            };
            for name in ["positive", "negative"] {
                let thresholds = side(&asymmetry.thresholds, name);
                let slopes = side(&asymmetry.slopes, name);
                let at_slopes = [Step::Key("slopes"), Step::Key(name)];
                check_finite(&[Step::Key("thresholds"), Step::Key(name)], &thresholds)?;
                check_finite(&at_slopes, &slopes)?;
                check_one_more(&at_slopes, &slopes, &thresholds)?;
            }
            Ok(())
        }
        Stage::Output(output) => {
            check_number(&[Step::Key("gain_um_per_v")], output.gain_um_per_v)?;
            check_number(&[Step::Key("offset_um")], output.offset_um)
        }
        Stage::ModifiedPlay(model) => {
            let lists = [
                ("slopes_um_per_v", &model.slopes_um_per_v[..]),
                ("feedback", &model.feedback),
                ("sine", &model.sine),
                ("cosine", &model.cosine),
            ];
            for (key, numbers) in lists {
                check_finite(&[Step::Key(key)], numbers)?;
            }
            let numbers = [
                ("sample_time_s", model.sample_time_s),
                ("u_max_v", model.u_max_v),
                ("offset_um", model.offset_um),
                ("alpha_s", model.alpha_s),
                ("beta_s", model.beta_s),
                ("interleaving_per_v", model.interleaving_per_v),
                ("frequency_hz", model.frequency_hz),
            ];
            numbers
                .into_iter()
                .try_for_each(|(key, number)| check_number(&[Step::Key(key)], number))
        }
        effect => effect
            .effect_numbers()
            .into_iter()
            .try_for_each(|(key, number)| check_number(&[Step::Key(key)], number)),
    }
}

fn check_finite(steps: &[Step], numbers: &[f64]) -> Result<(), Fault> {
    numbers.iter().enumerate().try_for_each(|(index, &number)| {
        let steps: Vec<_> = steps.iter().copied().chain([Step::Index(index)]).collect();
        check_number(&steps, number)
    })
}

fn check_number(steps: &[Step], number: f64) -> Result<(), Fault> {
    if number.is_finite() {
        return Ok(());
    }
    let problem = format!("{number} is not a finite number; write one");
    Err(Fault {
        steps: steps.to_vec(),
        problem,
    })
}

fn check_one_more(steps: &[Step], longer: &[f64], thresholds: &[f64]) -> Result<(), Fault> {
    let wanted = thresholds.len() + 1;
    if longer.len() == wanted {
        return Ok(());
    }
    let problem = format!(
        "holds {}, but must hold one more than there are thresholds: {wanted}; add or remove some",
        longer.len(),
    );
    Err(Fault {
        steps: steps.to_vec(),
        problem,
    })
}
