//! A model as source code for a firmware of one's own: a C99 header or a Rust module without `std`.
//!
//! What is written stands alone: the coefficients, the model from drive to displacement and its explicit
//! inverse, in single or double precision. `docs/interchange.md` says what is in it and how near it comes
//! to this program's own numbers.

mod c;
mod constants;
mod rust;

use hysteron::chain::Effects;
use hysteron::effect::quadratic::SLOPE_LEAST;

use crate::error::Error;
use crate::model_file::{ModelFile, Stage};
use crate::stage::{self, Chain};
use constants::{Constant, Value, constants};

/// The stages that are written as code; what they do is a function of one sample, but for the plays.
pub const COMPUTED: [&str; 7] = [
    "saturation",
    "hysteresis",
    "asymmetry",
    "quadratic",
    "cubic",
    "output-quadratic",
    "output",
];
/// Iterations that undo a curvature: enough for a slope of the map between 1/10 and 50.
const NEWTON_STEPS: usize = 12;
/// Longest prefix of names.
const PREFIX: usize = 32;

/// `q w` where the slope of the quadratic map is the least.
fn edge_bend() -> f64 {
    0.5 * (SLOPE_LEAST - 1.0)
}

/// The language of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// A header in C99.
    C,
    /// A module in Rust, edition 2021 or later, without `std`.
    Rust,
}

/// The floating-point type of the code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits.
    Single,
    /// 64 bits.
    Double,
}

/// What to write.
#[derive(Clone, Debug)]
pub struct Options {
    /// The language.
    pub language: Language,
    /// Time between two samples in s; the rate terms are scaled by it.
    pub sample_time_s: f64,
    /// The type of all numbers. Coefficients of the inverse are computed in double precision and rounded.
    pub precision: Precision,
    /// What names in C begin with: a letter in lower case, then such letters, digits and `_`; of no
    /// account in Rust.
    pub prefix: String,
    /// Stages beside the computed ones that the code may do without: their numbers become constants.
    pub as_constants: Vec<String>,
}

/// A model ready to be written.
struct Exported<'a> {
    options: &'a Options,
    title: String,
    chain: Chain,
    constants: Vec<Constant>,
    left: Vec<&'static str>,
}

impl Exported<'_> {
    fn effects(&self) -> &Effects<f64> {
        self.chain.effects()
    }

    fn has_asymmetry(&self) -> bool {
        self.chain.model().asymmetry().is_some()
    }

    fn number(&self, value: f64) -> String {
        match self.options.precision {
            Precision::Single => format!("{:?}", value as f32),
            Precision::Double => format!("{value:?}"),
        }
    }
}

/// The source code of a model.
///
/// # Errors
/// A stage that is not written as code and not among [`Options::as_constants`]; a rate law, a congruency,
/// an element of Bouc and Wen or a modified play model, whose hysteresis is another one; numbers that the core refuses or that leave the
/// range of the precision; a sample time or prefix that is none.
pub fn export(file: &ModelFile, options: &Options) -> Result<String, Error> {
    check_prefix(&options.prefix)?;
    let refuse = |problem: String| {
        Err(Error::request(format!(
            "model \"{}\": {problem}",
            file.name
        )))
    };
    if file.modified_play().is_some() {
        return refuse(
            "a modified play model is not exported; identify one with a hysteresis stage"
                .to_owned(),
        );
    }
    if let Some(stage) = file.core_effects().next() {
        return refuse(format!(
            "stage {} changes what the hysteresis itself does and is not exported; identify without it",
            stage.name()
        ));
    }
    let left = left(file, options)?;
    let kept: Vec<Stage> = file
        .stages
        .iter()
        .filter(|stage| COMPUTED.contains(&stage.name()))
        .cloned()
        .collect();
    let kept = ModelFile::new(file.name.clone(), kept);
    let exported = Exported {
        options,
        title: title(&file.name),
        chain: stage::chain(&kept, options.sample_time_s)?,
        constants: constants(file, &kept, options.sample_time_s)?,
        left,
    };
    for constant in &exported.constants {
        let numbers = match &constant.value {
            Value::Number(number) => std::slice::from_ref(number),
            Value::Array(numbers) => numbers,
            Value::Count(_) => &[],
        };
        let lost = |number: &f64| {
            let single = *number as f32;
            options.precision == Precision::Single
                && (!single.is_finite() || (single == 0.0 && *number != 0.0))
        };
        if let Some(number) = numbers.iter().find(|number| lost(number)) {
            return refuse(format!(
                "{} = {number:e} is out of the range of single precision; use --precision double",
                constant.name
            ));
        }
    }
    Ok(match options.language {
        Language::C => c::text(&exported),
        Language::Rust => rust::text(&exported),
    })
}

/// The stages that are left to constants.
fn left(file: &ModelFile, options: &Options) -> Result<Vec<&'static str>, Error> {
    let there = |name: &String| file.stages.iter().any(|stage| stage.name() == name);
    let computed = |name: &String| COMPUTED.contains(&name.as_str());
    if let Some(name) = options
        .as_constants
        .iter()
        .find(|n| !there(n) || computed(n))
    {
        return Err(Error::request(format!(
            "model \"{}\" has no stage {name} that could be left to constants; name its other stages",
            file.name
        )));
    }
    let mut left: Vec<&'static str> = Vec::new();
    let mut missing = Vec::new();
    for stage in &file.stages {
        let name = stage.name();
        if COMPUTED.contains(&name) {
            continue;
        }
        if options.as_constants.iter().any(|wanted| wanted == name) {
            left.push(name);
        } else {
            missing.push(name);
        }
    }
    left.dedup();
    missing.dedup();
    if missing.is_empty() {
        return Ok(left);
    }
    Err(Error::request(format!(
        "model \"{}\": no code is written for {}; --as-constants {} writes their numbers alone, for code \
         of your own",
        file.name,
        missing.join(", "),
        missing.join(",")
    )))
}

fn check_prefix(prefix: &str) -> Result<(), Error> {
    let good = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    let begins = prefix.starts_with(|c: char| c.is_ascii_lowercase());
    if begins && prefix.len() <= PREFIX && prefix.chars().all(good) {
        return Ok(());
    }
    Err(Error::request(format!(
        "{} is no prefix for names; take up to {PREFIX} of a-z, 0-9 and _, a letter first",
        crate::error::quoted(prefix)
    )))
}

/// A model's name, fit for a comment in either language.
fn title(name: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || " .,-_()%+".contains(c);
    name.chars()
        .map(|c| if plain(c) { c } else { '_' })
        .collect()
}
