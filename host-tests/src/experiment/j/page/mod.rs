//! The page of the experiment: what came out, beside what is printed.

mod errors;
mod inputs;
mod loops;
mod model;

use crate::report::{KeyFigure, Page, Tone, format_number};

use super::published::{ERROR_WITH_UM, ERROR_WITHOUT_UM};
use super::{Band, Plant, Results};

/// What the hysteresis of the model may differ from the published one, in points of percent.
const POINTS: f64 = 1.5;

/// The page.
pub fn page(results: &Results) -> Page {
    let mut page = Page::new("Paper J: rate-dependent Prandtl-Ishlinskii model and inverse");
    page.lead(
        "Al Janaideh & Krejci, IEEE/ASME Transactions on Mechatronics 18(5), 2013, computed from \
         code. The authors measured a piezo stage P-753.31C; here a simulated one is driven with \
         40 V, or asked for 40 µm, at 10 kHz.",
    );
    let (tone, text) = verdict(results);
    page.verdict(tone, text);
    page.figures(figures(results));
    page.section("Largest error against frequency", |section| {
        errors::fill(section, results)
    });
    page.section("Hysteresis", |section| loops::hysteresis(section, results));
    page.section("Triangles and two amplitudes", |section| {
        inputs::fill(section, results)
    });
    page.section("Constants of model and inverse", |section| {
        model::constants(section, results)
    });
    page.section("Identification from three loops", |section| {
        model::identification(section, results)
    });
    page.section("Worked example (section F)", |section| {
        loops::worked_example(section, results)
    });
    page
}

fn verdict(results: &Results) -> (Tone, String) {
    let apart = results
        .percents
        .iter()
        .map(|percent| (percent.model - percent.published).abs())
        .fold(0.0, f64::max);
    let ordered = [Plant::ModelOwnRate, Plant::StageLagRemoved]
        .into_iter()
        .flat_map(|plant| super::sweep::of_plant(&results.sweep, plant))
        .filter(|row| row.frequency_hz > 10.0)
        .all(|row| {
            let um = row.errors.largest_um;
            um.rate_dependent < um.rate_independent && um.rate_independent < um.none
        });
    let (_, stage) = band(results, Plant::StageLagRemoved);
    let (_, wrong) = band(results, Plant::StageWrongLagRemovedMedian);
    let text = format!(
        "The hysteresis of the corrected model is within {} points of the published. Without an \
         inverse the simulated stage errs by {} (published {}), under the rate-dependent inverse \
         by {}, and by {} where its parameters are 5 % off (published {}).",
        format_number((apart * 10.0).round() / 10.0),
        span(stage.least.none, stage.most.none),
        span(ERROR_WITHOUT_UM[0], ERROR_WITHOUT_UM[1]),
        span(stage.least.rate_dependent, stage.most.rate_dependent),
        span(wrong.least.rate_dependent, wrong.most.rate_dependent),
        span(ERROR_WITH_UM[0], ERROR_WITH_UM[1]),
    );
    let tone = if apart <= POINTS && ordered {
        Tone::Good
    } else {
        Tone::Bad
    };
    (tone, text)
}

/// A range as in a verdict, one decimal.
fn span(least: f64, most: f64) -> String {
    format!("{least:.1} to {most:.1} µm")
}

/// The band of a plant and its place in the JSON.
fn band(results: &Results, plant: Plant) -> (usize, Band) {
    results
        .bands
        .iter()
        .copied()
        .enumerate()
        .find(|(_, band)| band.plant == plant)
        .unwrap_or((0, results.bands[0]))
}

fn figures(results: &Results) -> Vec<KeyFigure> {
    let mut figures = Vec::new();
    for (i, percent) in results.percents.iter().enumerate() {
        let hz = format_number(percent.frequency_hz);
        for (key, what, value) in [
            ("model", "model", percent.model),
            (
                "stage_lag_removed",
                "simulated stage",
                percent.stage_lag_removed,
            ),
        ] {
            figures.push(
                KeyFigure::new(
                    format!("hysteresis_percent.{i}.{key}"),
                    format!("Hysteresis at {hz} Hz, {what}"),
                    value,
                    "%",
                )
                .note(format!("published {} %", format_number(percent.published))),
            );
        }
    }
    let [without, with] = [ERROR_WITHOUT_UM, ERROR_WITH_UM]
        .map(|[least, most]| format!("published {}", span(least, most)));
    for plant in [Plant::StageLagRemoved, Plant::StageWrongLagRemovedMedian] {
        let (i, band) = band(results, plant);
        for (end, which, um) in [
            ("least", "lowest", band.least),
            ("most", "highest", band.most),
        ] {
            for (drive, words, value, note) in [
                ("none", "no inverse", um.none, without.clone()),
                (
                    "rate_independent",
                    "rate-independent inverse",
                    um.rate_independent,
                    String::new(),
                ),
                (
                    "rate_dependent",
                    "rate-dependent inverse",
                    um.rate_dependent,
                    with.clone(),
                ),
            ] {
                figures.push(
                    KeyFigure::new(
                        format!("error_bands_um.{i}.{end}.{drive}"),
                        format!(
                            "Largest error, {which} over 0.05 to 100 Hz, {words}; {}",
                            plant.describe()
                        ),
                        value,
                        "um",
                    )
                    .note(note),
                );
            }
        }
    }
    for (i, example) in results.examples.iter().enumerate() {
        figures.push(
            KeyFigure::new(
                format!("example_f.{i}.identity_error_um"),
                format!(
                    "Model after inverse, worked example at {} Hz, largest error",
                    format_number(example.fundamental_hz)
                ),
                example.identity_error_um,
                "um",
            )
            .note("exact but for rounding, when both see one rate"),
        );
    }
    figures
}
