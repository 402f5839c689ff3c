//! A page as Chromium renders it: no message, no request, readable, and with the figures of the JSON
//! beside it.

use std::env;
use std::fs;
use std::io::ErrorKind;
use std::process::Command;

use serde_json::Value;

/// Opens a copy of a page that ends with `probe.js`; `None` where there is no Chromium and need not be.
fn open(html: &str) -> Option<(String, Vec<String>)> {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let probe = format!("<script>{}</script></body>", include_str!("probe.js"));
    assert_eq!(html.matches("</body>").count(), 1);
    fs::write(&page, html.replace("</body>", &probe)).unwrap();
    // Without a sandbox, because test machines run as root; the page is our own.
    let done = Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--disable-component-update",
        ])
        .args(["--window-size=1200,900", "--timeout=60000"])
        .arg(format!(
            "--user-data-dir={}",
            folder.path().join("profile").display()
        ))
        .args(["--enable-logging=stderr", "--dump-dom"])
        .arg(format!("file://{}", page.display()))
        .output();
    let done = match done {
        Err(error) if error.kind() == ErrorKind::NotFound => {
            assert!(env::var_os("CI").is_none(), "chromium is missing");
            eprintln!("SKIPPED: pages are looked at with chromium, which is missing");
            return None;
        }
        done => done.unwrap(),
    };
    let log = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{log}");
    let messages = log.lines().filter(|line| line.contains(":CONSOLE"));
    let messages = messages.map(str::to_owned).collect();
    Some((String::from_utf8(done.stdout).unwrap(), messages))
}

/// What is wrong with a page, a line each; `None` where there is no Chromium and need not be.
pub fn faults(html: &str, json: &Value) -> Option<Vec<String>> {
    let (dom, mut faults) = open(html)?;
    if html.len() >= 2_000_000 {
        faults.push(format!("{} bytes", html.len()));
    }
    let probed = dom
        .split_once("<pre id=\"probe\">")
        .and_then(|(_, rest)| rest.split_once("</pre>"));
    let Some((probed, _)) = probed else {
        faults.push("the page's script did not come to its end".to_owned());
        return Some(faults);
    };
    faults.extend(
        probed
            .lines()
            .filter(|line| line.starts_with("FAULT"))
            .map(str::to_owned),
    );
    let looked_at = |what: &str| -> usize {
        let count = probed.lines().find_map(|line| line.strip_prefix(what));
        count.and_then(|count| count.trim().parse().ok()).unwrap()
    };
    assert_eq!(looked_at("plots"), html.matches("<figure").count());
    assert!(looked_at("texts") > 20);
    faults.extend(untrue_figures(&dom, json));
    Some(faults)
}

/// Key figures of the rendered page that do not say what the JSON says, as value and in print.
fn untrue_figures(dom: &str, json: &Value) -> Vec<String> {
    let figures: Vec<&str> = dom.split("data-key=\"").skip(1).collect();
    let mut faults = Vec::new();
    if figures.is_empty() {
        faults.push("no key figures".to_owned());
    }
    for figure in figures {
        let mut quoted = figure.split('"');
        let (key, value) = (quoted.next().unwrap(), quoted.nth(1).unwrap());
        let print = figure.split(['>', '<']).nth(1).unwrap();
        let stored = json
            .pointer(&format!("/{}", key.replace('.', "/")))
            .and_then(Value::as_f64);
        let Some(stored) = stored else {
            faults.push(format!("{key} is not in the JSON"));
            continue;
        };
        // A JSON file is read back to the last bit but one.
        let same = |value: f64| (value - stored).abs() <= 2.0 * f64::EPSILON * stored.abs();
        if !value.parse().is_ok_and(same) {
            faults.push(format!("{key} is {value} and {stored} in the JSON"));
        }
        // Four digits are shown.
        let shown = printed_number(print);
        if !shown.is_some_and(|shown| (shown - stored).abs() <= 5.01e-4 * stored.abs()) {
            faults.push(format!(
                "{key} is shown as {print} and {stored} in the JSON"
            ));
        }
    }
    faults
}

/// A number as it is read in print: a true minus sign, a power of ten with superscripts.
fn printed_number(print: &str) -> Option<f64> {
    let (mantissa, power) = print.split_once("×10").unwrap_or((print, "⁰"));
    let power: String = power
        .chars()
        .map(|c| match "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".chars().position(|one| one == c) {
            Some(0) => '-',
            Some(digit) => char::from(b'0' + digit as u8 - 1),
            None => c,
        })
        .collect();
    format!("{}e{power}", mantissa.replace('−', "-"))
        .parse()
        .ok()
}

/// Renders a page and holds it against the JSON beside it; skips with a line where there is no Chromium.
pub fn assert_renders(html: &str, json: &Value) {
    let faults = faults(html, json).unwrap_or_default();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
