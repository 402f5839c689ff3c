//! Key figures of a page against the JSON beside it.

use serde_json::Value;

/// Every figure of the page stands in the JSON under its key, with the same value; there are `count`.
pub fn assert_equal_json(html: &str, json: &Value, count: usize) {
    let figures: Vec<_> = html.split("data-key=\"").skip(1).collect();
    assert_eq!(figures.len(), count);
    for figure in figures {
        let mut parts = figure.split('"');
        let key = parts.next().unwrap();
        let shown: f64 = parts.nth(1).unwrap().parse().unwrap();
        let pointer = format!("/{}", key.replace('.', "/"));
        let stored = json.pointer(&pointer).and_then(Value::as_f64);
        assert_eq!(stored, Some(shown), "{key}");
    }
}
