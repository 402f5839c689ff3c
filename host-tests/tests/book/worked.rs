//! Diagnoses of two published stages and of measured data: docs/worked-examples.md.

use serde_json::Value;

use crate::golden::golden;
use crate::page::{Page, words};

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Part of the page, and the diagnosis that it shows.
fn shown(heading: &str, name: &str) -> (Page, Value) {
    let page = Page::read("docs/worked-examples.md");
    (page.section(heading), golden(name))
}

/// The table of rms residuals.
fn residuals(page: &Page, found: &Value) {
    let unit = found["gap"]["unit"].as_str().unwrap();
    let rows = [("plays alone", "baseline"), ("extended model", "extended")];
    let rows = rows.map(|(name, key)| {
        let roles = ["fit", "select", "report"];
        let rms = roles.map(|role| number(&found["gap"][key][role]).into());
        std::iter::once(words(name)).chain(rms).collect()
    });
    page.table(&format!("| rms residual, {unit} | fit |"), &rows);
}

/// The effects in order, each with its look-alikes and these of its numbers.
fn effects(page: &Page, found: &Value, numbers: &[&[&str]]) {
    let effects = found["effects"].as_array().unwrap();
    assert_eq!(effects.len(), numbers.len(), "{effects:?}");
    for (effect, keys) in effects.iter().zip(numbers) {
        let quoted = |name: &Value| format!("`{}`", name.as_str().unwrap());
        let others: Vec<String> = effect["also_possible"]
            .as_array()
            .unwrap()
            .iter()
            .map(quoted)
            .collect();
        let others = match others.as_slice() {
            [] => String::new(),
            some => format!("{} ", some.join(", ")),
        };
        let stage = quoted(&effect["stage"]);
        let shown: Vec<String> = keys.iter().map(|key| format!("{key} = {{}}")).collect();
        let values: Vec<f64> = keys
            .iter()
            .map(|key| number(&effect["parameters"][key]))
            .collect();
        page.says(
            &format!("| {stage} | {others}| {}", shown.join(", ")),
            &values,
        );
    }
}

fn closed_percent(found: &Value) -> f64 {
    100.0 * number(&found["gap"]["closed"])
}

#[test]
fn paper_j_is_as_shown() {
    let (page, found) = shown("## Paper J", "found-j");
    assert_eq!(found["verdict"], "named");
    effects(&page, &found, &[&["beta_s"], &["delay_s"]]);
    residuals(&page, &found);
    let without = &found["ablation_select_rms"];
    page.says(
        "| {} % of the gap is closed, ablation keeps both ({} um on the `select` records without the delay, {} without the rate term), the noise is {} um",
        &[
            closed_percent(&found),
            number(&without["transport-delay"]),
            number(&without["rate-dependence"]),
            number(&found["gap"]["noise_floor"]),
        ],
    );
}

#[test]
fn paper_m_is_as_shown() {
    let (page, found) = shown("## Paper M", "found-m");
    assert_eq!(found["verdict"], "named");
    effects(&page, &found, &[&["f_n_hz", "zeta"], &["tau_s"], &["q"]]);
    residuals(&page, &found);
    page.says("| {} % of the gap is closed", &[closed_percent(&found)]);
    let places = found["where"].as_array().unwrap();
    let said = places.iter().any(|place| {
        let summary = place["summary"].as_str().unwrap();
        summary.contains("In sine-25hz the 3rd multiple of the drive's 25 Hz meets the mode at 74.2 Hz, which magnifies the odd part of the hysteresis there.")
    });
    assert!(said, "{places:?}");
}

#[test]
fn the_mirror_is_as_shown() {
    let page = Page::read("docs/worked-examples.md").section("## A mirror");
    for axis in 1..=3 {
        assert_eq!(golden(&format!("found-mixed-{axis}"))["verdict"], "unknown");
        let own = golden(&format!("found-own-{axis}"));
        let said = if axis == 3 {
            "`partial` | `resonance`, `transport-delay` |"
        } else {
            "`unknown` | |"
        };
        assert!(
            said.contains(own["verdict"].as_str().unwrap()),
            "{axis}: {said}"
        );
        page.says(
            &format!("| {axis} | {said} {{}} | {{}} |"),
            &[
                number(&own["gap"]["extended"]["report"]),
                number(&own["gap"]["noise_floor"]),
            ],
        );
    }
    let third = golden("found-own-3");
    let [mode, delay] = &third["effects"].as_array().unwrap()[..] else {
        panic!("{third:?}");
    };
    assert_eq!(mode["name"], "resonance");
    assert_eq!(delay["name"], "transport-delay");
    page.says(
        "it names `resonance` at {} Hz with a damping of {} and `transport-delay` of {} µs",
        &[
            number(&mode["parameters"]["f_n_hz"]),
            number(&mode["parameters"]["zeta"]),
            1e6 * number(&delay["parameters"]["delay_s"]),
        ],
    );
    page.says(
        "says that this is a part: {} % of the gap",
        &[closed_percent(&third)],
    );
}

#[test]
fn the_stack_is_as_shown() {
    let (page, found) = shown("## A measured stack", "found-stack");
    assert_eq!(found["verdict"], "named");
    effects(&page, &found, &[&["tau_s"], &["kappa"]]);
    for (place, key) in [(0, "tau_s"), (1, "kappa")] {
        let effect = &found["effects"][place];
        let ends = &effect["intervals"][key];
        page.says(
            &format!("{key} = {{}} ({{}} to {{}}) |"),
            &[
                number(&effect["parameters"][key]),
                number(&ends[0]),
                number(&ends[1]),
            ],
        );
    }
    residuals(&page, &found);
    let without = &found["ablation_select_rms"];
    page.says(
        "from cycle to cycle is {} um. Both effects are missed when they are left out ({} and {} um",
        &[
            number(&found["gap"]["noise_floor"]),
            number(&without["amplifier-lag"]),
            number(&without["congruency"]),
        ],
    );
}
