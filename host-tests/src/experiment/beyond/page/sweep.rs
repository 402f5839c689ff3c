//! One plant: what each compensator leaves along each reference.

use crate::experiment::beyond::Results;
use crate::experiment::beyond::compensators::COMPENSATORS;
use crate::experiment::beyond::inputs::Shape;
use crate::experiment::beyond::plants::Plant;
use crate::experiment::beyond::sweep::{Entry, Errors, Outcome, Row};
use crate::report::{Axis, Cell, Plot, Section, Series, Style, format_number};

use super::standings::place;

type Of = fn(&Entry) -> &Outcome;
type Pick = fn(&Errors) -> [f64; 2];

const IDENTIFIED: Of = |entry| &entry.identified;
const WRONG: Of = |entry| &entry.wrong;

/// Plots, tables, reasons of refusals.
pub fn fill(section: &mut Section, results: &Results, plant: Plant) {
    let rows: Vec<&Row> = results
        .rows
        .iter()
        .filter(|row| row.plant == plant)
        .collect();
    section.paragraph(format!(
        "This is {}. Reference {} µm; the second after the first is scored.",
        plant.describe(),
        plant.amplitude_um()
    ));
    // Over the bimorph's range things happen from one hertz to the next, high up too.
    let frequency = || match plant {
        Plant::Plays | Plant::Relays => Axis::log("Frequency", "Hz"),
        Plant::Bimorph => Axis::linear("Frequency", "Hz"),
    };
    section.plot(
        curves("Sines: rms error", &rows, IDENTIFIED, frequency())
            .caption("Parameters identified from records of the plant. A gap: no drive."),
    );
    section.plot(
        curves(
            "Sines: rms error, plant 10 % off",
            &rows,
            WRONG,
            frequency(),
        )
        .caption("Median of five draws, the compensators as before."),
    );
    let rms: Pick = |errors| [errors.rms_um, errors.rms_percent];
    let largest: Pick = |errors| [errors.largest_um, errors.largest_percent];
    for (text, of, pick) in [
        ("Rms error", IDENTIFIED, rms),
        ("Largest error", IDENTIFIED, largest),
        ("Plant 10 % off, rms error", WRONG, rms),
        ("Plant 10 % off, largest error", WRONG, largest),
    ] {
        section.paragraph(format!(
            "{text} in µm, behind the stroke in % of the reference's {}.",
            if text.ends_with("rms error") || text.starts_with("Rms") {
                "rms"
            } else {
                "amplitude"
            }
        ));
        table(section, &rows, of, pick);
    }
    let reasons = reasons(&rows);
    if !reasons.is_empty() {
        section.paragraph("✕: more than a plant at rest would leave. Why, and why refused:");
        section.list(reasons);
    }
}

fn curves(title: &str, rows: &[&Row], of: Of, frequency: Axis) -> Plot {
    let sines = || rows.iter().filter(|row| row.input.shape == Shape::Sine);
    let x: Vec<f64> = sines().map(|row| row.input.frequency_hz).collect();
    COMPENSATORS.into_iter().fold(
        Plot::new(title, frequency, Axis::log("Rms error", "um")),
        |plot, compensator| {
            let y: Vec<f64> = sines()
                .map(|row| {
                    row.entry(compensator)
                        .map_or(f64::NAN, |entry| of(entry).rms_um())
                })
                .collect();
            plot.series(Series::new(compensator.name(), Style::LinePoints, &x, &y))
        },
    )
}

fn table(section: &mut Section, rows: &[&Row], of: Of, pick: Pick) {
    let names = COMPENSATORS.map(|compensator| compensator.name());
    let headers = std::iter::once("Reference").chain(names);
    let cell = |entry: &Entry| match of(entry) {
        Outcome::Refused { .. } => Cell::from("refused"),
        Outcome::Lost { errors, .. } => Cell::Text(format!("{}\u{a0}✕", pair(pick(errors)))),
        Outcome::Followed { errors } => Cell::Text(pair(pick(errors))),
    };
    section.table(
        headers,
        rows.iter().map(|row| {
            let first = std::iter::once(Cell::Text(place(&row.input)));
            first.chain(row.entries.iter().map(cell)).collect()
        }),
    );
}

fn pair([um, percent]: [f64; 2]) -> String {
    format!(
        "{}\u{a0}/\u{a0}{}",
        digits(um, 100.0),
        digits(percent, 10.0)
    )
}

/// As many digits as are worth reading: a whole number from `whole` on, two digits below one.
fn digits(value: f64, whole: f64) -> String {
    if value >= whole {
        format!("{value:.0}")
    } else if value >= 0.1 * whole {
        format!("{value:.1}")
    } else if value >= 0.1 {
        format!("{value:.2}")
    } else {
        format_number(format!("{value:.1e}").parse().unwrap_or(value))
    }
}

/// Why compensators were lost or refused: each reason once, with the references.
fn reasons(rows: &[&Row]) -> Vec<String> {
    let mut reasons: Vec<(String, Vec<String>)> = Vec::new();
    for row in rows {
        for entry in &row.entries {
            let (Outcome::Lost { reason, .. } | Outcome::Refused { reason }) = &entry.identified
            else {
                continue;
            };
            let text = format!("{}: {reason}", entry.compensator.name());
            match reasons.iter_mut().find(|(known, _)| *known == text) {
                Some((_, places)) => places.push(place(&row.input)),
                None => reasons.push((text, vec![place(&row.input)])),
            }
        }
    }
    let told = reasons.into_iter();
    told.map(|(text, places)| format!("{text} ({})", places.join(", ")))
        .collect()
}
