//! Four ways with and without a sensor.

use crate::experiment::beyond::Results;
use crate::experiment::beyond::feedback::{FourWays, gains};
use crate::experiment::beyond::plants::PLANTS;
use crate::report::{Cell, Section, format_number};

use super::standings::unbroken;
use super::three;

/// Table and sentences.
pub fn fill(section: &mut Section, results: &Results) {
    let gains: Vec<String> = PLANTS
        .into_iter()
        .map(|plant| {
            let gains = gains(plant);
            format!(
                "{}: {} V/µm and {} V/(µm s)",
                plant.title().to_lowercase(),
                format_number(gains.proportional),
                format_number(gains.integral)
            )
        })
        .collect();
    section.paragraph(format!(
        "A PI controller around the cascade, one sample late, on the same plants; it compares each \
         sample of the sensor with the reference of the same time. Gains ({}) keep away from where the \
         mode would sing. Linear: the reference over the mean gain. Rms error in µm.",
        gains.join("; ")
    ));
    section.table(
        [
            "Plant",
            "Hz",
            "Plant is",
            "Linear",
            "Compensated",
            "Feedback alone",
            "Both",
        ],
        results.feedback.iter().map(|row| {
            let mut cells: Vec<Cell> = vec![
                unbroken(row.plant.title()).into(),
                row.frequency_hz.into(),
                if row.wrong {
                    "10 % off"
                } else {
                    "as identified"
                }
                .into(),
            ];
            cells.extend(
                [row.linear, row.compensated, row.feedback, row.both]
                    .map(|errors| Cell::Number(errors.rms_um)),
            );
            cells
        }),
    );
    section.list(PLANTS.into_iter().map(|plant| {
        let rows = results.feedback.iter().filter(|row| row.plant == plant);
        sentence(plant.title(), &rows.collect::<Vec<_>>())
    }));
}

fn sentence(title: &str, rows: &[&FourWays]) -> String {
    let off: Vec<&&FourWays> = rows.iter().filter(|row| row.wrong).collect();
    let least = |of: fn(&FourWays) -> f64| {
        let values = off.iter().map(|row| of(row));
        values.fold((f64::INFINITY, 0.0f64), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    };
    let (low, high) = least(|row| row.compensated.rms_um / row.both.rms_um);
    let best = rows
        .iter()
        .filter(|row| {
            let both = row.both.rms_um;
            both <= row.linear.rms_um
                && both <= row.compensated.rms_um
                && both <= row.feedback.rms_um
        })
        .count();
    format!(
        "{title}: both together leave the least in {best} of {} rows; 10 % off, feedback takes the error \
         of the compensator down by a factor of {} to {}.",
        rows.len(),
        three(low),
        three(high)
    )
}
