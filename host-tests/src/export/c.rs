//! The header in C99.

use std::fmt::Write as _;

use super::{Exported, NEWTON_STEPS, Precision, SLOPE_LEAST, Value, edge_bend};

/// Numbers on one line of an array.
const NUMBERS_A_LINE: usize = 4;

/// The text of the header.
pub(super) fn text(model: &Exported<'_>) -> String {
    let upper = model.options.prefix.to_uppercase();
    let body = format!(
        "{}{}{}{}{}",
        constants(model),
        HYSTERESIS,
        maps(model),
        forward(model),
        inverse(model),
    );
    let text = format!("{}{body}\n#endif /* @P_H */\n", opening(model));
    let real = match model.options.precision {
        Precision::Single => "float",
        Precision::Double => "double",
    };
    text.replace("@P", &upper)
        .replace("@p", &model.options.prefix)
        .replace("@T", real)
        .replace("@STEPS", &NEWTON_STEPS.to_string())
        .replace("@LEAST", &SLOPE_LEAST.to_string())
        .replace("@BEND", &edge_bend().to_string())
}

fn opening(model: &Exported<'_>) -> String {
    let left = match model.left.as_slice() {
        [] => String::new(),
        left => format!(" *\n * Not computed, numbers alone: {}.\n", left.join(", ")),
    };
    format!(
        "/*\n * {}\n *\n * Model of a piezo stage and its explicit inverse, for samples {} s apart: drive in V,\n \
         * displacement in um. Set a state with _start, then call _step once a sample. A sample that\n \
         * is not finite is taken as the one before. Not to be compiled with -ffast-math.\n{left} */\n\
         #ifndef @P_H\n#define @P_H\n\n",
        model.title, model.options.sample_time_s
    )
}

fn constants(model: &Exported<'_>) -> String {
    let mut text = String::new();
    let suffix = match model.options.precision {
        Precision::Single => "f",
        Precision::Double => "",
    };
    let number = |value: f64| format!("{}{suffix}", model.number(value));
    for constant in &model.constants {
        let (name, what) = (&constant.name, &constant.what);
        // Writing to a String cannot fail.
        let _ = match &constant.value {
            Value::Count(count) => writeln!(text, "/* {what} */\n#define @P_{name} {count}"),
            Value::Number(value) => {
                writeln!(text, "/* {what} */\n#define @P_{name} ({})", number(*value))
            }
            Value::Array(values) => {
                let lines: Vec<String> = values
                    .chunks(NUMBERS_A_LINE)
                    .map(|line| {
                        line.iter()
                            .map(|&v| number(v))
                            .collect::<Vec<_>>()
                            .join(", ")
                    })
                    .collect();
                writeln!(
                    text,
                    "/* {what} */\nstatic const @T @p_{}[{}] = {{\n    {}\n}};",
                    name.to_lowercase(),
                    values.len(),
                    lines.join(",\n    ")
                )
            }
        };
    }
    text
}

const HYSTERESIS: &str = "
/* Outputs of the plays in V, and the input before. */
typedef struct {
    @T z[@P_PLAYS];
    @T previous;
} @p_state;

/* direct u + sum of the weighted plays, which follow u between envelopes that open with its rate. */
static inline @T @p_plays(@p_state *state, @T direct, const @T *weights,
                          const @T *thresholds, @T beta, @T u)
{
    @T opened, sum;
    int i;
    if (!(u - u == 0)) {
        u = state->previous;
    }
    opened = u - state->previous;
    opened = beta * (opened < 0 ? -opened : opened);
    state->previous = u;
    sum = direct * u;
    for (i = 0; i < @P_PLAYS; i++) {
        const @T high = (u + opened) + thresholds[i];
        const @T low = (u - opened) - thresholds[i];
        @T z = state->z[i];
        z = z < high ? z : high;
        z = z > low ? z : low;
        state->z[i] = z;
        sum += weights[i] * z;
    }
    return sum;
}

static inline void @p_rest(@p_state *state, @T input)
{
    int i;
    for (i = 0; i < @P_PLAYS; i++) {
        state->z[i] = 0;
    }
    state->previous = input - input == 0 ? input : 0;
}
";

const DEAD_ZONES: &str = "
/* Sum of slopes above thresholds, for w >= 0. */
static inline @T @p_dead_zones(const @T *slopes, const @T *thresholds, int count, @T w)
{
    @T sum = slopes[0] * w;
    int i;
    for (i = 1; i < count; i++) {
        const @T above = w - thresholds[i];
        sum += slopes[i] * (above > 0 ? above : 0);
    }
    return sum;
}

static inline @T @p_asymmetry(@T w)
{
    return w < 0 ? -@p_dead_zones(@p_negative_slopes, @p_negative_thresholds_v, @P_NEGATIVE_CORNERS, -w)
                 : @p_dead_zones(@p_positive_slopes, @p_positive_thresholds_v, @P_POSITIVE_CORNERS, w);
}

