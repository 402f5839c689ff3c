//! The golden outputs of docs/golden: what commands of the program printed, and fresh figures against it.

#![allow(dead_code, reason = "each test file uses a part of it")]

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

/// A path from the root of the project.
pub fn root(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

/// The golden output of a name, without `.json`.
pub fn golden(name: &str) -> Value {
    let path = root("docs/golden").join(format!("{name}.json"));
    let text = fs::read_to_string(&path).unwrap_or_else(|missing| {
        panic!(
            "{}: {missing}; docs/golden/README.md says what makes it",
            path.display()
        )
    });
    serde_json::from_str(&text).unwrap()
}

/// The entry of a list in which these keys have these values.
pub fn entry<'a>(list: &'a Value, keys: &[(&str, Value)]) -> &'a Value {
    let mut all = list.as_array().unwrap().iter();
    let wanted = |one: &&Value| keys.iter().all(|(key, value)| one[*key] == *value);
    all.find(wanted)
        .unwrap_or_else(|| panic!("no entry with {keys:?}"))
}

/// Everything that the golden output holds is among the fresh figures, numbers within a share of their
/// size or, where they stand for nothing, 1e-9.
pub fn assert_near(fresh: &Value, golden: &Value, tolerance: f64) {
    let mut apart = Vec::new();
    differences("", fresh, golden, tolerance, &mut apart);
    assert!(
        apart.is_empty(),
        "docs/golden is out of date (docs/golden/README.md says how it is made):\n{}",
        apart.join("\n")
    );
}

fn differences(at: &str, fresh: &Value, golden: &Value, tolerance: f64, apart: &mut Vec<String>) {
    let mut each = |step: &dyn std::fmt::Display, fresh: &Value, golden: &Value| {
        differences(&format!("{at}/{step}"), fresh, golden, tolerance, apart);
    };
    match (fresh, golden) {
        (Value::Object(now), Value::Object(then)) => {
            for (key, then) in then {
                each(key, now.get(key).unwrap_or(&Value::Null), then);
            }
        }
        (Value::Array(now), Value::Array(then)) if now.len() == then.len() => {
            for (place, (now, then)) in now.iter().zip(then).enumerate() {
                each(&place, now, then);
            }
        }
        (Value::Number(now), Value::Number(then)) => {
            let (now, then) = (now.as_f64().unwrap(), then.as_f64().unwrap());
            if (now - then).abs() > tolerance * then.abs() + 1e-9 {
                apart.push(format!("{at}: {now}, golden {then}"));
            }
        }
        _ if fresh == golden => {}
        _ => apart.push(format!("{at}: {fresh}, golden {golden}")),
    }
}
