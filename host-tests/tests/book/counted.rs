//! Instructions counted in the emulator: docs/performance.md, docs/preview.md, docs/choices.md.

use std::fs;

use crate::golden::root;
use crate::page::{Cell, Page, words};

/// What a script printed, by what stands before the colon: the numbers behind it.
struct Printed {
    name: &'static str,
    lines: Vec<(String, Vec<f64>)>,
}

impl Printed {
    fn read(name: &'static str) -> Self {
        let text = fs::read_to_string(root("docs/golden").join(name)).unwrap();
        let lines = text.lines().filter_map(|line| line.rsplit_once(':'));
        let numbers = |rest: &str| {
            rest.split_whitespace()
                .filter_map(|word| word.parse().ok())
                .collect()
        };
        Self {
            name,
            lines: lines
                .map(|(key, rest)| (key.to_owned(), numbers(rest)))
                .collect(),
        }
    }

    fn of(&self, key: &str) -> &[f64] {
        let found = self.lines.iter().find(|(name, _)| name == key);
        &found.unwrap_or_else(|| panic!("{}: {key}", self.name)).1
    }
}

fn row(first: &str, numbers: &[f64]) -> Vec<Cell> {
    let cells = numbers.iter().map(|&number| Cell::Number(number));
    std::iter::once(words(first)).chain(cells).collect()
}

#[test]
fn the_inverse_beside_c_is_as_shown() {
    let bench = Printed::read("bench-firmware.txt");
    let rows = [(3, 3), (10, 10), (100, 100), (3, 16), (10, 16)].map(|(n, room)| {
        let &[plain, plain_worst, stack, worst, unwinding, c, c_worst, _] =
            bench.of(&format!("n {n} of {room}"))
        else {
            panic!("eight numbers of {n} of {room}");
        };
        // Neither depends on the input.
        assert_eq!(plain, plain_worst);
        assert!(c.is_nan() || c == c_worst);
        let taken = if n >= 8 { stack } else { plain };
        let mut cells = vec![f64::from(n).into(), f64::from(room).into()];
        cells.extend([plain, stack, worst, unwinding].map(Cell::Number));
        if c.is_nan() {
            cells.extend([words(""), words("")]);
        } else {
            cells.extend([c, taken / c].map(Cell::Number));
        }
        cells
    });
    Page::read("docs/performance.md").table("| n | room for |", &rows);
}

#[test]
fn whole_samples_and_sines_are_as_shown() {
    let bench = Printed::read("bench-firmware.txt");
    let page = Page::read("docs/performance.md");
    let compensators = [
        "explicit, n = 3",
        "explicit, n = 10",
        "explicit, n = 16",
        "rate-independent, n = 3",
        "rate-independent, n = 10",
        "DIM printed, N = 10",
        "DIM printed, N = 16",
        "DIM exact, N = 10",
        "DIM exact, N = 16",
        "preview forward, n = 3",
        "preview forward, n = 10",
        "preview midpoint, n = 3",
        "preview midpoint, n = 10",
        "cascade midpoint, n = 3",
        "cascade forward, n = 10",
        "cascade midpoint, n = 10",
    ];
    page.table(
        "| compensator | mean | worst | Hz",
        &compensators.map(|name| row(name, bench.of(name))),
    );
    let preview = [(3, 24), (3, 30), (10, 24), (10, 30)].map(|(n, window)| {
        let mut cells = vec![f64::from(n).into(), f64::from(window).into()];
        for rate in ["forward", "backward"] {
            let counted = bench.of(&format!("n {n}, window {window}, {rate}"));
            let shown: Vec<String> = counted.iter().map(|count| thousands(*count)).collect();
            cells.push(words(shown.join(" / ")));
        }
        cells
    });
    Page::read("docs/preview.md").table("| n | window |", &preview);
    let sines = [
        (
            "polynomial of `hysteron::reference`, phase included",
            "reference",
        ),
        ("libm `sinf`", "libm"),
        ("micromath `sin`, documented 2e-3", "micromath"),
    ];
    Page::read("docs/choices.md").table(
        "| sine on a period",
        &sines.map(|(shown, name)| row(shown, bench.of(name))),
    );
}

/// A count as pages write it: 4407.2 as 4,407.
fn thousands(count: f64) -> String {
    let whole = format!("{count:.0}");
    match whole.len() {
        0..=3 => whole,
        digits => format!("{},{}", &whole[..digits - 3], &whole[digits - 3..]),
    }
}

/// That script prints the table itself.
#[test]
fn banks_are_as_shown() {
    let printed = fs::read_to_string(root("docs/golden/bank-on-m4f.txt")).unwrap();
    let rows = printed.lines().filter(|line| line.starts_with('|'));
    let rows: Vec<Vec<Cell>> = rows
        .skip_while(|line| !line.starts_with("|---"))
        .skip(1)
        .map(|line| {
            line.trim_matches('|')
                .split('|')
                .map(|cell| words(cell.trim()))
                .collect()
        })
        .collect();
    Page::read("docs/performance.md").table("| N | plain | smooth mean |", &rows);
}
