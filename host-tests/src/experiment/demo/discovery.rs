//! The end of the demonstration: an effect is hidden in another stage, found, named and added.

use serde_json::{Value, json};

use crate::dataset::{Role, Zero};
use crate::discover::{Diagnosis, Options, RecordResiduals, Residuals, diagnose};
use crate::error::Error;
use crate::metrics::rms_error;
use crate::model_file::ModelFile;
use crate::plant::hidden::{Choice, Effect, HiddenCase, HiddenPlant, Protocol, Tier, Truth};
use crate::report::{Axis, KeyFigure, Page, Plot, Series, Style, format_number};
use crate::stage;

use super::super::references::{Grid, sine};
use super::super::refused;

/// Effects that a compensator undoes and any stage can have: one of them is hidden.
const HIDEABLE: [Effect; 11] = [
    Effect::AmplifierLag,
    Effect::TransportDelay,
    Effect::Congruency,
    Effect::Asymmetry,
    Effect::Quadratic,
    Effect::Cubic,
    Effect::Backlash,
    Effect::Resonance,
    Effect::Creep,
    Effect::Interleaving,
    Effect::SensorLag,
];
/// Size of the effect and of the noise, percent of the stroke.
const STRENGTH: f64 = 1.5;
const NOISE: f64 = 0.05;
/// Share of the stage's travel that the reference sweeps, and its frequency as a share of the highest
/// that the stage was measured at.
const SWEPT: f64 = 0.6;
const FREQUENCY: f64 = 0.5;
/// Periods of the reference; those in which it grows are not scored.
const PERIODS: usize = 6;
/// Periods in which it grows to its amplitude: no stage with a mode follows a sudden start.
const GROWS: usize = 2;

/// An effect that was hidden and looked for.
#[derive(Clone, Debug)]
pub struct Discovery {
    /// What was hidden.
    pub truth: Truth,
    /// What was found.
    pub found: Diagnosis,
    /// Time along the reference in s.
    pub time_s: Vec<f64>,
    /// Reference less displacement in um, driven by the baseline's model.
    pub before_um: Vec<f64>,
    /// The same, driven by the extended model.
    pub after_um: Vec<f64>,
    /// Rms of both where the reference has its full amplitude, um.
    pub rms_um: [f64; 2],
    /// Frequency of the reference in Hz.
    pub frequency_hz: f64,
}

