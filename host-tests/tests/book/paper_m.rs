//! Paper M: docs/experiment-m.md.

use serde_json::{Value, json};

use crate::golden::{entry, golden};
use crate::page::{Cell, Page, words};

/// Frequencies of the studies, Hz.
const STUDIED_HZ: [f64; 8] = [5.0, 10.0, 20.0, 25.0, 50.0, 74.0, 80.0, 110.0];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn at(m: &Value, hz: f64) -> &Value {
    entry(&m["frequencies"], &[("frequency_hz", json!(hz))])
}

#[test]
fn the_models_are_as_shown() {
    let (page, m) = (Page::read("docs/experiment-m.md"), golden("m"));
    let facts = &m["summary"]["facts"];
    for (row, key) in [
        ("| resonance | {} Hz |", "resonance_hz"),
        (
            "| third over first harmonic, 25 Hz | {} |",
            "third_at_25_hz",
        ),
        (
            "| third over first harmonic, 35 Hz | {} |",
            "third_at_35_hz",
        ),
        (
            "| fifth over third harmonic, 15 Hz | {} |",
            "fifth_at_15_hz",
        ),
    ] {
        page.says(row, &[number(&facts[key])]);
    }
    let columns = [
        ("proposed", "free_run"),
        ("truncated", "free_run"),
        ("bouc_wen", "free_run"),
        ("proposed", "recursive_free_run"),
        ("truncated", "recursive_free_run"),
        ("proposed", "one_step"),
        ("truncated", "one_step"),
        ("bouc_wen", "one_step"),
    ];
    let row = |hz: f64| -> Vec<Cell> {
        let models = &at(&m, hz)["models"];
        let um = columns.map(|(model, how)| 1e3 * number(&models[model][how]["rmse_mm"]));
        std::iter::once(hz).chain(um).map(Cell::from).collect()
    };
    let hz = [1.0, 10.0, 25.0, 50.0, 74.0, 80.0, 95.0, 110.0];
    page.table("| Hz | free run: proposed |", &hz.map(row));

    let summary = &m["summary"];
    let count = |how: &str, model: &str| number(&summary[how][model]);
    let best = count("best_in_free_run", "proposed");
    page.says(
        "the proposed model is the best at {} of {} frequencies",
        &[best, 110.0],
    );
    let lowest = |which: usize| number(&summary["lowest_fitting_percent"][which]);
    page.says(
        "at least {} %; identified recursively it falls to {} %",
        &[lowest(0), lowest(1)],
    );
    let rival_over = |share: f64| {
        let all = m["frequencies"].as_array().unwrap().iter();
        let free = |at: &Value, model: &str| number(&at["models"][model]["free_run"]["rmse_mm"]);
        all.filter(|at| free(at, "bouc_wen") > share * free(at, "proposed"))
            .count() as f64
    };
    page.says(
        "at {} of 110 Bouc-Wen is more than 1 % behind, at {} more than 10 %",
        &[rival_over(1.01), rival_over(1.1)],
    );
    let behind = number(&summary["bouc_wen_over_proposed"]);
    let without_g = 100.0 * (number(&summary["truncated_over_proposed"]) - 1.0);
    page.says(
        "Bouc-Wen has {} times the RMSE of the proposed model (median), and leaving out g adds {} %",
        &[behind, without_g],
    );
    let one_step =
        ["proposed", "truncated", "bouc_wen"].map(|model| count("best_in_one_step", model));
    page.says("(best at {}, {} and {} frequencies)", &one_step);
}

#[test]
fn compensation_is_as_shown() {
    let (page, m) = (Page::read("docs/experiment-m.md"), golden("m"));
    let columns = [
        ("proposed", "printed"),
        ("proposed", "exact"),
        ("truncated", "printed"),
        ("truncated", "exact"),
    ];
    let row = |hz: f64| -> Vec<Cell> {
        let cells = columns.map(
            |(model, law)| match &at(&m, hz)[model][law]["rms_error_mm"] {
                Value::Null => words("refused"),
                mm => (1e3 * number(mm)).into(),
            },
        );
        std::iter::once(hz.into()).chain(cells).collect()
    };
    let hz = [
        1.0, 10.0, 20.0, 23.0, 24.0, 25.0, 26.0, 27.0, 30.0, 37.0, 50.0, 60.0, 74.0, 80.0, 95.0,
        110.0,
    ];
    page.table("| Hz | proposed: printed |", &hz.map(row));

    let summary = &m["summary"];
    let refused = summary["exact_refused_hz"].as_array().unwrap();
    page.says(
        "differ in sign, {} of 110 frequencies, all from {} Hz on",
        &[refused.len() as f64, number(&refused[0])],
    );
    let third = &summary["third_over_first_25_hz"];
    page.says(
        "grows from {} to {} times the 25 Hz line",
        &[number(&third[0]), number(&third[1])],
    );
    let beyond = summary["degraded_hz"]
        .as_array()
        .unwrap()
        .iter()
        .map(number);
    let first = beyond.filter(|&hz| hz > 40.0).fold(f64::INFINITY, f64::min);
    page.says("as published**, but from {} Hz on", &[first]);

    let studied = |covariance: f64, hz: f64| {
        let found = entry(
            &m["studies"]["covariances"],
            &[("covariance", json!(covariance))],
        );
        let place = STUDIED_HZ.iter().position(|&one| one == hz).unwrap();
        1e3 * number(&found["rms_error_mm"][place])
    };
    page.says(
        "with 100 the error at 80 Hz is {} µm in place of {}",
        &[studied(100.0, 80.0), studied(1.0, 80.0)],
    );
    let failures = [0.01, 1.0, 100.0, 1e4].map(|covariance| studied(covariance, 25.0));
    page.says(
        "with each of these ({} to {} µm; {} µm with 1e6)",
        &[
            failures.into_iter().fold(f64::INFINITY, f64::min),
            failures.into_iter().fold(0.0, f64::max),
            studied(1e6, 25.0),
        ],
    );
    let at_25 = entry(
        &m["studies"]["printed_and_corrected"],
        &[("frequency_hz", json!(25.0))],
    );
    page.says(
        "compensate worse (25 Hz: {} µm)",
        &[1e3 * number(&at_25["corrected_rms_error_mm"])],
    );

    let planes = m["studies"]["planes"].as_array().unwrap();
    let rows: Vec<Vec<Cell>> = planes
        .iter()
        .map(|one| {
            vec![
                number(&one["covariance"]).into(),
                words(one["plane"].as_str().unwrap()),
                number(&one["coefficients"]).into(),
                number(&one["fitted"]["fitting_percent"]).into(),
                number(&one["held_out"]["fitting_percent"]).into(),
            ]
        })
        .collect();
    page.table("| initial covariance | plane |", &rows);
}
