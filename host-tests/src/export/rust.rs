//! The module in Rust, without `std`.

use std::fmt::Write as _;

use super::c::curvatures;
use super::{Exported, NEWTON_STEPS, Precision, SLOPE_LEAST, Value, edge_bend};

/// The text of the module.
pub(super) fn text(model: &Exported<'_>) -> String {
    let text = format!(
        "{}{}{HYSTERESIS}{}{}{}",
        opening(model),
        constants(model),
        maps(model),
        forward(model),
        inverse(model),
    );
    let real = match model.options.precision {
        Precision::Single => "f32",
        Precision::Double => "f64",
    };
    text.replace("@T", real)
        .replace("@STEPS", &NEWTON_STEPS.to_string())
        .replace("@LEAST", &SLOPE_LEAST.to_string())
        .replace("@BEND", &edge_bend().to_string())
}

fn opening(model: &Exported<'_>) -> String {
    let left = match model.left.as_slice() {
        [] => String::new(),
        left => format!(
            "//!\n//! Not computed, numbers alone: {}.\n",
            left.join(", ")
        ),
    };
    format!(
        "//! {}\n//!\n//! Model of a piezo stage and its explicit inverse, for samples {} s apart: drive in V,\n\
         //! displacement in um. A sample that is not finite is taken as the one before.\n{left}\n\
         // A firmware may use a part of it.\n#![allow(dead_code)]\n\n",
        model.title, model.options.sample_time_s
    )
}

fn constants(model: &Exported<'_>) -> String {
    let mut text = String::new();
    for constant in &model.constants {
        let name = &constant.name;
        // Writing to a String cannot fail.
        let _ = writeln!(text, "/// {}", constant.what);
        let _ = match &constant.value {
            Value::Count(count) => writeln!(text, "pub const {name}: usize = {count};"),
            Value::Number(value) => {
                writeln!(text, "pub const {name}: @T = {};", model.number(*value))
            }
            Value::Array(values) => {
                let numbers: Vec<_> = values.iter().map(|&v| model.number(v)).collect();
                let list = numbers.join(", ");
                writeln!(text, "pub const {name}: [@T; {}] = [{list}];", values.len())
            }
        };
    }
    text
}

const HYSTERESIS: &str = "
/// Outputs of the plays in V, and the input before.
#[derive(Clone, Copy, Debug)]
struct Plays {
    z: [@T; PLAYS],
    previous: @T,
}

impl Plays {
    fn rest(input: @T) -> Self {
        let previous = if input.is_finite() { input } else { 0.0 };
        Self { z: [0.0; PLAYS], previous }
    }

    /// direct u + sum of the weighted plays, which follow u between envelopes that open with its rate.
    fn step(
        &mut self,
        direct: @T,
        weights: &[@T; PLAYS],
        thresholds: &[@T; PLAYS],
        beta: @T,
        input: @T,
    ) -> @T {
        let u = if input.is_finite() { input } else { self.previous };
        let opened = beta * magnitude(u - self.previous);
        self.previous = u;
        let (low, high) = (u - opened, u + opened);
        let mut sum = direct * u;
        for ((z, &weight), &threshold) in self.z.iter_mut().zip(weights).zip(thresholds) {
            let (low, high) = (low - threshold, high + threshold);
            let below = if *z < high { *z } else { high };
            *z = if below > low { below } else { low };
            sum += weight * *z;
        }
        sum
    }
}

fn magnitude(x: @T) -> @T {
    if x < 0.0 { -x } else { x }
}
";

const ASYMMETRY: &str = "
/// Sum of slopes above thresholds, for w >= 0.
fn dead_zones(slopes: &[@T], thresholds: &[@T], w: @T) -> @T {
    let mut sum = 0.0;
    for (&slope, &threshold) in slopes.iter().zip(thresholds) {
        let above = w - threshold;
        sum += slope * if above > 0.0 { above } else { 0.0 };
    }
    sum
}

fn asymmetry(w: @T) -> @T {
    if w < 0.0 {
        -dead_zones(&NEGATIVE_SLOPES, &NEGATIVE_THRESHOLDS_V, -w)
    } else {
        dead_zones(&POSITIVE_SLOPES, &POSITIVE_THRESHOLDS_V, w)
    }
}

fn asymmetry_inverse(w: @T) -> @T {
    if w < 0.0 {
        -dead_zones(&NEGATIVE_INVERSE_SLOPES, &NEGATIVE_INVERSE_THRESHOLDS_V, -w)
    } else {
        dead_zones(&POSITIVE_INVERSE_SLOPES, &POSITIVE_INVERSE_THRESHOLDS_V, w)
    }
}
";

