//! README.md as a newcomer follows it: its console blocks run in order in an empty folder, the pages that
//! they leave opened in a browser.

#[path = "../browser/mod.rs"]
mod browser;
mod console;

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use tempfile::TempDir;

/// The folder after the tour, and how many commands were held against what they are said to print.
static TOUR: LazyLock<(TempDir, usize)> = LazyLock::new(|| {
    let readme = Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md");
    let all = console::commands(&fs::read_to_string(readme).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let mut compared = 0;
    for shown in &all {
        // The first holds this test, the second is the tour's first command with another seed.
        if ["cargo test", "cargo run --release"].contains(&&*shown.command) {
            continue;
        }
        compared += usize::from(!shown.lines.is_empty());
        console::run(shown, folder.path()).unwrap_or_else(|difference| panic!("{difference}"));
    }
    (folder, compared)
});

#[test]
fn the_readme_shows_what_happens() {
    assert!(TOUR.1 >= 5, "{} commands with output", TOUR.1);
}

/// Every key of demo.json; the other files have schemas or lists of their own.
#[test]
fn the_book_names_every_key_of_the_demonstration() {
    fn keys(value: &serde_json::Value, found: &mut Vec<String>) {
        match value {
            serde_json::Value::Object(fields) => {
                found.extend(fields.keys().cloned());
                fields.values().for_each(|value| keys(value, found));
            }
            serde_json::Value::Array(items) => items.iter().for_each(|value| keys(value, found)),
            _ => {}
        }
    }
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results.md");
    let page = fs::read_to_string(docs).unwrap();
    let mut found = Vec::new();
    keys(&page_and_json("out/demo", "demo.json").1, &mut found);
    assert!(found.len() > 15, "{found:?}");
    for key in found {
        assert!(page.contains(&format!("`{key}`")), "{key}");
    }
}

fn page_and_json(folder: &str, json: &str) -> (String, serde_json::Value) {
    let folder = TOUR.0.path().join(folder);
    let text = fs::read_to_string(folder.join(json)).unwrap();
    (
        fs::read_to_string(folder.join("report.html")).unwrap(),
        serde_json::from_str(&text).unwrap(),
    )
}

#[test]
fn the_pages_of_the_tour_open_in_a_browser() {
    for (folder, json) in [
        ("out/demo", "demo.json"),
        ("out/stage", "identification.json"),
        ("out/found", "diagnosis.json"),
    ] {
        let (html, json) = page_and_json(folder, json);
        browser::assert_renders(&html, &json);
    }
}

/// What is said to a page that is spoilt in every way, so that the silence above means something.
#[test]
fn a_spoilt_page_is_found_out() {
    let (html, json) = page_and_json("out/stage", "identification.json");
    let plays = "data-key=\"plays\" data-value=\"";
    let spoilt_plays = format!("{plays}9");
    let spoils = [
        (
            "<footer>",
            "<script>console.error('bad')</script><footer>",
            "\"bad\"",
        ),
        (
            "<footer>",
            "<script>none.such</script><footer>",
            "ReferenceError",
        ),
        (
            "<footer>",
            "<img src=\"https://example.org/x.png\"><footer>",
            "example.org",
        ),
        ("--soft: #4d5866", "--soft: #9aa5b1", "contrast"),
        ("role=\"img\"", "", "a plot without a name"),
        ("readout.textContent =", "readout.title =", "no values of"),
        (plays, &spoilt_plays, "plays is 911 and 11 in the JSON"),
        (">0.04676<", ">0.04776<", "is shown as 0.04776"),
        ("class=\"verdict", "class=\"sentence", "no verdict"),
    ];
    let mut spoilt = html.clone();
    for (from, to, _) in &spoils {
        assert!(spoilt.contains(from), "{from}");
        spoilt = spoilt.replace(from, to);
    }
    let Some(faults) = browser::faults(&spoilt, &json) else {
        return;
    };
    for (_, to, says) in spoils {
        assert!(
            faults.iter().any(|fault| fault.contains(says)),
            "{to}: {faults:?}"
        );
    }
}
