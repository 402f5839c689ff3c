//! `hysteron diagnose`: its files against the contract of docs/discovery.md, each other, and the
//! sealed truth of hidden data.

#[path = "page_figures/mod.rs"]
mod page_figures;

use std::path::Path;
use std::process::{Command, Output};

use hysteron_host::{model_file, stage};
use page_figures::assert_equal_json;
use serde_json::Value;

fn hysteron(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(arguments)
        .output()
        .unwrap()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// A bad request: exit code 2, one line that holds `says`, nothing written.
fn refused(arguments: &[&str], says: &str) {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let mut all = vec!["diagnose"];
    all.extend(arguments);
    all.extend(["--out", out.to_str().unwrap()]);
    let done = hysteron(&all);
    let error = String::from_utf8_lossy(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{error}");
    assert!(error.contains(says), "{error}");
    assert!(!out.exists());
}

#[test]
fn a_hidden_creep_is_named_in_all_three_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let (hidden, out) = (at("hidden"), at("found"));
    let path = |path: &Path| path.to_str().unwrap().to_owned();
    let hide = ["hide", "--effect", "creep", "--seed", "1", "--out"];
    let done = hysteron(&[&hide[..], &[&path(&hidden)]].concat());
    assert!(done.status.success());
    let data = path(&hidden.join("data"));
    let again = hysteron(&["diagnose", &data, "--json", "--out", &path(&at("again"))]);
    let done = hysteron(&["diagnose", &data, "--out", &path(&out)]);
    let error = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{error}");
    let printed = String::from_utf8_lossy(&done.stdout);
    assert!(printed.starts_with("Missing: creep"), "{printed}");

    let json: Value = serde_json::from_str(&text(&out.join("diagnosis.json"))).unwrap();
    let line: Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(line, json);
    assert_eq!(json["verdict"], "named");
    let effect = &json["effects"][0];
    assert_eq!(effect["name"], "creep");
    assert_eq!(effect["inverted"], true);
    assert!(effect["also_possible"].is_array());
    assert!(
        effect["left_over"]
            .as_f64()
            .is_some_and(|left| left <= 0.35)
    );
    let gap = &json["gap"];
    assert_eq!(gap["unit"], "um");
    let number = |pointer: &str| json.pointer(pointer).and_then(Value::as_f64).unwrap();
    for role in ["fit", "select", "report"] {
        assert!(
            number(&format!("/gap/extended/{role}")) < number(&format!("/gap/baseline/{role}"))
        );
    }
    // By the definition of the contract.
    let excess = |pointer: &str| {
        let (rms, noise) = (number(pointer), number("/gap/noise_floor"));
        (rms * rms - noise * noise).max(0.0).sqrt()
    };
    let closed = 1.0 - excess("/gap/extended/report") / excess("/gap/baseline/report");
    assert!((number("/gap/closed") - closed).abs() < 1e-12);
    let places = json["where"].as_array().unwrap();
    assert!(places.len() >= 5);
    for place in places {
        assert!(place["axis"].is_string() && place["summary"].is_string());
        assert!((0.0..=1.0).contains(&place["share"].as_f64().unwrap()));
    }
    assert!(json["next_record"].is_null() || json["next_record"].is_string());

    // The creep of the model against the truth that was sealed beside the data.
    let truth: toml::Table = text(&hidden.join("truth.toml")).parse().unwrap();
    let hidden_gain = truth["effect"][0]["parameters"]["gain_per_decade"].as_float();
    let found_gain = effect["parameters"]["gain_per_decade"].as_f64();
    let ratio = found_gain.unwrap() / hidden_gain.unwrap();
    assert!((0.8..1.25).contains(&ratio), "{ratio}");

    let model = model_file::load(out.join("model.toml")).unwrap();
    let drive: Vec<f64> = (0..2000).map(|k| 30.0 * (k as f64 * 0.01).sin()).collect();
    let y = stage::displacement(&model, 1e-3, &drive).unwrap();
    assert!(y.len() == 2000 && y.iter().all(|y| y.is_finite()));

    // Each parameter lies within its interval, which is on the page as well.
    let creep = effect["parameters"].as_object().unwrap();
    for key in ["gain_per_decade", "tau_min_s"] {
        let end = |i: usize| effect["intervals"][key][i].as_f64().unwrap();
        let value = creep[key].as_f64().unwrap();
        assert!(end(0) < value && value < end(1), "{effect}");
    }

    // Beside the model that was found nothing is missing, and its figures are as it was given.
    let (found, again) = (path(&out.join("model.toml")), at("again"));
    let done = hysteron(&[
        "diagnose",
        &data,
        "--baseline",
        &found,
        "--out",
        &path(&again),
    ]);
    let error = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{error}");
    let second: Value = serde_json::from_str(&text(&again.join("diagnosis.json"))).unwrap();
    assert_eq!(second["verdict"], "none");
    for role in ["fit", "select", "report"] {
        let rms = |pointer: &str| {
            let number = second.pointer(&format!("{pointer}/{role}"));
            number.and_then(Value::as_f64).unwrap()
        };
        let first = number(&format!("/gap/extended/{role}"));
        assert!((rms("/gap/baseline") / first - 1.0).abs() < 0.02, "{role}");
        assert!(rms("/gap/refitted") < 1.02 * first, "{role}");
    }
    let page = text(&again.join("report.html"));
    assert!(page.contains("Baseline fitted anew"));

    let html = text(&out.join("report.html"));
    assert!(html.len() < 2_000_000);
    let keys = html.matches("data-key=\"").count();
    assert!(keys >= 10, "{keys}");
    assert_equal_json(&html, &json, keys);
    for title in ["Before and after", "Where the gap lies", "What was tried"] {
        assert!(html.contains(title), "{title}");
    }
}

#[test]
fn bad_requests_get_one_clear_line() {
    let here = tempfile::tempdir().unwrap();
    let none = here.path().join("none.csv");
    let none = none.to_str().unwrap();
    refused(&[none], "no such file or folder");
    refused(&[here.path().to_str().unwrap()], "no dataset.toml");
    refused(
        &[none, "--without", "gravity"],
        "there are saturation, slew-limit",
    );
    refused(&[none, "--baseline", "best"], "name rdpi, pi, a model.toml");
    refused(&[none, "--baseline", "my.toml"], "no model file");
}
