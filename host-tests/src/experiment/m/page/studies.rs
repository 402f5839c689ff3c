//! The paper's choices one at a time.

use crate::experiment::m::studies::LOOKED_AT_HZ;
use crate::experiment::m::{Compared, Plane, Results, Score};
use crate::report::{Cell, Section, format_number};

/// What the harmonic terms hold and what they do.
pub fn harmonic_terms(section: &mut Section, results: &Results) {
    section.paragraph(
        "Published: the terms in sine and cosine capture the odd harmonics. Under u = sin φ the \
         printed ones, odd powers of u times sin φ or cos φ, hold even harmonics only, and a mean. \
         Even powers of u in their place hold the first, third and fifth. Amplitudes at 25 Hz:",
    );
    section.table(
        ["Form", "Term", "Mean", "1", "2", "3", "4", "5", "6"],
        results.studies.harmonic_terms.iter().map(|content| {
            let amplitudes = content.amplitudes.iter();
            // What rounding leaves is nothing.
            let shown = amplitudes.map(|&a| Cell::Number(if a < 1e-9 { 0.0 } else { a }));
            [Cell::from(content.form), Cell::from(content.coefficient)]
                .into_iter()
                .chain(shown)
                .collect()
        }),
    );
    section.paragraph(
        "In the model the odd harmonics come from the plays and the output feedback. On this bimorph, \
         which has even harmonics too, the printed terms are of use for those, and the corrected ones \
         are no remedy: identified at full drive, a fixed 75 Hz signal is added to the model whatever \
         the drive, and its inverse takes it off at a smaller drive where it is not there. Recursive \
         identification, free run; errors of the printed law:",
    );
    let um = |mm: f64| Cell::Number(1e3 * mm);
    section.table(
        [
            "Hz",
            "Fitting, printed (%)",
            "Fitting, corrected (%)",
            "Rms error, printed (µm)",
            "Rms error, corrected (µm)",
        ],
        results
            .studies
            .printed_and_corrected
            .iter()
            .map(|at: &Compared| {
                vec![
                    at.frequency_hz.into(),
                    at.printed.fitting_percent.into(),
                    at.corrected.fitting_percent.into(),
                    um(at.printed_rms_error_mm),
                    um(at.corrected_rms_error_mm),
                ]
            }),
    );
}

/// Printed and clamped plane.
pub fn planes(section: &mut Section, results: &Results) {
    section.paragraph(
        "Printed, the shape of a play is linear, so the 55 weights of the plane act as eleven \
         numbers. Clamped to its cell, each weight is one of its own. Both are identified on a sum of \
         five slow tones, without g and harmonic terms, and scored on another sum of tones.",
    );
    let fitting = |score: Score| Cell::Number(score.fitting_percent);
    section.table(
        [
            "Plane",
            "Coefficients",
            "Initial covariance",
            "Fitting, fitted signal (%)",
            "held out (%)",
            "held out, one step (%)",
        ],
        results.studies.planes.iter().map(|held| {
            let name = match held.plane {
                Plane::Printed => "printed",
                Plane::Clamped => "clamped",
            };
            vec![
                name.into(),
                held.coefficients.into(),
                held.covariance.into(),
                fitting(held.fitted),
                fitting(held.held_out),
                fitting(held.held_out_one_step),
            ]
        }),
    );
    section.paragraph(
        "The clamped plane describes the fitted signal better by far. On the other signal the two are \
         about equal, either ahead by the initial covariance: five tones do not determine 49 numbers, \
         and what they leave open is not what the other signal asks for.",
    );
}

/// Covariances and envelopes.
pub fn tuning(section: &mut Section, results: &Results) {
    let looked_at = LOOKED_AT_HZ;
    let headers = |first: &str| {
        let fitting = "Lowest Fitting (%)".to_owned();
        let frequencies = looked_at
            .iter()
            .map(|hz| format!("{} Hz", format_number(*hz)));
        [first.to_owned(), fitting]
            .into_iter()
            .chain(frequencies)
            .collect::<Vec<_>>()
    };
    let row = |first: f64, fitting: f64, errors: &[Option<f64>]| {
        let fitting = if fitting > 0.0 {
            Cell::Number(fitting)
        } else {
            Cell::from("runs away")
        };
        let errors = errors
            .iter()
            .map(|error| error.map_or(Cell::from("refused"), |mm| Cell::Number(1e3 * mm)));
        [Cell::Number(first), fitting]
            .into_iter()
            .chain(errors)
            .collect::<Vec<_>>()
    };
    section.paragraph(
        "A sine determines few of the 21 coefficients; the initial covariance decides the rest. \
         Lowest Fitting in free run over the frequencies of the table, and the rms error of the printed \
         law in µm:",
    );
    section.table(
        headers("Initial covariance"),
        results.studies.covariances.iter().map(|at| {
            let outcome = &at.outcome;
            row(
                at.covariance,
                outcome.lowest_fitting_percent,
                &outcome.rms_error_mm,
            )
        }),
    );
    section.paragraph(
        "Slopes of the envelopes, alpha = beta, at initial covariance 1. The paper identifies them but \
         does not list them among the parameters. On this bimorph, whose hysteresis does not widen \
         with the rate, they change little.",
    );
    section.table(
        headers("alpha = beta (ms)"),
        results.studies.envelopes.iter().map(|at| {
            let outcome = &at.outcome;
            row(
                1e3 * at.slope_s,
                outcome.lowest_fitting_percent,
                &outcome.rms_error_mm,
            )
        }),
    );
}
