//! Writes a `model.toml` in one stable form.

use std::fmt::Write as _;

use super::{Harmonics, Law, ModelFile, Stage, TwoSided};

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
                Stage::ModifiedPlay(model) => {
                    let harmonics = match model.harmonics {
                        Harmonics::Printed => "printed",
                        Harmonics::Corrected => "corrected",
                    };
                    let law = match model.law {
                        Law::Printed => "printed",
                        Law::Exact => "exact",
                    };
                    vec![
                        ("sample_time_s", number(model.sample_time_s)),
                        ("u_max_v", number(model.u_max_v)),
                        ("slopes_um_per_v", array(&model.slopes_um_per_v)),
                        ("offset_um", number(model.offset_um)),
                        ("alpha_s", number(model.alpha_s)),
                        ("beta_s", number(model.beta_s)),
                        ("interleaving_per_v", number(model.interleaving_per_v)),
                        ("feedback", array(&model.feedback)),
                        ("frequency_hz", number(model.frequency_hz)),
                        ("harmonics", format!("\"{harmonics}\"")),
                        ("sine", array(&model.sine)),
                        ("cosine", array(&model.cosine)),
                        ("law", format!("\"{law}\"")),
                    ]
                }
                effect => effect
                    .effect_numbers()
                    .into_iter()
                    .map(|(key, value)| (key, number(value)))
                    .collect(),
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
