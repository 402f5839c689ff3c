//! The page of the experiment: what came out, beside what is printed.

mod errors;
mod inputs;
mod loops;
mod model;

use crate::report::{KeyFigure, Page, Tone, format_number};

use super::published::{ERROR_WITH_UM, ERROR_WITHOUT_UM};
use super::{Band, PerDrive, Plant, Results};

/// What the hysteresis of the model may differ from the published one, in points of percent.
const POINTS: f64 = 1.5;

/// A drive's figure.
type Of = fn(&PerDrive<f64>) -> f64;

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
        figures.push(
            KeyFigure::new(
                format!("hysteresis_percent.{i}.model"),
                format!(
                    "Hysteresis of the model at {} Hz",
                    format_number(percent.frequency_hz)
                ),
                percent.model,
                "%",
            )
            .note(format!("published {}", percent.published)),
        );
    }
    let mut error = |plant, drive: &str, words: &str, of: Of, published: Option<[f64; 2]>| {
        let (i, band) = band(results, plant);
        for (end, place, um) in [("least", "best", band.least), ("most", "worst", band.most)] {
            let figure = KeyFigure::new(
                format!("error_bands_um.{i}.{end}.{drive}"),
                format!("{words}: largest error at the {place} frequency"),
                of(&um),
                "um",
            );
            figures.push(match published {
                Some([least, most]) => {
                    let value = if end == "least" { least } else { most };
                    figure.note(format!("published {value:.1}"))
                }
                None => figure.note("not in the paper"),
            });
        }
    };
    let stage = Plant::StageLagRemoved;
    let wrong = Plant::StageWrongLagRemovedMedian;
    let (without, with) = (Some(ERROR_WITHOUT_UM), Some(ERROR_WITH_UM));
    error(stage, "none", "Stage, no inverse", |um| um.none, without);
    error(
        stage,
        "rate_independent",
        "Stage, rate-independent inverse",
        |um| um.rate_independent,
        None,
    );
    error(
        stage,
        "rate_dependent",
        "Stage, rate-dependent inverse",
        |um| um.rate_dependent,
        with,
    );
    error(
        wrong,
        "rate_dependent",
        "Stage 5 % off, rate-dependent inverse",
        |um| um.rate_dependent,
        with,
    );
    for (i, example) in results.examples.iter().enumerate() {
        figures.push(
            KeyFigure::new(
                format!("example_f.{i}.identity_error_um"),
                format!(
                    "Model after inverse, worked example at {} Hz",
                    format_number(example.fundamental_hz)
                ),
                example.identity_error_um,
                "um",
            )
            .note("largest error; both see one rate"),
        );
    }
    figures
}