const QUADRATIC: &str = "
/// w + q w^2, from the slope @LEAST on its tangent, and its slope.
fn @n(w: @T) -> (@T, @T) {
    let bend = @N * w;
    let slope = 1.0 + bend + bend;
    if slope >= @LEAST {
        return (w + bend * w, slope);
    }
    let edge = @N_EDGE_V;
    (edge + @BEND * edge + @LEAST * (w - edge), @LEAST)
}
";

const CUBIC: &str = "
/// w + c w^3@t, and its slope.
fn cubic(w: @T) -> (@T, @T) {
@e    (w + CUBIC * w * w * w, 1.0 + 3.0 * CUBIC * w * w)
}
";

const CUBIC_EDGE: &str = "    if magnitude(w) > CUBIC_EDGE_V {
        let edge = if w < 0.0 { -CUBIC_EDGE_V } else { CUBIC_EDGE_V };
        return (edge + CUBIC * edge * edge * edge + @LEAST * (w - edge), @LEAST);
    }
";

const NEWTON: &str = "
/// The w of a curvature that yields y.
fn undo(curvature: fn(@T) -> (@T, @T), y: @T) -> @T {
    let mut w = y;
    for _ in 0..@STEPS {
        let (value, slope) = curvature(w);
        w -= (value - y) / slope;
    }
    w
}
";

fn maps(model: &Exported<'_>) -> String {
    let mut text = String::new();
    if model.has_asymmetry() {
        text += ASYMMETRY;
    }
    let curvatures = curvatures(model);
    for name in &curvatures {
        let upper = name.to_uppercase();
        text += &match *name {
            "cubic" => {
                let edged = model.constants.iter().any(|c| c.name == "CUBIC_EDGE_V");
                let (tangent, edge) = match edged {
                    true => (", from the slope @LEAST on its tangent", CUBIC_EDGE),
                    false => ("", ""),
                };
                CUBIC.replace("@t", tangent).replace("@e", edge)
            }
            _ => QUADRATIC.replace("@n", name).replace("@N", &upper),
        };
    }
    if !curvatures.is_empty() {
        text += NEWTON;
    }
    text
}

fn forward(model: &Exported<'_>) -> String {
    let limited = model.effects().saturation.is_some();
    let (limit, drive) = match limited {
        true => (
            "
/// The drive within its limit; one that is not finite stays so.
fn limit(drive_v: @T) -> @T {
    if !drive_v.is_finite() {
        return drive_v;
    }
    let below = if drive_v < LIMIT_V { drive_v } else { LIMIT_V };
    if below > -LIMIT_V { below } else { -LIMIT_V }
}
",
            "limit(drive_v)",
        ),
        false => ("", "drive_v"),
    };
    let mut maps = String::new();
    if model.has_asymmetry() {
        maps += "        let w = asymmetry(w);\n";
    }
    for name in curvatures(model) {
        let _ = writeln!(maps, "        let (w, _) = {name}(w);");
    }
    format!(
        "{limit}
/// The model: drive to displacement.
#[derive(Clone, Copy, Debug)]
pub struct Model(Plays);

impl Model {{
    /// At rest, before the drive in V.
    pub fn start(drive_v: @T) -> Self {{
        Self(Plays::rest({drive}))
    }}

    /// Displacement in um for the next drive in V.
    pub fn step(&mut self, drive_v: @T) -> @T {{
        let w = self.0.step(WEIGHT_0, &WEIGHTS, &THRESHOLDS_V, BETA_PER_SAMPLE, {drive});
{maps}        OFFSET_UM + GAIN_UM_PER_V * w
    }}
}}
"
    )
}

fn inverse(model: &Exported<'_>) -> String {
    let mut maps = String::new();
    for name in curvatures(model).into_iter().rev() {
        let _ = writeln!(maps, "    let w = undo({name}, w);");
    }
    if model.has_asymmetry() {
        maps += "    let w = asymmetry_inverse(w);\n";
    }
    format!(
        "
/// Input of the inverse plays in V for a reference in um; not finite where that is not.
fn unshape(reference_um: @T) -> @T {{
    let w = (reference_um - OFFSET_UM) * PER_GAIN_V_PER_UM;
    if !w.is_finite() {{
        return w;
    }}
{maps}    w
}}

/// The explicit inverse: reference to drive.
#[derive(Clone, Copy, Debug)]
pub struct Inverse(Plays);

impl Inverse {{
    /// At rest, before the reference in um.
    pub fn start(reference_um: @T) -> Self {{
        Self(Plays::rest(unshape(reference_um)))
    }}

    /// Drive in V that brings the stage to the next reference in um.
    pub fn step(&mut self, reference_um: @T) -> @T {{
        self.0.step(
            INVERSE_WEIGHT_0,
            &INVERSE_WEIGHTS,
            &INVERSE_THRESHOLDS_V,
            INVERSE_BETA_PER_SAMPLE,
            unshape(reference_um),
        )
    }}
}}
"
    )
}
