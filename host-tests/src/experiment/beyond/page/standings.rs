//! The table of who wins where, and it in words.

use crate::experiment::beyond::compensators::{COMPENSATORS, Compensator};
use crate::experiment::beyond::inputs::{Input, Shape};
use crate::experiment::beyond::plants::{PLANTS, Plant};
use crate::experiment::beyond::summary::broken;
use crate::experiment::beyond::{Results, Standing};
use crate::report::{Cell, Section, format_number};

use super::three;

/// Table and sentences.
pub fn fill(section: &mut Section, results: &Results) {
    section.paragraph(
        "Best: the least rms error of all seven. Broken: more than the straight line leaves, more than \
         a plant at rest, or no drive at all. 10 % off: every parameter of the plant 10 % up or down, \
         the median of five seeded draws; the compensators stay as they were identified.",
    );
    section.table(
        [
            "Plant",
            "Compensator",
            "Best",
            "Best, 10 % off",
            "Broken",
            "Refused",
            "Of",
            "Median rms (µm)",
            "10 % off (µm)",
            "Worst (µm)",
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
        standing.plant.title().into(),
        standing.compensator.name().into(),
        standing.best.into(),
        standing.best_wrong.into(),
        standing.broken.into(),
        standing.refused.len().into(),
        standing.references.into(),
        figure(standing.median_rms_um),
        figure(standing.median_rms_um_wrong),
        figure(standing.worst_rms_um),
        standing
            .worst_at
            .map_or(Cell::from("–"), |at| place(&at).into()),
    ]
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
    let of = |plant: Plant| {
        let mut standings = results.standings.iter();
        standings.find(|s| s.plant == plant && s.compensator == compensator)
    };
    let medians: Vec<String> = PLANTS
        .into_iter()
        .filter_map(|plant| {
            let standing = of(plant)?;
            Some(format!(
                "{}: {} µm, best at {} of {}",
                plant.title().to_lowercase(),
                standing.median_rms_um.map_or("–".into(), three),
                standing.best,
                standing.references
            ))
        })
        .collect();
    let name = match compensator {
        Compensator::None => "No compensator".to_owned(),
        other => capitalised(other.name()),
    };
    format!(
        "{name} (median; {}). {}",
        medians.join("; "),
        breaks(results, compensator)
    )
}

fn breaks(results: &Results, compensator: Compensator) -> String {
    let at: Vec<String> = PLANTS
        .into_iter()
        .filter_map(|plant| {
            let rows = results.rows.iter().filter(|row| row.plant == plant);
            let inputs: Vec<Input> = rows
                .filter(|row| broken(row, compensator))
                .map(|row| row.input)
                .collect();
            let sines: Vec<String> = inputs
                .iter()
                .filter(|input| input.shape == Shape::Sine)
                .map(|input| format_number(input.frequency_hz))
                .collect();
            let mut places: Vec<String> = Vec::new();
            if !sines.is_empty() {
                places.push(format!("{} Hz", sines.join(", ")));
            }
            let others = inputs.iter().filter(|input| input.shape != Shape::Sine);
            places.extend(others.map(place));
            (!places.is_empty()).then(|| {
                format!(
                    "on the {} at {}",
                    plant.title().to_lowercase(),
                    places.join(", ")
                )
            })
        })
        .collect();
    if at.is_empty() {
        "It breaks nowhere here.".to_owned()
    } else {
        format!("It breaks {}.", at.join("; "))
    }
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    let first = letters.next().into_iter().flat_map(char::to_uppercase);
    first.chain(letters).collect()
}