static inline @T @p_asymmetry_inverse(@T w)
{
    return w < 0 ? -@p_dead_zones(@p_negative_inverse_slopes, @p_negative_inverse_thresholds_v,
                                  @P_NEGATIVE_CORNERS, -w)
                 : @p_dead_zones(@p_positive_inverse_slopes, @p_positive_inverse_thresholds_v,
                                 @P_POSITIVE_CORNERS, w);
}
";

const QUADRATIC: &str = "
/* w + q w^2, from the slope @LEAST on its tangent. */
static inline @T @p_@n(@T w, @T *slope)
{
    const @T bend = @P_@N * w;
    const @T edge = @P_@N_EDGE_V;
    *slope = 1 + bend + bend;
    if (*slope >= (@T)@LEAST) {
        return w + bend * w;
    }
    *slope = (@T)@LEAST;
    return edge + (@T)@BEND * edge + *slope * (w - edge);
}
";

const CUBIC: &str = "
/* w + c w^3@t. */
static inline @T @p_cubic(@T w, @T *slope)
{
@e    *slope = 1 + 3 * @P_CUBIC * w * w;
    return w + @P_CUBIC * w * w * w;
}
";

const CUBIC_EDGE: &str = "    const @T edge = w < 0 ? -@P_CUBIC_EDGE_V : @P_CUBIC_EDGE_V;
    if ((w < 0 ? -w : w) > @P_CUBIC_EDGE_V) {
        *slope = (@T)@LEAST;
        return edge + @P_CUBIC * edge * edge * edge + *slope * (w - edge);
    }
";

const NEWTON: &str = "
static inline @T @p_@n_inverse(@T y)
{
    @T w = y;
    int i;
    for (i = 0; i < @STEPS; i++) {
        @T slope;
        const @T off = @p_@n(w, &slope) - y;
        w -= off / slope;
    }
    return w;
}
";

fn maps(model: &Exported<'_>) -> String {
    let mut text = String::new();
    if model.has_asymmetry() {
        text += DEAD_ZONES;
    }
    for name in curvatures(model) {
        let upper = name.to_uppercase();
        text += &match name {
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
        text += &NEWTON.replace("@n", name);
    }
    text
}

/// The curvatures that are there, in the order of the signal.
pub(super) fn curvatures(model: &Exported<'_>) -> Vec<&'static str> {
    let has = |name: &str| {
        let upper = name.to_uppercase();
        model
            .constants
            .iter()
            .any(|constant| constant.name == upper)
    };
    let all = ["quadratic", "cubic", "output_quadratic"];
    all.into_iter().filter(|name| has(name)).collect()
}

fn forward(model: &Exported<'_>) -> String {
    let limit = match model.effects().saturation {
        Some(_) => {
            "    if (drive_v - drive_v == 0) {\n        \
             drive_v = drive_v < @P_LIMIT_V ? drive_v : @P_LIMIT_V;\n        \
             drive_v = drive_v > -@P_LIMIT_V ? drive_v : -@P_LIMIT_V;\n    }\n"
        }
        None => "",
    };
    let curvatures = curvatures(model);
    let slope = if curvatures.is_empty() {
        ""
    } else {
        "    @T slope;\n"
    };
    let mut maps = String::new();
    if model.has_asymmetry() {
        maps += "    w = @p_asymmetry(w);\n";
    }
    for name in curvatures {
        let _ = writeln!(maps, "    w = @p_{name}(w, &slope);");
    }
    format!(
        "
/* State of the model at rest, before the drive in V. */
static inline void @p_model_start(@p_state *state, @T drive_v)
{{
{limit}    @p_rest(state, drive_v);
}}

/* Displacement in um for the next drive in V. */
static inline @T @p_model_step(@p_state *state, @T drive_v)
{{
    @T w;
{slope}{limit}    w = @p_plays(state, @P_WEIGHT_0, @p_weights, @p_thresholds_v, @P_BETA_PER_SAMPLE, drive_v);
{maps}    return @P_OFFSET_UM + @P_GAIN_UM_PER_V * w;
}}
"
    )
}

fn inverse(model: &Exported<'_>) -> String {
    let mut maps = String::new();
    for name in curvatures(model).into_iter().rev() {
        let _ = writeln!(maps, "    w = @p_{name}_inverse(w);");
    }
    if model.has_asymmetry() {
        maps += "    w = @p_asymmetry_inverse(w);\n";
    }
    format!(
        "
/* Input of the inverse plays in V for a reference in um; not finite where that is not. */
static inline @T @p_unshape(@T reference_um)
{{
    @T w = (reference_um - @P_OFFSET_UM) * @P_PER_GAIN_V_PER_UM;
    if (!(w - w == 0)) {{
        return w;
    }}
{maps}    return w;
}}

/* State of the inverse at rest, before the reference in um. */
static inline void @p_inverse_start(@p_state *state, @T reference_um)
{{
    @p_rest(state, @p_unshape(reference_um));
}}

/* Drive in V that brings the stage to the next reference in um. */
static inline @T @p_inverse_step(@p_state *state, @T reference_um)
{{
    return @p_plays(state, @P_INVERSE_WEIGHT_0, @p_inverse_weights, @p_inverse_thresholds_v,
                    @P_INVERSE_BETA_PER_SAMPLE, @p_unshape(reference_um));
}}
"
    )
}
