//! The drives that are compared, and figures for each of them.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::references::Reference;
use crate::experiment::refused;
use crate::model_file::ModelFile;
use crate::stage;

/// One value for each way to make a drive from a reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PerDrive<T> {
    /// The reference in um taken as the drive in V: what the authors call "without the inverse".
    pub none: T,
    /// The reference over the slope of the stage while all plays slide, A_n.
    pub linear: T,
    /// The inverse without its rate term.
    pub rate_independent: T,
    /// The inverse with the rate of the reference.
    pub rate_dependent: T,
}

impl<T> PerDrive<T> {
    /// The same with `f` applied to each value.
    ///
    /// # Errors
    /// The first that `f` returns.
    pub fn try_map<U, E>(&self, f: impl Fn(&T) -> Result<U, E>) -> Result<PerDrive<U>, E> {
        Ok(PerDrive {
            none: f(&self.none)?,
            linear: f(&self.linear)?,
            rate_independent: f(&self.rate_independent)?,
            rate_dependent: f(&self.rate_dependent)?,
        })
    }
}

impl PerDrive<f64> {
    /// For each drive by itself: `pick` of the values of `all` in ascending order.
    pub fn over(all: &[Self], pick: impl Fn(&[f64]) -> f64) -> Self {
        let of = |value: fn(&Self) -> f64| {
            let mut values: Vec<f64> = all.iter().map(value).collect();
            values.sort_by(f64::total_cmp);
            pick(&values)
        };
        Self {
            none: of(|one| one.none),
            linear: of(|one| one.linear),
            rate_independent: of(|one| one.rate_independent),
            rate_dependent: of(|one| one.rate_dependent),
        }
    }
}

/// The drives in V for a reference in um, the inverses being those of `file`.
///
/// # Errors
/// A model that cannot be built or inverted.
pub fn drives(file: &ModelFile, reference: &Reference) -> Result<PerDrive<Vec<f64>>, Error> {
    let inverse = |file: &ModelFile| {
        let compensator = stage::compensator(file, reference.sample_time_s)?;
        stage::compensate(&compensator, &reference.samples).map_err(refused)
    };
    let (gain, offset) = file.output();
    let weights = file.hysteresis().map_or(&[][..], |h| &h.weights);
    let slope = gain * weights.iter().sum::<f64>();
    Ok(PerDrive {
        none: reference.samples.clone(),
        linear: reference
            .samples
            .iter()
            .map(|v| (v - offset) / slope)
            .collect(),
        rate_independent: inverse(&file.clone().rate_independent())?,
        rate_dependent: inverse(file)?,
    })
}
