//! The written formats follow the types.
//!
//! With `HYSTERON_BLESS=1` in the environment the schemas under `docs/` are written anew.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use hysteron_host::discover::{self, blind};
use hysteron_host::{campaign, dataset, identify, model_file};

use crate::support::Folder;

fn docs(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../docs")
        .join(name)
}

fn check_schema(name: &str, generated: &str) {
    if std::env::var_os("HYSTERON_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(docs(name), generated).unwrap();
    }
    let kept = std::fs::read_to_string(docs(name)).unwrap();
    assert_eq!(
        kept, generated,
        "docs/{name} is out of date; run the tests with HYSTERON_BLESS=1"
    );
}

/// The first fenced block of a page that is marked as TOML.
fn example(page: &str) -> String {
    let page = std::fs::read_to_string(docs(page)).unwrap();
    let start = page.find("```toml\n").unwrap() + "```toml\n".len();
    let end = start + page[start..].find("```").unwrap();
    page[start..end].to_owned()
}

#[test]
fn schemas_are_up_to_date() {
    check_schema("model.schema.json", &model_file::schema_text());
    check_schema("dataset.schema.json", &dataset::schema_text());
    check_schema("diagnosis.schema.json", &discover::schema_text());
    check_schema("blind.schema.json", &blind::schema_text());
    check_schema("identification.schema.json", &identify::schema_text());
    check_schema("faults.schema.json", &campaign::schema_text());
}

/// Every key of a schema, wherever it stands.
fn keys(value: &serde_json::Value, found: &mut Vec<String>) {
    if let Some(properties) = value.get("properties").and_then(|value| value.as_object()) {
        found.extend(properties.keys().cloned());
    }
    match value {
        serde_json::Value::Object(map) => map.values().for_each(|value| keys(value, found)),
        serde_json::Value::Array(array) => array.iter().for_each(|value| keys(value, found)),
        _ => {}
    }
}

#[test]
fn the_pages_name_every_key() {
    for (page, schema) in [
        ("model.md", model_file::schema_text()),
        ("dataset.md", dataset::schema_text()),
        ("discovery.md", discover::schema_text()),
        ("blind.md", blind::schema_text()),
        ("results.md", identify::schema_text()),
        ("faults.md", campaign::schema_text()),
    ] {
        let text = std::fs::read_to_string(docs(page)).unwrap();
        let mut found = Vec::new();
        keys(&serde_json::from_str(&schema).unwrap(), &mut found);
        assert!(found.len() > 6, "{found:?}");
        // `gap.unit` names both.
        let spans = text.split('`').skip(1).step_by(2);
        let of_key = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
        let words: HashSet<&str> = spans.flat_map(|span| span.split(|c| !of_key(c))).collect();
        for key in found {
            assert!(
                words.contains(key.as_str()),
                "docs/{page} does not explain `{key}`"
            );
        }
    }
}

#[test]
fn the_example_model_is_a_model() {
    let text = example("model.md");
    let model = model_file::parse(&text, "docs/model.md").unwrap();
    assert_eq!(
        model.to_toml_string(),
        text,
        "the example is in the written form"
    );
}

#[test]
fn the_example_data_set_loads() {
    let text = example("dataset.md");
    let rows = (0..8).map(|row| format!("{row},0,0\n")).collect::<String>();
    let csv = format!("time_s,input_v,displacement_um\n{rows}");
    let names = [
        "sine_1hz.csv",
        "sine_50hz.csv",
        "triangle.csv",
        "staircase.csv",
    ];
    let mut files: Vec<(&str, &[u8])> = vec![("dataset.toml", text.as_bytes())];
    files.extend(names.map(|name| (name, csv.as_bytes())));
    let folder = Folder::new(&files);
    assert_eq!(
        dataset::Dataset::load(folder.path(""))
            .unwrap()
            .records
            .len(),
        names.len()
    );
}