/// Hides an effect drawn by the seed in a stage of tier 2 drawn by it too, diagnoses its records of the
/// given protocol, and drives the stage by the model before and after.
///
/// # Errors
/// Those of [`diagnose`], and models that cannot be inverted.
pub fn discover(
    seed: u64,
    protocol: Protocol,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Discovery, Error> {
    let effect = HIDEABLE[(seed % HIDEABLE.len() as u64) as usize];
    let case = HiddenCase {
        choice: Choice::Named(vec![effect]),
        seed,
        protocol,
        tier: Tier::Finer,
        strength: STRENGTH,
        noise_percent: NOISE,
        ..HiddenCase::default()
    };
    progress("hiding an effect");
    let hidden = case.make()?;
    let found = diagnose(&hidden.dataset, &Options::default(), progress)?;
    progress("driving the stage before and after");
    let plant = &hidden.plant;
    let sample_time_s = 1.0 / plant.setup.sample_rate_hz;
    let (least, most) = travel(&found.baseline_model, plant);
    let frequency_hz = FREQUENCY * plant.setup.top_hz;
    let grid = Grid::for_cycles(sample_time_s, frequency_hz, PERIODS as f64).map_err(refused)?;
    let half = 0.5 * SWEPT * (most - least);
    let tone = sine(&grid, half, frequency_hz, 0.0).map_err(refused)?;
    let middle = 0.5 * (least + most);
    let settled = (GROWS as f64 / (frequency_hz * sample_time_s)).round() as usize;
    let reference_um: Vec<f64> = tone
        .samples
        .iter()
        .enumerate()
        .map(|(k, y)| middle + grown(k as f64 / settled as f64) * y)
        .collect();
    let follow = |model: &ModelFile| errors(plant, model, sample_time_s, &reference_um);
    let before_um = follow(&found.baseline_model)?;
    let after_um = follow(&found.model)?;
    let rms = |errors: &[f64]| {
        let scored = errors.get(settled..).unwrap_or_default();
        rms_error(scored, &vec![0.0; scored.len()]).map_err(refused)
    };
    Ok(Discovery {
        rms_um: [rms(&before_um)?, rms(&after_um)?],
        time_s: (0..before_um.len())
            .map(|k| k as f64 * sample_time_s)
            .collect(),
        truth: hidden.truth,
        found,
        before_um,
        after_um,
        frequency_hz,
    })
}

/// From 0 at 0 to 1 at 1 and beyond, with two smooth derivatives.
fn grown(share: f64) -> f64 {
    let x = share.min(1.0);
    x * x * x * (10.0 + x * (6.0 * x - 15.0))
}

/// Displacement at both ends of the drive's range by a model's mean gain, um.
fn travel(model: &ModelFile, plant: &HiddenPlant) -> (f64, f64) {
    let (gain, offset) = model.output();
    let weights = model
        .hysteresis()
        .map_or(1.0, |core| core.weights.iter().sum());
    let at = |volts: f64| gain * weights * volts + offset;
    (at(plant.setup.drive_min_v), at(plant.setup.drive_max_v))
}

/// Reference less displacement of the stage under the drive that a model computes for it. What moves
/// is the stage itself, not the reading of its sensor; where the sensor's zero is arbitrary, it is set
/// at the first sample.
fn errors(
    plant: &HiddenPlant,
    model: &ModelFile,
    sample_time_s: f64,
    reference_um: &[f64],
) -> Result<Vec<f64>, Error> {
    let setup = &plant.setup;
    let drive: Vec<f64> = stage::drive_ahead(model, sample_time_s, reference_um)?
        .into_iter()
        .map(|volts| volts.clamp(setup.drive_min_v, setup.drive_max_v))
        .collect();
    let displacement = plant.without_sensor().run(&drive, sample_time_s);
    let zero = match (setup.zero, reference_um.first(), displacement.first()) {
        (Zero::PerRecord, Some(wanted), Some(y)) => y - wanted,
        _ => 0.0,
    };
    Ok(reference_um
        .iter()
        .zip(displacement)
        .map(|(wanted, y)| wanted - (y - zero))
        .collect())
}

impl Discovery {
    /// Names of what was found.
    pub fn named(&self) -> String {
        let names: Vec<&str> = self
            .found
            .effects
            .iter()
            .map(|one| one.effect.name())
            .collect();
        if names.is_empty() {
            "nothing".to_owned()
        } else {
            names.join(", ")
        }
    }

    /// The discovery in `demo.json`; lengths in um.
    pub fn to_json(&self) -> Value {
        let found = &self.found;
        json!({
            "seed": self.truth.seed,
            "hidden": self.truth.effects,
            "verdict": found.verdict,
            "named": found.effects.iter().map(|one| one.effect.name()).collect::<Vec<_>>(),
            "noise_um": found.noise.0,
            "report_rms_um": {
                "baseline": found.baseline.report,
                "extended": found.extended.report,
            },
            "closed": found.closed(),
            "tracking_rms_um": { "baseline": self.rms_um[0], "extended": self.rms_um[1] },
        })
    }

    /// What the verdict of the page says about it.
    pub(super) fn sentence(&self) -> String {
        let found = &self.found;
        let gap = match (found.baseline.report, found.extended.report) {
            (Some(before), Some(after)) => format!(
                "; on held-out records the rms goes from {} to {} um",
                format_number(before),
                format_number(after)
            ),
            _ => String::new(),
        };
        format!(
            " In another stage hides {}; named: {}{gap}.",
            self.truth.effects.join(", "),
            self.named()
        )
    }

    /// The lines of the summary on the terminal.
    pub fn summary(&self) -> Vec<String> {
        let found = &self.found;
        let um = |value: Option<f64>| value.map_or("none".to_owned(), |um| format!("{um:.3}"));
        let [before, after] = self.rms_um;
        vec![
            format!(
                "hidden in another stage (--seed {}): {}; named: {}",
                self.truth.seed,
                self.truth.effects.join(", "),
                self.named()
            ),
            format!(
                "gap on held-out records (rms um, noise {:.3}): {} before, {} after",
                found.noise.0,
                um(found.baseline.report),
                um(found.extended.report),
            ),
            format!("compensated tracking error (rms um): {before:.3} before, {after:.3} after"),
        ]
    }

    /// Its figures.
    pub(super) fn figures(&self) -> Vec<KeyFigure> {
        let found = &self.found;
        let mut figures = Vec::new();
        let figure = |key: &str, what: &str, um: f64| {
            KeyFigure::new(format!("discovery.{key}"), what, um, "um")
        };
        for (key, what, um) in [
            (
                "report_rms_um.baseline",
                "Hidden effect: model against report records before, rms",
                found.baseline.report,
            ),
            (
                "report_rms_um.extended",
                "Hidden effect: the same after, rms",
                found.extended.report,
            ),
        ] {
            figures.extend(um.map(|um| figure(key, what, um)));
        }
        for (key, what, um) in [
            ("baseline", "before", self.rms_um[0]),
            ("extended", "after", self.rms_um[1]),
        ] {
            figures.push(figure(
                &format!("tracking_rms_um.{key}"),
                &format!("Hidden effect: compensated tracking error {what}, rms"),
                um,
            ));
        }
        figures
    }

    /// Its section of the page.
    pub(super) fn show(&self, page: &mut Page) {
        page.section("An effect is hidden, found, named, added", |section| {
            section.paragraph(format!(
                "In another stage an effect was hidden, drawn from those that can be compensated (--seed {} \
                 draws it again): {}. The diagnosis, which sees the records alone, named: {}. The \
                 baseline is hysteresis with its rate term; the extended model has what was named besides.",
                self.truth.seed,
                self.truth.effects.join(", "),
                self.named(),
            ));
            if let Some((before, after)) = self.worst_record() {
                section.plot(
                    Plot::new(
                        format!("The gap, {} (report)", before.name),
                        Axis::linear("Time", "s"),
                        Axis::linear("Measured − model", "um"),
                    )
                    .series(residual("before", before))
                    .series(residual("after", after)),
                );
            }
            section.paragraph(format!(
                "The stage is then driven along a sine of {:.0} Hz by the inverse of each model. The \
                 first {GROWS} periods, in which it grows, are drawn but not scored.",
                self.frequency_hz
            ));
            section.plot(
                Plot::new(
                    format!("Error of compensation, sine of {:.0} Hz", self.frequency_hz),
                    Axis::linear("Time", "s"),
                    Axis::linear("Reference − displacement", "um"),
                )
                .series(Series::new("before", Style::Solid, &self.time_s, &self.before_um))
                .series(Series::new("after", Style::Solid, &self.time_s, &self.after_um)),
            );
        });
    }

    /// The report record of which the baseline leaves most, before and after.
    fn worst_record(&self) -> Option<(&RecordResiduals, &RecordResiduals)> {
        let records = |residuals: &Residuals| residuals.records.len();
        if records(&self.found.before) != records(&self.found.after) {
            return None;
        }
        let square = |record: &RecordResiduals| {
            let sum: f64 = record.residual_um.iter().map(|e| e * e).sum();
            sum / record.residual_um.len().max(1) as f64
        };
        let before = self.found.before.records.iter();
        before
            .zip(&self.found.after.records)
            .filter(|(before, _)| before.role == Role::Report)
            .max_by(|a, b| square(a.0).total_cmp(&square(b.0)))
    }
}

fn residual(label: &str, record: &RecordResiduals) -> Series {
    let time_s: Vec<f64> = (0..record.residual_um.len())
        .map(|k| record.start_s + k as f64 * record.sample_time_s)
        .collect();
    Series::new(label, Style::Solid, &time_s, &record.residual_um)
}
