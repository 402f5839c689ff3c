//! Where a residual lies: by time, frequency, drive, rate, branch, distance from the last turning
//! point, and what it goes along with.
//!
//! The gap is the mean square of the residual beyond the noise floor, every record with the same
//! weight. Along each axis the most telling stretch is the one whose share of the gap exceeds by most
//! the share that a gap without preference would have there: that of the samples, or, over
//! frequencies and records, that of the motion.

mod along;
mod correlation;
mod lines;
mod spectrum;
mod tally;
#[cfg(test)]
mod tests;

use crate::dataset::{LengthUnit, Role};
use crate::report::format_number;

use super::diagnosis::{Diagnosis, RecordResiduals, Residuals};
use crate::model_file::Stage;

use tally::{Class, Tally, richest};

/// A gap of less than this share of the noise, squares taken, has no place.
const NOTHING: f64 = 0.05;
/// Bins of an axis.
pub(super) const BINS: usize = 12;

/// An axis along which the gap was looked at.
#[derive(Clone, Debug)]
pub struct Place {
    /// Name of the axis.
    pub axis: &'static str,
    /// What was found, a sentence.
    pub summary: String,
    /// Share of the gap in the most telling stretch, 0 to 1.
    pub share: f64,
    /// By how much that exceeds the share it would have without any preference.
    pub telling: f64,
    /// What the position of a bin is, and its unit.
    pub along: (&'static str, &'static str),
    /// Whether positions are spread by their logarithm.
    pub log: bool,
    /// The bins in order.
    pub bins: Vec<Bin>,
}

/// A stretch of an axis.
#[derive(Clone, Debug)]
pub struct Bin {
    /// In words.
    pub label: String,
    /// Its middle; NaN for a class without a position.
    pub at: f64,
    /// Rms of the residual in it, in um; over frequencies, what it adds to the rms of all.
    pub rms_um: f64,
    /// What nine of ten resamplings lie in.
    pub band_um: (f64, f64),
    /// Its share of the gap.
    pub share: f64,
    /// The share it would have without any preference.
    pub expected: f64,
}

/// Where the baseline's residual lies, the most telling axis first. Report records are left out of
/// it. Empty where nothing exceeds the noise.
pub fn localise(diagnosis: &Diagnosis) -> Vec<Place> {
    let modes: Vec<f64> = diagnosis
        .model
        .stages
        .iter()
        .filter_map(|stage| match stage {
            Stage::Resonance(mode) => Some(mode.f_n_hz),
            _ => None,
        })
        .collect();
    places(&diagnosis.before, diagnosis.noise.0, &modes, diagnosis.unit)
}

/// The same of any residuals (um) with their noise (um, rms) and the modes (Hz) that are known.
pub fn places(residuals: &Residuals, noise_um: f64, modes: &[f64], unit: LengthUnit) -> Vec<Place> {
    let records: Vec<&RecordResiduals> = residuals
        .records
        .iter()
        .filter(|record| record.role != Role::Report && record.residual_um.len() > 1)
        .collect();
    let square: f64 = records.iter().map(|r| mean_square(&r.residual_um)).sum();
    let square = square / records.len().max(1) as f64;
    let gap = square - noise_um * noise_um;
    if records.is_empty() || gap <= NOTHING * noise_um * noise_um || gap <= 0.0 {
        return Vec::new();
    }
    let mut places: Vec<Place> = [
        spectrum::frequency(&records, noise_um, modes),
        along::within(&records, noise_um),
        along::over_records(&records, noise_um, unit),
        along::drive(&records, noise_um),
        along::rate(&records, noise_um),
        along::branch(&records, noise_um),
        along::turning(&records, noise_um),
        correlation::correlation(&records, noise_um),
    ]
    .into_iter()
    .flatten()
    .collect();
    places.sort_by(|a, b| b.telling.total_cmp(&a.telling));
    places
}

impl Place {
    /// A place from tallied classes with a label and a position each. `tell` makes the sentence from
    /// the first and last class of the richest stretch and its "78 % (70 to 84 %) of the gap lies".
    fn tallied(
        (axis, along, log): (&'static str, (&'static str, &'static str), bool),
        (tally, noise_um): (&Tally, f64),
        positions: Vec<(String, f64)>,
        tell: impl Fn(usize, usize, String) -> String,
    ) -> Option<Self> {
        let classes = tally.classes(noise_um, false);
        let (from, to, telling) = richest(&classes)?;
        let share = held(&classes, from, to);
        let band = tally.share_band(noise_um, |i| (from..=to).contains(&i));
        let expected: f64 = classes[from..=to].iter().map(|c| c.expected).sum();
        let lies = format!("{} of the gap lies", percent_in(share, band));
        let summary = if telling < 0.1 {
            format!("The gap is spread evenly over the {}.", along.0)
        } else {
            format!(
                "{}, in {} of the samples.",
                tell(from, to, lies),
                percent(expected)
            )
        };
        Some(Self {
            axis,
            summary,
            share,
            telling,
            along,
            log,
            bins: bins(&classes, positions),
        })
    }
}

fn bins(classes: &[Class], positions: Vec<(String, f64)>) -> Vec<Bin> {
    classes
        .iter()
        .zip(positions)
        .map(|(class, (label, at))| Bin {
            label,
            at,
            rms_um: class.rms_um,
            band_um: class.band_um,
            share: class.share,
            expected: class.expected,
        })
        .collect()
}

fn held(classes: &[Class], from: usize, to: usize) -> f64 {
    let share: f64 = classes[from..=to].iter().map(|c| c.share).sum();
    share.min(1.0)
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn percent_in(share: f64, (low, high): (f64, f64)) -> String {
    format!(
        "{} ({:.0} to {:.0} %)",
        percent(share),
        100.0 * low.min(share),
        100.0 * high.max(share)
    )
}

/// Three digits.
pub(in crate::discover) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format_number(value);
    }
    let digits = 10f64.powi(2 - value.abs().log10().floor() as i32);
    format_number((value * digits).round() / digits)
}

/// "below 3 V", "between 2 V and 3 V", "above 2 V", for bins `from` to `to` between `edges`.
fn stretch(edges: &[f64], from: usize, to: usize, unit: &str) -> String {
    let edge = |i: usize| format!("{} {unit}", short(edges[i]));
    match (from == 0, to + 2 == edges.len()) {
        (true, true) => "everywhere".to_owned(),
        (true, false) => format!("below {}", edge(to + 1)),
        (false, true) => format!("above {}", edge(from)),
        (false, false) => format!("between {} and {}", edge(from), edge(to + 1)),
    }
}

fn mean_square(values: &[f64]) -> f64 {
    values.iter().map(|e| e * e).sum::<f64>() / values.len().max(1) as f64
}

/// Frequencies in Hz and amplitudes in um of the lines of a record's residual.
pub fn amplitudes(record: &RecordResiduals) -> (Vec<f64>, Vec<f64>) {
    let Some(spectrum) = lines::Spectrum::new(record) else {
        return (Vec::new(), Vec::new());
    };
    let amplitude = |power: &f64| (2.0 * power).sqrt();
    let hz = (1..=spectrum.power.len()).map(|line| line as f64 * spectrum.step_hz);
    (hz.collect(), spectrum.power.iter().map(amplitude).collect())
}
