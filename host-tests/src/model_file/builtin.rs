//! Published models that come with the program.
//!
//! Source: M. Al Janaideh, P. Krejci, "Inverse rate-dependent Prandtl-Ishlinskii model for feedforward
//! compensation of hysteresis in a piezomicropositioning actuator", IEEE/ASME Transactions on
//! Mechatronics 18(5), 2013, doi 10.1109/TMECH.2012.2205265.

use std::path::Path;

use super::{Hysteresis, ModelFile, Stage, load};
use crate::error::{Error, quoted};

/// The names that [`builtin`] knows.
pub const BUILTIN_NAMES: [&str; 3] = ["p753", "p753-printed", "example-f"];

/// A model that comes with the program, by name; `None` for any other name.
///
/// - `p753`: the piezo stage P-753.31C with the constants that agree with the paper's own inverse.
/// - `p753-printed`: the same with a_0 and a_2 as printed, which contradict it.
/// - `example-f`: the worked example of the paper's section F.
pub fn builtin(name: &str) -> Option<ModelFile> {
    match name {
        "p753" => Some(rate_dependent(
            "P-753.31C, corrected constants",
            9.715,
            8.572e-4,
            vec![0.7236, 0.2906, 0.0416, 0.1512],
        )),
        "p753-printed" => Some(rate_dependent(
            "P-753.31C, constants as printed",
            9.715,
            8.572e-4,
            vec![0.7124, 0.2906, 0.0461, 0.1512],
        )),
        "example-f" => {
            let weight = |i: u32| {
                if i == 0 {
                    0.5
                } else {
                    0.5 * (-0.31 * f64::from(i)).exp()
                }
            };
            let weights = (0..=4).map(weight).collect();
            Some(rate_dependent("worked example F", 3.0, 7e-4, weights))
        }
        _ => None,
    }
}

/// A model by its built-in name or, for any other text, from the file of that path.
///
/// # Errors
/// Those of [`load`]; where there is no such file the message lists the built-in names.
pub fn resolve(name_or_path: &str) -> Result<ModelFile, Error> {
    if let Some(model) = builtin(name_or_path) {
        return Ok(model);
    }
    if !Path::new(name_or_path).exists() {
        return Err(Error::request(format!(
            "there is no model file {}; name a model.toml or a built-in model: {}",
            quoted(name_or_path),
            BUILTIN_NAMES.join(", "),
        )));
    }
    load(name_or_path)
}

/// A hysteresis stage alone, with thresholds alpha_i = zeta i.
fn rate_dependent(name: &str, zeta_v: f64, beta_s: f64, weights: Vec<f64>) -> ModelFile {
    let thresholds_v = (1..weights.len()).map(|i| zeta_v * i as f64).collect();
    ModelFile::new(
        name,
        vec![Stage::Hysteresis(Hysteresis {
            thresholds_v,
            weights,
            beta_s,
        })],
    )
}
