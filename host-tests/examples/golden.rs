//! Makes a golden file of docs/golden from the JSON that a command wrote: numbers to five significant
//! digits, one entry a line, without what is long and not shown.
//!
//! `golden FROM.json TO.json [KEY | TOP:KEY]...`: a key is left out wherever it stands, or below the key
//! TOP of the whole; `TOP:` leaves out all of that. `scripts/golden.sh` runs it on the output of every command that the book quotes.

use std::error::Error;
use std::io;
use std::{env, fs};

use serde_json::{Map, Number, Value};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [from, to, left_out @ ..] = arguments.as_slice() else {
        return Err("golden FROM.json TO.json [KEY | TOP:KEY]...".into());
    };
    let Value::Object(whole) = serde_json::from_str(&fs::read_to_string(from)?)? else {
        return Err(io::Error::other(format!("{from} holds no object")).into());
    };
    let kept = whole.into_iter().filter_map(|(top, value)| {
        let dropped = |key: &str| {
            let mut all = left_out.iter();
            all.any(|one| match one.split_once(':') {
                Some((above, below)) => above == top && (below == key || below.is_empty()),
                None => one == key,
            })
        };
        (!dropped(&top)).then(|| (top.clone(), kept(value, &dropped)))
    });
    fs::write(to, text(&kept.collect()))?;
    Ok(())
}

fn kept(value: Value, dropped: &dyn Fn(&str) -> bool) -> Value {
    match value {
        Value::Object(fields) => {
            let wanted = fields.into_iter().filter(|(key, _)| !dropped(key));
            Value::Object(
                wanted
                    .map(|(key, value)| (key, kept(value, dropped)))
                    .collect(),
            )
        }
        Value::Array(items) => {
            Value::Array(items.into_iter().map(|item| kept(item, dropped)).collect())
        }
        Value::Number(number) => Value::Number(rounded(number)),
        other => other,
    }
}

/// To five significant digits; whole numbers stay.
fn rounded(number: Number) -> Number {
    let float = number.as_f64().filter(|_| number.is_f64());
    let short = float.and_then(|float| format!("{float:.4e}").parse().ok());
    short.and_then(Number::from_f64).unwrap_or(number)
}

fn text(whole: &Map<String, Value>) -> String {
    let fields = whole.iter().map(|(key, value)| {
        let name = Value::from(key.as_str());
        match value {
            Value::Array(items) if items.iter().any(Value::is_object) => {
                let lines: Vec<String> = items.iter().map(Value::to_string).collect();
                format!("{name}: [\n{}\n]", lines.join(",\n"))
            }
            other => format!("{name}: {other}"),
        }
    });
    let fields: Vec<String> = fields.collect();
    format!("{{\n{}\n}}\n", fields.join(",\n"))
}
