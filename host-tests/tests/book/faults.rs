//! The campaign of faults: docs/faults.md.

use hysteron_host::campaign::{Failing, Kind};

use crate::golden::golden;
use crate::page::{Page, words};

#[test]
fn the_kinds_and_counts_are_as_shown() {
    let page = Page::read("docs/faults.md");
    let (host, emulator) = (golden("faults"), golden("faults-emulator"));
    let count = |outcome: &serde_json::Value, key: &str| match outcome["kinds"][key].as_u64() {
        Some(count) => words(count.to_string()),
        None => words("-"),
    };
    let kinds = Kind::ALL.map(Kind::words).into_iter();
    let rows: Vec<_> = kinds
        .chain(Failing::ALL.map(Failing::words))
        .map(|(key, name, required)| {
            let broken = [&host, &emulator].map(|one| {
                let all = one["failures"].as_array().unwrap();
                all.iter().filter(|failure| failure["fault"] == key).count()
            });
            vec![
                words(name),
                words(required),
                count(&host, key),
                count(&emulator, key),
                words(broken.iter().sum::<usize>().to_string()),
            ]
        })
        .collect();
    page.table("| fault | required beyond that |", &rows);
    for (name, line) in [
        (
            "faults",
            "seeds 1 to {}: {} faults, {} samples, none broken",
        ),
        (
            "faults-emulator",
            "seeds 1 to {}: {} faults, {} samples, none broken",
        ),
    ] {
        let outcome = golden(name);
        assert_eq!(outcome["failures"], serde_json::json!([]), "{name}");
        let runs = outcome["runs"].as_f64().unwrap();
        let rest = ["injected", "samples"].map(|key| outcome[key].as_f64().unwrap());
        page.says(&line.replacen("{}", &runs.to_string(), 1), &rest);
    }
    let many = golden("faults-1000");
    assert_eq!(many["failures"], serde_json::json!([]));
    page.says(
        "by hand: {} faults, {} samples, none broken",
        &["injected", "samples"].map(|key| many[key].as_f64().unwrap()),
    );
}
