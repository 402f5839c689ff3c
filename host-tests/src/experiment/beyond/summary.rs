//! Where each compensator wins and where it breaks.

use serde::Serialize;

use super::compensators::{COMPENSATORS, Compensator};
use super::inputs::Input;
use super::plants::{PLANTS, Plant};
use super::sweep::{Entry, Outcome, Row};

/// How a compensator did on one plant, over all its references.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Standing {
    /// The plant.
    pub plant: Plant,
    /// The compensator.
    pub compensator: Compensator,
    /// Number of references.
    pub references: usize,
    /// At so many of them no other one leaves less.
    pub best: usize,
    /// The same on plants that are 10 % off.
    pub best_wrong: usize,
    /// At so many of them it leaves more than the straight line, or than standing still, or is refused.
    pub broken: usize,
    /// References at which it is refused, and why.
    pub refused: Vec<Refusal>,
    /// Median of the rms error, um, over the references at which it ran; `None` if it ran at none.
    pub median_rms_um: Option<f64>,
    /// The same on plants that are 10 % off.
    pub median_rms_um_wrong: Option<f64>,
    /// Largest rms error, um, over the same.
    pub worst_rms_um: Option<f64>,
    /// Where that is.
    pub worst_at: Option<Input>,
}

/// A reference without a drive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refusal {
    /// The reference.
    #[serde(flatten)]
    pub input: Input,
    /// Why.
    pub reason: String,
}

type Of = fn(&Entry) -> &Outcome;

const IDENTIFIED: Of = |entry| &entry.identified;
const WRONG: Of = |entry| &entry.wrong;

/// One standing a plant and compensator.
pub fn standings(rows: &[Row]) -> Vec<Standing> {
    let pairs = PLANTS
        .into_iter()
        .flat_map(|plant| COMPENSATORS.map(|compensator| (plant, compensator)));
    pairs
        .map(|(plant, compensator)| standing(rows, plant, compensator))
        .collect()
}

fn standing(rows: &[Row], plant: Plant, compensator: Compensator) -> Standing {
    let rows: Vec<&Row> = rows.iter().filter(|row| row.plant == plant).collect();
    let entries = || {
        let entry = |row: &&'_ Row| row.entry(compensator).cloned();
        rows.iter()
            .filter_map(move |row| Some((row.input, entry(row)?)))
    };
    let wins = |of: Of| {
        let best = rows.iter().filter_map(|row| row.best(of));
        best.filter(|(best, _)| *best == compensator).count()
    };
    let mut ran: Vec<(Input, f64)> = entries()
        .filter_map(|(input, entry)| Some((input, entry.identified.errors()?.rms_um)))
        .collect();
    ran.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut wrong: Vec<f64> = entries()
        .filter_map(|(_, entry)| Some(entry.wrong.errors()?.rms_um))
        .collect();
    wrong.sort_by(f64::total_cmp);
    let worst = ran.last();
    Standing {
        plant,
        compensator,
        references: rows.len(),
        best: wins(IDENTIFIED),
        best_wrong: wins(WRONG),
        broken: rows.iter().filter(|row| broken(row, compensator)).count(),
        refused: entries()
            .filter_map(|(input, entry)| match entry.identified {
                Outcome::Refused { reason } => Some(Refusal { input, reason }),
                _ => None,
            })
            .collect(),
        median_rms_um: ran.get(ran.len() / 2).map(|(_, um)| *um),
        median_rms_um_wrong: wrong.get(wrong.len() / 2).copied(),
        worst_rms_um: worst.map(|(_, um)| *um),
        worst_at: worst.map(|(input, _)| *input),
    }
}

/// Whether a compensator is not worth having along a reference.
pub fn broken(row: &Row, compensator: Compensator) -> bool {
    let line = row.entry(Compensator::None);
    let line_um = line.map_or(f64::INFINITY, |entry| entry.identified.rms_um());
    match row.entry(compensator).map(|entry| &entry.identified) {
        Some(Outcome::Followed { errors }) => errors.rms_um > line_um,
        Some(Outcome::Lost { .. } | Outcome::Refused { .. }) => true,
        None => false,
    }
}
