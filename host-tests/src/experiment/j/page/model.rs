//! Constants: published, contradicting, identified.

use crate::experiment::j::published::{LOOP_WEIGHTS, WEIGHTS};
use crate::experiment::j::{Identified, Results};
use crate::report::{Cell, Section};

/// Model and inverse, and what contradicts what.
pub fn constants(section: &mut Section, results: &Results) {
    let constants = &results.constants;
    let corrected = constants.corrected.hysteresis();
    section.table(
        [
            "Weight",
            "Printed",
            "Implied by the printed inverse",
            "Corrected",
        ],
        WEIGHTS
            .iter()
            .zip(&constants.implied_weights)
            .zip(corrected.map_or(&[][..], |h| &h.weights))
            .enumerate()
            .map(|(i, ((&printed, &implied), &corrected))| {
                vec![
                    format!("a_{i} (µm/V)").into(),
                    printed.into(),
                    implied.into(),
                    corrected.into(),
                ]
            }),
    );
    section.paragraph(
        "With zeta = 9.715 V and beta = 8.572×10⁻⁴ s, which are as printed, the inverse is:",
    );
    let mark = |unit: &str, value: f64, agrees: bool| -> Cell {
        let word = if agrees { "agrees" } else { "contradicts" };
        format!("{} ({word})", digits(unit, value)).into()
    };
    section.table(
        [
            "Constant",
            "Unit",
            "Published",
            "From the printed weights",
            "From the corrected weights",
        ],
        constants.compared.iter().map(|one| {
            vec![
                one.constant.into(),
                one.unit.replace("um", "µm").into(),
                digits(one.unit, one.published).into(),
                mark(one.unit, one.from_printed, one.printed_agrees),
                mark(one.unit, one.from_corrected, one.corrected_agrees),
            ]
        }),
    );
    section.paragraph("What the paper prints and contradicts elsewhere:");
    section.table(
        ["What", "Printed", "Consistent", "The two numbers"],
        constants.contradictions.iter().map(|one| {
            vec![
                one.what.into(),
                one.printed.into(),
                one.consistent.into(),
                one.why.replace("um", "µm").into(),
            ]
        }),
    );
}

/// An inverse constant with about the digits that the paper prints.
fn digits(unit: &str, value: f64) -> String {
    match unit {
        "V/um" => format!("{value:.4}").replace('-', "−"),
        "um" => format!("{value:.4}"),
        _ => format!("{:.4}×10⁻⁴", value * 1e4),
    }
}

/// What the authors' fit finds on our stages.
pub fn identification(section: &mut Section, results: &Results) {
    section.paragraph(
        "As in the paper: steady loops at 1, 50 and 100 Hz, 200 points each, weighted by their \
         hysteresis percent; n = 3, thresholds zeta i. From the model's own loops the fit finds its \
         constants again. The simulated stage has spread thresholds, so three plays can only come \
         near it; weights of neighbours trade against each other.",
    );
    let found = &results.identification;
    let corrected = results.constants.corrected.hysteresis();
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    let mut row = |name: String, corrected: f64, of: &dyn Fn(&Identified) -> f64| {
        rows.push(vec![
            name.into(),
            corrected.into(),
            of(&found.from_model).into(),
            of(&found.from_stage).into(),
        ]);
    };
    if let Some(model) = corrected {
        for (i, &weight) in model.weights.iter().enumerate() {
            row(format!("a_{i} (µm/V)"), weight, &|one| one.weights[i]);
        }
        row("zeta (V)".into(), model.thresholds_v[0], &|one| one.zeta_v);
        row("beta (s)".into(), model.beta_s, &|one| one.beta_s);
    }
    for (i, &published) in LOOP_WEIGHTS.iter().enumerate() {
        row(format!("A_{}", i + 1), published, &|one| {
            one.record_weights[i]
        });
    }
    rows.push(vec![
        "Residual, rms (µm)".into(),
        "–".into(),
        found.from_model.rms_um.into(),
        found.from_stage.rms_um.into(),
    ]);
    section.table(
        [
            "Constant",
            "Published (weights corrected)",
            "From the model's loops",
            "From the stage's loops",
        ],
        rows,
    );
}
