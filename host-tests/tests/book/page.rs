//! A page of the book and what it shows: rows of tables and sentences, held against figures at the digits
//! shown.

use std::fs;

use crate::golden::root;

/// A page of the project, by its path from the root.
pub struct Page {
    path: String,
    text: String,
}

/// What a cell of a table must show.
#[derive(Debug)]
pub enum Cell {
    /// These words.
    Words(String),
    /// This number, rounded to the digits that stand there.
    Number(f64),
}

/// Words in a cell.
pub fn words(words: impl Into<String>) -> Cell {
    Cell::Words(words.into())
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl Page {
    /// Reads it.
    pub fn read(path: &str) -> Self {
        Self {
            path: path.to_owned(),
            text: fs::read_to_string(root(path)).unwrap(),
        }
    }

    /// The part under the heading that begins so, up to the next one of its level.
    pub fn section(&self, heading: &str) -> Self {
        let found = self.text.split("\n## ");
        let name = heading.trim_start_matches("## ");
        let mut parts = found.filter(|part| part.starts_with(name));
        let part = parts
            .next()
            .unwrap_or_else(|| panic!("{}: no {heading}", self.path));
        Self {
            path: format!("{}, {heading}", self.path),
            text: part.to_owned(),
        }
    }

    /// The table whose first line begins so; it has exactly these rows.
    pub fn table(&self, begins: &str, rows: &[Vec<Cell>]) {
        let shown = self.rows(begins);
        assert_eq!(shown.len(), rows.len(), "{}: rows of {begins}", self.path);
        for (shown, row) in shown.iter().zip(rows) {
            let told = || format!("{}, {begins}: {shown:?}\n{row:?}", self.path);
            assert_eq!(shown.len(), row.len(), "{}", told());
            for (text, cell) in shown.iter().zip(row) {
                let same = match cell {
                    Cell::Words(words) => text == words,
                    Cell::Number(value) => shows(text, *value),
                };
                assert!(same, "{text} is not {cell:?}; {}", told());
            }
        }
    }

    /// The cells below the head of a table.
    fn rows(&self, begins: &str) -> Vec<Vec<String>> {
        let mut heads = self
            .text
            .lines()
            .map(str::trim_start)
            .skip_while(|line| !line.starts_with(begins));
        assert!(heads.next().is_some(), "{}: no table {begins}", self.path);
        // A table of a list stands further in.
        let rows = heads.skip(1).map(str::trim);
        let rows = rows.take_while(|line| line.starts_with('|'));
        rows.map(|line| {
            let cells = line.trim_matches('|').split('|');
            cells.map(|cell| cell.trim().to_owned()).collect()
        })
        .collect()
    }

    /// A sentence of the page, wherever its lines are broken: each `{}` stands for a number, which shows the
    /// next of these values.
    pub fn says(&self, sentence: &str, values: &[f64]) {
        let text = self.text.split_whitespace().collect::<Vec<_>>().join(" ");
        let parts: Vec<&str> = sentence.split("{}").collect();
        assert_eq!(parts.len(), values.len() + 1, "{sentence}");
        assert!(!parts[0].is_empty(), "begins with a number: {sentence}");
        let starts = text.match_indices(parts[0]);
        let said = starts.filter_map(|(at, first)| numbers(&text[at + first.len()..], &parts[1..]));
        let said: Vec<Vec<&str>> = said.collect();
        let [said] = said.as_slice() else {
            panic!("{}: {} times: {sentence}", self.path, said.len());
        };
        for (number, value) in said.iter().zip(values) {
            assert!(
                shows(number, *value),
                "{}: {number} is not {value}: {sentence}",
                self.path
            );
        }
    }
}

/// The numbers between the parts of a sentence, if the text goes on like that.
fn numbers<'a>(mut text: &'a str, parts: &[&str]) -> Option<Vec<&'a str>> {
    let mut found = Vec::new();
    for part in parts {
        let of_number = |c: char| c.is_ascii_digit() || ".,-−+e".contains(c);
        let end = text.find(|c| !of_number(c)).unwrap_or(text.len());
        // What follows a number may begin with a character of numbers: a full stop.
        let end = (1..=end).rev().find(|&end| {
            text.is_char_boundary(end)
                && text[..end].ends_with(|c: char| c.is_ascii_digit())
                && number(&text[..end]).is_some()
                && text[end..].starts_with(part)
        })?;
        found.push(&text[..end]);
        text = &text[end + part.len()..];
    }
    Some(found)
}

fn bare(shown: &str) -> String {
    let plain = shown.trim_matches('*').trim_end_matches(" %");
    plain.replace('−', "-").replace(',', "")
}

fn number(shown: &str) -> Option<f64> {
    bare(shown).parse().ok()
}

/// Whether a text is the value, rounded to its last digit. The golden outputs have been rounded before, so a
/// half may go either way.
fn shows(text: &str, value: f64) -> bool {
    let Some(shown) = number(text) else {
        return false;
    };
    let bare = bare(text);
    let (mantissa, exponent) = bare.split_once('e').unwrap_or((&bare, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, part)| part.len());
    let unit = 10f64.powi(exponent.parse::<i32>().unwrap() - decimals as i32);
    (shown - value).abs() <= 0.5 * unit + 2e-5 * value.abs()
}

/// What is said to a page that is not true.
#[test]
fn an_untrue_figure_is_found_out() {
    for (text, value) in [
        ("1.05", 1.047),
        ("**0.62**", 0.6249),
        ("27.5", 27.494),
        ("-0.0049", -0.00492),
    ] {
        assert!(shows(text, value), "{text} {value}");
    }
    for (text, value) in [
        ("10,120", 10_120.0),
        ("8.41e-4", 8.4123e-4),
        ("96 %", 96.4),
        ("−5", -5.2),
    ] {
        assert!(shows(text, value), "{text} {value}");
    }
    for (text, value) in [
        ("1.05", 1.056),
        ("27", 27.6),
        ("8.41e-4", 8.42e-4),
        ("5", -5.0),
        ("word", 1.0),
    ] {
        assert!(!shows(text, value), "{text} {value}");
    }
    let page = Page {
        path: "a page".to_owned(),
        text: "At 25 Hz it is 1.56\ntimes as large, 1/284 else.\n\n| a | b |\n|---|---|\n| x | 2.0 |\n\nMore".to_owned(),
    };
    page.says("it is {} times as large, 1/{} else", &[1.5562, 283.9]);
    page.table("| a |", &[vec![words("x"), 2.04.into()]]);
    let refused = |untrue: &(dyn Fn() + std::panic::RefUnwindSafe)| {
        assert!(std::panic::catch_unwind(untrue).is_err());
    };
    refused(&|| page.says("it is {} times as large, 1/{} else", &[1.5562, 285.0]));
    refused(&|| page.says("it is {} times as small", &[1.5562]));
    refused(&|| page.table("| a |", &[vec![words("x"), 2.06.into()]]));
    refused(&|| page.table("| a |", &[vec![words("y"), 2.0.into()]]));
    refused(&|| page.table("| a |", &[]));
    refused(&|| page.table("| c |", &[]));
}
