//! The page of a campaign.

use super::Outcome;
use crate::report::{Cell, KeyFigure, Page, Tone};

/// Verdict, figures, the table of the kinds, what did not hold.
pub fn page(outcome: &Outcome) -> Page {
    let mut page = Page::new("Faults by the thousand");
    page.lead(if outcome.emulated {
        "Faults injected into the firmware in an emulated Cortex-M4F, compared with the host in every \
         sample and every byte."
    } else {
        "Faults injected into the firmware's control, safety and link on the host."
    });
    let injected = outcome.injected();
    if outcome.failures.is_empty() {
        page.verdict(
            Tone::Good,
            format!("What must hold held in all of {injected} faults."),
        );
    } else {
        page.verdict(
            Tone::Bad,
            format!("{} runs of {} broke.", outcome.failures.len(), outcome.runs),
        );
    }
    page.figures([
        KeyFigure::new("injected", "Faults injected", injected as f64, ""),
        KeyFigure::new("samples", "Samples judged", outcome.samples as f64, ""),
        KeyFigure::new("seed", "Seed of the first run", outcome.seed as f64, ""),
        KeyFigure::new("runs", "Runs", outcome.runs as f64, "")
            .note("each from power-on, with a seed of its own"),
    ]);
    page.section("Always required", |section| {
        section.list([
            "every code within the range of the settings in force, and within the slew limit of the \
             code before it",
            "with the driver off, the code at rest; no motion in Hold",
            "settings, model and what was saved are those that were acknowledged last, and every \
             acknowledged sample of a stream is played in its place",
            "after the fault: to rest by command within the time of the ramp, and a reference is \
             followed again",
        ]);
    });
    page.section("Kinds", |section| {
        section.table(
            ["Fault", "Required", "Injected", "Broken"],
            outcome.rows.iter().map(|row| {
                let broken = outcome.failures.iter();
                let broken = broken.filter(|one| one.fault == row.key).count();
                vec![
                    Cell::from(row.name),
                    row.required.into(),
                    (row.injected as usize).into(),
                    broken.into(),
                ]
            }),
        );
    });
    if !outcome.failures.is_empty() {
        page.section("What broke", |section| {
            section.list(outcome.failures.iter().map(|one| {
                format!(
                    "{}: {} (hysteron faults --seed {} --runs 1{})",
                    one.fault,
                    one.what,
                    one.seed,
                    if outcome.emulated {
                        " --firmware ELF"
                    } else {
                        ""
                    }
                )
            }));
        });
    }
    page
}
