//! The numbers of an exported model, with their names and units.

use hysteron::effect::quadratic::SLOPE_LEAST;

use super::{COMPUTED, edge_bend};
use crate::error::Error;
use crate::model_file::{Asymmetry, ModelFile, Stage};
use crate::stage;

/// A named number or list.
pub(super) struct Constant {
    /// In upper case.
    pub(super) name: String,
    /// What it is, and its unit.
    pub(super) what: String,
    pub(super) value: Value,
}

/// What a constant holds.
pub(super) enum Value {
    /// A length of lists.
    Count(usize),
    /// A number.
    Number(f64),
    /// A list that is not empty.
    Array(Vec<f64>),
}

struct List(Vec<Constant>);

impl List {
    fn add(&mut self, name: &str, what: &str, value: Value) {
        self.0.push(Constant {
            name: name.to_owned(),
            what: what.to_owned(),
            value,
        });
    }

    fn number(&mut self, name: &str, what: &str, number: f64) {
        self.add(name, what, Value::Number(number));
    }

    fn array(&mut self, name: &str, what: &str, numbers: &[f64]) {
        self.add(name, what, Value::Array(numbers.to_vec()));
    }
}

/// The constants of the stages that are computed (`kept`) and of those that `file` holds besides.
pub(super) fn constants(
    file: &ModelFile,
    kept: &ModelFile,
    h: f64,
) -> Result<Vec<Constant>, Error> {
    let mut list = List(Vec::new());
    let chain = stage::chain(kept, h)?;
    let model = chain.model().hysteresis();
    let inverse = stage::compensator(kept, h)?;
    let inverse = inverse.hysteresis();
    list.number("SAMPLE_TIME_S", "time between two samples in s", h);
    list.add(
        "PLAYS",
        "plays of model and inverse",
        Value::Count(model.bank().len()),
    );
    list.number(
        "WEIGHT_0",
        "a_0: weight of the drive itself",
        model.weight_0(),
    );
    list.array(
        "WEIGHTS",
        "a_1 ..: weights of the plays",
        model.bank().weights(),
    );
    list.array(
        "THRESHOLDS_V",
        "alpha_1 ..: thresholds in V",
        model.bank().thresholds(),
    );
    list.number(
        "BETA_S",
        "beta: growth of the thresholds with the rate, in s",
        model.beta(),
    );
    list.number(
        "BETA_PER_SAMPLE",
        "beta over the sample time",
        model.beta() / h,
    );
    list.number("INVERSE_WEIGHT_0", "b_0", inverse.weight_0());
    list.array("INVERSE_WEIGHTS", "b_1 ..", inverse.bank().weights());
    list.array(
        "INVERSE_THRESHOLDS_V",
        "s_1 .. in V",
        inverse.bank().thresholds(),
    );
    list.number(
        "INVERSE_BETA_PER_SAMPLE",
        "a_0 beta over the sample time",
        inverse.beta() / h,
    );
    let (gain, offset) = file.output();
    list.number("GAIN_UM_PER_V", "gain in um/V", gain);
    list.number("PER_GAIN_V_PER_UM", "1 / gain in V/um", 1.0 / gain);
    list.number(
        "OFFSET_UM",
        "displacement in um where the argument of the gain is zero",
        offset,
    );
    for stage in &kept.stages {
        match stage {
            Stage::Saturation(limit) => {
                list.number("LIMIT_V", "limit of the drive in V", limit.limit_v);
            }
            Stage::Asymmetry(map) => add_map(&mut list, map),
            Stage::Quadratic(map) if map.q != 0.0 => add_quadratic(&mut list, "QUADRATIC", map.q),
            Stage::OutputQuadratic(map) if map.q != 0.0 => {
                add_quadratic(&mut list, "OUTPUT_QUADRATIC", map.q);
            }
            Stage::Cubic(map) if map.c != 0.0 => {
                list.number("CUBIC", "c of w + c w^3 in 1/V^2", map.c);
                if map.c < 0.0 {
                    let edge = ((SLOPE_LEAST - 1.0) / (3.0 * map.c)).sqrt();
                    list.number(
                        "CUBIC_EDGE_V",
                        "beyond it the map is its tangent, in V",
                        edge,
                    );
                }
            }
            _ => {}
        }
    }
    let mut modes = 0;
    for stage in &file.stages {
        let name = stage.name();
        if COMPUTED.contains(&name) {
            continue;
        }
        modes += usize::from(name == "resonance");
        let number = if name == "resonance" {
            format!("_{modes}")
        } else {
            String::new()
        };
        for (key, value) in stage.effect_numbers() {
            let name = format!("{name}{number}_{key}").replace('-', "_");
            list.number(
                &name.to_uppercase(),
                "not computed here, see docs/model.md",
                value,
            );
        }
    }
    Ok(list.0)
}

fn add_quadratic(list: &mut List, name: &str, q: f64) {
    list.number(name, "q of w + q w^2 in 1/V", q);
    let edge = edge_bend() / q;
    list.number(
        &format!("{name}_EDGE_V"),
        "beyond it the map is its tangent, in V",
        edge,
    );
}

/// The map and its inverse, a side each: slopes, and thresholds behind a zero that makes both as long.
fn add_map(list: &mut List, map: &Asymmetry) {
    let sides = [
        (
            "POSITIVE",
            "w >= 0",
            &map.slopes.positive,
            &map.thresholds.positive,
        ),
        (
            "NEGATIVE",
            "w < 0",
            &map.slopes.negative,
            &map.thresholds.negative,
        ),
    ];
    for (side, for_w, slopes, thresholds) in sides {
        let thresholds: Vec<f64> = [0.0].iter().chain(thresholds).copied().collect();
        let (mut sum, mut corner) = (0.0, 0.0);
        let (mut inverse_slopes, mut corners) = (Vec::new(), Vec::new());
        for (i, (&slope, &threshold)) in slopes.iter().zip(&thresholds).enumerate() {
            let before: f64 = sum;
            if i > 0 {
                corner += before * (threshold - thresholds[i - 1]);
            }
            corners.push(corner);
            sum += slope;
            inverse_slopes.push(match i {
                0 => 1.0 / slope,
                _ => -slope / (sum * before),
            });
        }
        let name = |what: &str| format!("{side}_{what}");
        list.add(
            &name("CORNERS"),
            "slopes of that side",
            Value::Count(slopes.len()),
        );
        list.array(&name("SLOPES"), &format!("g_0 .. for {for_w}"), slopes);
        list.array(&name("THRESHOLDS_V"), "0, rho_1 .. in V", &thresholds);
        list.array(
            &name("INVERSE_SLOPES"),
            "those of the inverse map",
            &inverse_slopes,
        );
        list.array(&name("INVERSE_THRESHOLDS_V"), "the same, in V", &corners);
    }
}
