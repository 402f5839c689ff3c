//! The table of who wins where, and it in words.

use crate::experiment::beyond::compensators::{COMPENSATORS, Compensator};
use crate::experiment::beyond::inputs::{Input, Shape};
use crate::experiment::beyond::plants::{PLANTS, Plant};
use crate::experiment::beyond::summary::broken;
use crate::experiment::beyond::sweep::Row;
use crate::experiment::beyond::{Results, Standing};
use crate::report::{Cell, Section, format_number};

/// Table and sentences.
pub fn fill(section: &mut Section, results: &Results) {
    section.paragraph(
        "Best: at how many references the rms error is the least of all seven. Broken: at how many it \
         is more than the straight line leaves, more than that of a plant at rest, or there is no drive \
         at all. Median and largest rms error over all references in µm. 10 % off: every parameter of \
         the plant 10 % up or down, the median of five seeded draws; the compensators stay as they were \
         identified.",
    );
    section.table(
        [
            "Plant",
            "Compensator",
            "Best",
            "10 % off",
            "Broken",
            "Median",
            "10 % off",
            "Largest",
            "at",
        ],
        results.standings.iter().map(row),
    );
    section.list(
        COMPENSATORS
            .into_iter()
            .map(|compensator| sentence(results, compensator)),
    );
}

fn row(standing: &Standing) -> Vec<Cell> {
    let figure = |um: Option<f64>| um.map_or(Cell::from("–"), Cell::Number);
    vec![
        unbroken(standing.plant.title()).into(),
        unbroken(standing.compensator.name()).into(),
        unbroken(&format!("{} of {}", standing.best, standing.references)).into(),
        standing.best_wrong.into(),
        standing.broken.into(),
        figure(standing.median_rms_um),
        figure(standing.median_rms_um_wrong),
        figure(standing.worst_rms_um),
        standing
            .worst_at
            .map_or(Cell::from("–"), |at| place(&at).into()),
    ]
}

/// Words that stay in one line.
pub fn unbroken(text: &str) -> String {
    text.replace(' ', "\u{a0}").replace('-', "\u{2011}")
}

/// A reference in words.
pub fn place(input: &Input) -> String {
    let hz = format_number(input.frequency_hz);
    match input.shape {
        Shape::Sine => format!("{hz} Hz"),
        shape => format!("{} {hz} Hz", shape.describe()),
    }
}

fn sentence(results: &Results, compensator: Compensator) -> String {
    let name = match compensator {
        Compensator::None => "No compensator".to_owned(),
        other => capitalised(other.name()),
    };
    let best = places(results, |row| {
        row.best(|entry| &entry.identified)
            .is_some_and(|(best, _)| best == compensator)
    });
    let breaks = places(results, |row| broken(row, compensator));
    let told = |places: &str| {
        if places.is_empty() {
            "nowhere".to_owned()
        } else {
            places.to_owned()
        }
    };
    format!("{name}. Best: {}. Broken: {}.", told(&best), told(&breaks))
}

/// The references for which `holds` says so, plant after plant.
fn places(results: &Results, holds: impl Fn(&Row) -> bool) -> String {
    let on = |plant: Plant| {
        let rows = results.rows.iter().filter(|row| row.plant == plant);
        let (found, all): (Vec<&Row>, usize) = (
            rows.clone().filter(|row| holds(row)).collect(),
            rows.count(),
        );
        if found.is_empty() {
            return None;
        }
        let name = plant.title().to_lowercase();
        if found.len() == all {
            return Some(format!("all over the {name}"));
        }
        let sines: Vec<String> = found
            .iter()
            .filter(|row| row.input.shape == Shape::Sine)
            .map(|row| format_number(row.input.frequency_hz))
            .collect();
        let others = found.iter().filter(|row| row.input.shape != Shape::Sine);
        let sines = (!sines.is_empty()).then(|| format!("{} Hz", sines.join(", ")));
        let named: Vec<String> = sines
            .into_iter()
            .chain(others.map(|row| place(&row.input)))
            .collect();
        Some(format!("{name} at {}", named.join(", ")))
    };
    let plants: Vec<String> = PLANTS.into_iter().filter_map(on).collect();
    plants.join("; ")
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}
