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
        // This test is part of it.
        if shown.command == "cargo test" {
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

/// What the browser says to pages that are spoilt, so that its silence above means something.
#[test]
fn a_spoilt_page_is_found_out() {
    let (html, json) = page_and_json("out/stage", "identification.json");
    let key = "data-key=\"plays\" data-value=\"";
    for (from, to, says) in [
        (
            "</main>",
            "</main><script>console.error('bad')</script>",
            "\"bad\"",
        ),
        (
            "</main>",
            "</main><script>none.such</script>",
            "ReferenceError",
        ),
        (
            "</main>",
            "</main><img src=\"https://example.org/x.png\">",
            "example.org",
        ),
        ("--soft: #4d5866", "--soft: #9aa5b1", "contrast"),
        ("role=\"img\"", "", "a plot without a name"),
        ("readout.textContent =", "readout.title =", "no values of"),
        (key, "data-key=\"plays\" data-value=\"9", "in the JSON"),
        (">0.04676<", ">0.04776<", "is shown as"),
    ] {
        assert!(html.contains(from), "{from}");
        let Some(faults) = browser::faults(&html.replace(from, to), &json) else {
            return;
        };
        assert!(
            faults.iter().any(|fault| fault.contains(says)),
            "{to}: {faults:?}"
        );
    }
}
