//! Paper J: docs/experiment-j.md and what other pages quote of it.

use serde_json::{Value, json};

use crate::golden::{entry, golden};
use crate::page::{Cell, Page, words};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Largest error in um of a kind on a plant at a frequency.
fn error(list: &Value, plant: &str, hz: f64, kind: &str) -> f64 {
    let row = entry(
        list,
        &[("plant", plant.into()), ("frequency_hz", json!(hz))],
    );
    number(&row[kind])
}

#[test]
fn the_page_shows_what_the_program_says() {
    let (page, j) = (Page::read("docs/experiment-j.md"), golden("j"));
    let percents = j["hysteresis_percent"].as_array().unwrap();
    let columns = [
        "frequency_hz",
        "model",
        "stage",
        "stage_lag_removed",
        "published",
    ];
    let rows: Vec<Vec<Cell>> = percents
        .iter()
        .map(|row| columns.map(|key| number(&row[key]).into()).into())
        .collect();
    page.table("| Hz | model | simulated stage |", &rows);

    let errors = &j["largest_error_um"];
    let columns = [
        ("model_own_rate", "none"),
        ("model_own_rate", "rate_independent"),
        ("model_own_rate", "rate_dependent"),
        ("stage_lag_removed", "none"),
        ("stage_lag_removed", "rate_independent"),
        ("stage_lag_removed", "rate_dependent"),
        ("stage_wrong_lag_removed_median", "rate_dependent"),
        ("stage_wrong_lag_removed_worst", "rate_dependent"),
    ];
    let row = |hz: f64| -> Vec<Cell> {
        let cells = columns.map(|(plant, kind)| error(errors, plant, hz, kind).into());
        std::iter::once(hz.into()).chain(cells).collect()
    };
    let hz = [
        0.05, 0.1, 0.5, 1.0, 5.0, 10.0, 20.0, 40.0, 50.0, 60.0, 80.0, 100.0,
    ];
    page.table("| Hz | model, none |", &hz.map(row));
    let linear = |hz| error(errors, "model_own_rate", hz, "linear");
    page.says("gives more: {} to {} µm", &[linear(0.05), linear(100.0)]);

    let rows = [
        ("triangle", 10.0),
        ("triangle", 50.0),
        ("major_minor", 10.0),
        ("major_minor", 50.0),
    ];
    let rows = rows.map(|(input, hz)| {
        let key = [
            ("input", input.into()),
            ("plant", "stage_lag_removed".into()),
            ("frequency_hz", json!(hz)),
        ];
        let row = entry(&j["inputs"], &key);
        let name = if input == "triangle" {
            input
        } else {
            "two amplitudes"
        };
        let shown = ["none", "rate_independent", "rate_dependent"];
        let cells = shown.map(|kind| number(&row[kind]).into());
        std::iter::once(words(format!("{name}, {hz} Hz")))
            .chain(cells)
            .collect()
    });
    page.table("| reference | none |", &rows);

    let found = j["identification"]["largest_error_um"].as_array().unwrap();
    let largest = found
        .iter()
        .map(|at| number(&at["rate_dependent"]))
        .fold(0.0, f64::max);
    page.says("leaves at most {} µm up to 100 Hz", &[largest]);
}

#[test]
fn other_pages_quote_it_rightly() {
    let j = golden("j");
    let of = |hz, kind| error(&j["largest_error_um"], "model_own_rate", hz, kind);
    let floor = [1.0, 50.0, 100.0].map(|hz| of(hz, "rate_dependent"));
    let readme = Page::read("README.md");
    readme.says("leaves {} um at 1 Hz, {} at 50 Hz and {} at 100 Hz", &floor);
    let percents = j["hysteresis_percent"].as_array().unwrap();
    let percents: Vec<f64> = ["model", "published"]
        .iter()
        .flat_map(|key| percents.iter().map(|row| number(&row[*key])))
        .collect();
    readme.says("| {} / {} / {} %; published {} / {} / {} |", &percents);
    let models = Page::read("docs/models.md");
    models.says("The {}, {} and {} um are the floor", &floor);
    // In the first column stands what rounding leaves.
    for (hz, rounding) in [(1.0, "2e-14"), (50.0, "1e-14"), (100.0, "1e-14")] {
        let same = error(
            &j["largest_error_um"],
            "model_same_rate",
            hz,
            "rate_dependent",
        );
        assert!(same < 1e-12);
        let kinds = ["rate_dependent", "rate_independent", "linear"];
        models.says(
            &format!("| {hz} Hz | {rounding} | {{}} | {{}} | {{}} |"),
            &kinds.map(|kind| of(hz, kind)),
        );
    }
}
