//! Writes a `model.toml` in one stable form.

use std::fmt::Write as _;

use super::{ModelFile, Stage, TwoSided};

/// Numbers on one line of an array; longer arrays are broken.
const NUMBERS_A_LINE: usize = 8;

impl ModelFile {
    /// The model as text that [`parse`](super::parse) reads back exactly; it ends with a line feed.
    ///
    /// Every number has the fewest digits that give the same `f64` again. All numbers must be finite.
    pub fn to_toml_string(&self) -> String {
        let mut text = format!(
            "format = \"hysteron-model\"\nversion = {}\nname = {}\n\n[units]\ntime = \"s\"\n\
             drive = \"V\"\ndisplacement = \"um\"\n",
            self.version,
            toml::Value::from(self.name.as_str()),
        );
        for stage in &self.stages {
            let keys = match stage {
                Stage::Hysteresis(hysteresis) => vec![
                    ("thresholds_v", array(&hysteresis.thresholds_v)),
                    ("weights", array(&hysteresis.weights)),
                    ("beta_s", number(hysteresis.beta_s)),
                ],
                Stage::Asymmetry(asymmetry) => vec![
                    ("thresholds", two_sided(&asymmetry.thresholds)),
                    ("slopes", two_sided(&asymmetry.slopes)),
                ],
                Stage::Output(output) => vec![
                    ("gain_um_per_v", number(output.gain_um_per_v)),
                    ("offset_um", number(output.offset_um)),
                ],
            };
            // Writing to a String cannot fail.
            let _ = write!(text, "\n[[stage]]\nname = \"{}\"\n", stage.name());
            for (key, value) in keys {
                let _ = writeln!(text, "{key} = {value}");
            }
        }
        text
    }
}

fn number(value: f64) -> String {
    format!("{value:?}")
}

fn array(values: &[f64]) -> String {
    let lines: Vec<_> = values
        .chunks(NUMBERS_A_LINE)
        .map(|line| {
            line.iter()
                .map(|&value| number(value))
                .collect::<Vec<_>>()
                .join(", ")
        })
        .collect();
    match lines.as_slice() {
        [] => "[]".to_owned(),
        [only] => format!("[{only}]"),
        _ => format!("[\n    {},\n]", lines.join(",\n    ")),
    }
}

fn two_sided(values: &TwoSided) -> String {
    format!(
        "{{ positive = {}, negative = {} }}",
        array(&values.positive),
        array(&values.negative)
    )
}
