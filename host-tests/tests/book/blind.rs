//! Blind trials: the figures of docs/blind.md and the confusion matrix of docs/discovery.md.

use std::fs;

use serde_json::Value;

use crate::golden::{golden, root};
use crate::page::{Cell, Page, words};

fn share(trials: &Value, key: &str) -> Cell {
    let share = &trials["scores"][key];
    words(format!("{} of {}", share["count"], share["of"]))
}

/// The trials of a name, which were of these tiers, seeds and numbers of cases.
fn trials(name: &str, asked: [u64; 3]) -> Value {
    let trials = golden(name);
    let plan = ["tier", "seed", "cases"].map(|key| trials["plan"][key].as_u64().unwrap());
    assert_eq!(plan, asked, "{name}");
    assert_eq!(trials["scores"]["errors"]["count"], 0, "{name}");
    trials
}

fn tiers() -> [Value; 4] {
    [(1, 12_001), (2, 12_001), (3, 12_001), (4, 12_101)]
        .map(|(tier, seed)| trials(&format!("blind-tier{tier}"), [tier, seed, 80]))
}

#[test]
fn the_tiers_are_as_shown() {
    let tiers = tiers();
    let row = |name: &str, cell: &dyn Fn(&Value) -> Cell| {
        let cells = tiers.iter().map(cell);
        std::iter::once(words(name)).chain(cells).collect()
    };
    let number = |value: &Value| Cell::Number(value.as_f64().unwrap());
    let rows: Vec<Vec<Cell>> = vec![
        row("effects that must be found", &|one| share(one, "revealed")),
        row("named, truth first", &|one| share(one, "top_1")),
        row("named or in part, truth first", &|one| {
            share(one, "top_1_or_partial")
        }),
        row("truth in the set", &|one| share(one, "in_set")),
        row("mean size of the set", &|one| {
            number(&one["scores"]["mean_set_size"])
        }),
        row("no effect: something named", &|one| {
            share(one, "false_names")
        }),
        row("no effect: unknown", &|one| share(one, "false_alarms")),
        row("gap closed, median", &|one| {
            number(&one["scores"]["closed"]["median"])
        }),
    ];
    let page = Page::read("docs/blind.md");
    page.table("| figure | tier 1 |", &rows);

    // The README quotes it.
    let counts: Vec<f64> = tiers
        .iter()
        .flat_map(|one| ["count", "of"].map(|key| one["scores"]["top_1"][key].as_f64().unwrap()))
        .collect();
    Page::read("README.md").says(
        "named first in {} of {}, {} of {}, {} of {}, {} of {} cases of tiers 1 to 4",
        &counts,
    );
}

#[test]
fn the_other_trials_are_as_shown() {
    let mut rows = Vec::new();
    for tier in 1..=4 {
        let none = trials(
            &format!("blind-none{tier}"),
            [tier, 90_000 + 1_000 * tier, 300],
        );
        rows.push(vec![
            words(format!("no effect, tier {tier}: something named")),
            share(&none, "false_names"),
        ]);
        rows.push(vec![
            words("the same: unknown"),
            share(&none, "false_alarms"),
        ]);
    }
    for (count, name, seed) in [("two", "pairs", 12_201), ("three", "triples", 12_301)] {
        let several = trials(&format!("blind-{name}"), [1, seed, 40]);
        rows.push(vec![
            words(format!(
                "{count} effects, tier 1: all named and nothing else"
            )),
            share(&several, "exact"),
        ]);
    }
    Page::read("docs/blind.md").table("| figure | measured |", &rows);
}

/// What was answered to cases with a hidden effect, the right name first.
fn answers(trials: &Value, hidden: &str) -> String {
    let confusion = &trials["scores"]["confusion"];
    let truths = confusion["truths"].as_array().unwrap();
    let Some(row) = truths.iter().position(|truth| truth == hidden) else {
        return String::new();
    };
    let answered = confusion["answers"].as_array().unwrap().iter();
    let counts = confusion["counts"][row].as_array().unwrap();
    let mut shown: Vec<(bool, String)> = answered
        .zip(counts)
        .filter(|(_, count)| **count != 0)
        .map(|(answer, count)| {
            let answer = answer.as_str().unwrap();
            let right = answer == hidden;
            let name = match answer {
                _ if right => "right".to_owned(),
                "none" | "partial" | "unknown" | "error" => answer.to_owned(),
                effect => format!("`{effect}`"),
            };
            (!right, format!("{name} {count}"))
        })
        .collect();
    shown.sort();
    let shown: Vec<String> = shown.into_iter().map(|(_, text)| text).collect();
    shown.join(", ")
}

/// With `HYSTERON_BLESS=1` in the environment the table is written anew.
#[test]
fn the_confusion_matrix_is_as_shown() {
    const HEAD: &str = "| hidden | tier 1 | tier 4 |\n|---|---|---|\n";
    let [first, _, _, fourth] = tiers();
    let mut hidden: Vec<String> = Vec::new();
    for trials in [&first, &fourth] {
        let truths = trials["scores"]["confusion"]["truths"].as_array().unwrap();
        hidden.extend(
            truths
                .iter()
                .map(|truth| truth.as_str().unwrap().to_owned()),
        );
    }
    hidden.sort_by_key(|name| (name == "none", name.clone()));
    hidden.dedup();
    let rows: String = hidden
        .iter()
        .map(|name| {
            let shown = if name == "none" {
                "none".to_owned()
            } else {
                format!("`{name}`")
            };
            format!(
                "| {shown} | {} | {} |\n",
                answers(&first, name),
                answers(&fourth, name)
            )
        })
        .collect();
    let path = root("docs/discovery.md");
    let page = fs::read_to_string(&path).unwrap();
    let (before, rest) = page
        .split_once(HEAD)
        .expect("the table of docs/discovery.md");
    let end = rest.find("\n\n").map_or(rest.len(), |end| end + 1);
    if std::env::var_os("HYSTERON_BLESS").is_some_and(|value| value == "1") {
        fs::write(&path, format!("{before}{HEAD}{rows}{}", &rest[end..])).unwrap();
        return;
    }
    assert_eq!(&rest[..end], rows, "run the tests with HYSTERON_BLESS=1");
}
