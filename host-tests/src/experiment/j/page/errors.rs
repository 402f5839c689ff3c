//! Largest error against frequency: plots, table, and why it is not what was measured.

use crate::experiment::j::published::{ERROR_WITH_UM, ERROR_WITHOUT_UM};
use crate::experiment::j::sweep::{FREQUENCIES_HZ, of_plant};
use crate::experiment::j::{PerDrive, Plant, Results};
use crate::report::{Axis, Cell, Plot, Section, Series, Style, format_number};

/// Plots, table, reasons.
pub fn fill(section: &mut Section, results: &Results) {
    section.paragraph(
        "Largest distance from a sine of 40 µm over the second of two periods from rest. \
         \"No inverse\" is what the authors did: the reference in µm is the drive in V. Below 1 Hz \
         2000 samples a period are taken, above it 10 kHz.",
    );
    section.plot(ways(results));
    section.plot(plants(results));
    table(section, results);
    section.paragraph("Why the figures are not the published ones:");
    section.list(reasons(results));
}

fn column(results: &Results, plant: Plant, of: fn(&PerDrive<f64>) -> f64) -> Vec<f64> {
    of_plant(&results.sweep, plant)
        .map(|row| of(&row.errors.largest_um))
        .collect()
}

fn empty_plot(title: &str) -> Plot {
    Plot::new(
        title,
        Axis::log("Frequency", "Hz"),
        Axis::linear("Largest error", "um").including(0.0),
    )
}

fn line(label: &str, values: &[f64]) -> Series {
    Series::new(label, Style::LinePoints, &FREQUENCIES_HZ, values)
}

fn ways(results: &Results) -> Plot {
    let stage = |of| column(results, Plant::StageLagRemoved, of);
    let [least, most] = ERROR_WITHOUT_UM;
    empty_plot("Simulated stage, lag removed")
        .caption("Three drives for one reference; the published range without the inverse.")
        .series(line("no inverse", &stage(|um| um.none)))
        .series(line(
            "rate-independent inverse",
            &stage(|um| um.rate_independent),
        ))
        .series(line(
            "rate-dependent inverse",
            &stage(|um| um.rate_dependent),
        ))
        .series(Series::level("published without, lowest", least))
        .series(Series::level("published without, highest", most))
}

fn plants(results: &Results) -> Plot {
    let inverse = |plant| column(results, plant, |um| um.rate_dependent);
    let identified: Vec<f64> = results
        .identification
        .largest_error_um
        .iter()
        .map(|at| at.rate_dependent)
        .collect();
    let [least, most] = ERROR_WITH_UM;
    let mut plot = empty_plot("Rate-dependent inverse")
        .caption("What the inverse leaves on different stages; the published range with it.");
    for plant in [
        Plant::ModelOwnRate,
        Plant::StageLagRemoved,
        Plant::StageWrongLagRemovedMedian,
        Plant::StageWrongLagRemovedWorst,
    ] {
        plot = plot.series(line(plant.describe(), &inverse(plant)));
    }
    plot.series(line(
        "simulated stage, its own identified model",
        &identified,
    ))
    .series(Series::level("published with, lowest", least))
    .series(Series::level("published with, highest", most))
}

fn table(section: &mut Section, results: &Results) {
    let columns: [Vec<f64>; 8] = [
        column(results, Plant::ModelSameRate, |um| um.rate_dependent),
        column(results, Plant::ModelOwnRate, |um| um.none),
        column(results, Plant::ModelOwnRate, |um| um.rate_independent),
        column(results, Plant::ModelOwnRate, |um| um.rate_dependent),
        column(results, Plant::StageLagRemoved, |um| um.none),
        column(results, Plant::StageLagRemoved, |um| um.rate_independent),
        column(results, Plant::StageLagRemoved, |um| um.rate_dependent),
        column(results, Plant::StageWrongMedian, |um| um.rate_dependent),
    ];
    section.paragraph(
        "In µm. Model: the published one with corrected weights, its thresholds moved by the rate \
         of its own drive, in the column \"one rate\" by that of the reference. Stage: simulated, \
         lag removed. \"5 % off\": nine stages with wrong parameters, median, the lag left in.",
    );
    section.table(
        [
            "Hz",
            "One rate, rate-dep.",
            "Model, none",
            "rate-indep.",
            "rate-dep.",
            "Stage, none",
            "rate-indep.",
            "rate-dep.",
            "5 % off, rate-dep.",
        ],
        FREQUENCIES_HZ.iter().enumerate().map(|(i, &hz)| {
            let mut row: Vec<Cell> = vec![hz.into()];
            row.extend(columns.iter().map(|column| Cell::Number(column[i])));
            row
        }),
    );
}

fn reasons(results: &Results) -> Vec<String> {
    let n = hundredths;
    let last = FREQUENCIES_HZ.len() - 1;
    let model = results.constants.corrected.hysteresis();
    let slope: f64 = model.map_or(f64::NAN, |h| h.weights.iter().sum());
    let of = |plant, drive| column(results, plant, drive);
    let own = of(Plant::ModelOwnRate, |um| um.rate_dependent);
    let simple = of(Plant::ModelOwnRate, |um| um.rate_independent);
    let line = of(Plant::ModelOwnRate, |um| um.linear);
    let stage = of(Plant::StageLagRemoved, |um| um.rate_dependent);
    let raw = of(Plant::Stage, |um| um.rate_dependent);
    let wrong = of(Plant::StageWrongLagRemovedMedian, |um| um.rate_dependent);
    vec![
        format!(
            "The rate. The inverse is exact where model and inverse see one rate. A stage widens \
             with the rate of its own drive, of which the inverse only knows the reference: \
             that alone leaves {} µm at 100 Hz on the model itself, {} at 50 Hz, {} at 1 Hz \
             (rate-independent inverse: {} at 100 Hz). The published error at 100 Hz is lower, \
             which suggests that the measured stage followed the rate of its own drive less \
             strictly than the model does.",
            n(own[last]),
            n(own[8]),
            n(own[3]),
            n(simple[last]),
        ),
        format!(
            "The model. A perfect model would leave next to nothing at 0.05 Hz, where the authors \
             still had 1.0 µm or more. Three plays for the spread thresholds of the simulated \
             stage leave {}; parameters that are 5 % off leave {}. Creep and drift, which a \
             measured stage has, are not simulated.",
            n(stage[0]),
            n(wrong[0]),
        ),
        format!(
            "The lag. The authors took the amplifier's lag (0.5° at 50 Hz, 1.5° at 100 Hz) out of \
             the measured displacement by hand, and so is it done in the figures headed \"lag \
             removed\". Left in, the stage errs by {} instead of {} µm at 100 Hz: the two \
             errors partly cancel.",
            n(raw[last]),
            n(stage[last]),
        ),
        format!(
            "Without inverse. The authors subtract displacement from input voltage, so a volt \
             stands for a micrometre. That suits this stage: the slope for sliding plays, {} \
             µm/V, would give {} µm at 1 Hz and {} at 100 Hz.",
            format_number(slope),
            n(line[3]),
            n(line[last]),
        ),
    ]
}

/// An error in um as it is worth reading: hundredths, where it is small two digits.
fn hundredths(um: f64) -> String {
    if um >= 0.1 {
        format!("{um:.2}")
    } else {
        format_number(format!("{um:.1e}").parse().unwrap_or(um))
    }
}
