//! The page of a run.

use super::experiment::{AMPLITUDE_UM, Followed, Kind, Outcome};
use crate::report::{Axis, Cell, KeyFigure, Page, Plot, Section, Series, Style, Tone};

/// Verdict, key figures, errors, traces, instructions.
pub fn page(outcome: &Outcome) -> Page {
    let mut page = Page::new("Processor in the loop");
    page.lead(format!(
        "The firmware in an emulated Cortex-M4F drives a simulated stage like the P-753.31C along \
         paper J's references, {AMPLITUDE_UM} µm, with the model p753 uploaded over the link."
    ));
    let (tone, text) = verdict(outcome);
    page.verdict(tone, text);
    page.figures(key_figures(outcome));
    page.section("Error with and without compensation", |section| {
        errors(section, outcome);
    });
    page.section("Traces", |section| {
        for followed in &outcome.followed {
            if followed.input.kind == Kind::TwoAmplitude || followed.input.key == "sine_100hz" {
                traces(section, followed, outcome.sample_time_s);
            }
        }
    });
    page.section("Instructions of a sample", |section| {
        instructions(section, &outcome.instructions);
    });
    page
}

fn verdict(outcome: &Outcome) -> (Tone, String) {
    if let Some(difference) = &outcome.first_difference {
        return (
            Tone::Bad,
            format!("Firmware and host do not agree: {difference}."),
        );
    }
    let held: u32 = outcome.followed.iter().map(|one| one.limited).sum();
    if held > 0 {
        return (
            Tone::Bad,
            format!("The limits of the settings held the drive back in {held} samples."),
        );
    }
    let largest = |of: fn(&Followed) -> f64| outcome.followed.iter().map(of).fold(0.0, f64::max);
    let text = format!(
        "Firmware and host agree bit for bit in {} samples; compensation takes the largest error \
         from {:.2} µm to {:.2} µm.",
        outcome.samples,
        largest(|one| one.without.max_um),
        largest(|one| one.with.max_um),
    );
    let tone = if outcome.improved() {
        Tone::Good
    } else {
        Tone::Bad
    };
    (tone, text)
}

fn key_figures(outcome: &Outcome) -> Vec<KeyFigure> {
    let (min, median, max) = outcome.instruction_range();
    let per_tick = |which: &str, label: &str, count: u32| {
        KeyFigure::new(
            format!("instructions_per_tick.{which}"),
            format!("Instructions of a sample with compensation, {label}"),
            f64::from(count),
            "",
        )
    };
    vec![
        KeyFigure::new(
            "samples",
            "Samples compared with the host",
            outcome.samples as f64,
            "",
        )
        .note("drive codes, states and link bytes, bit for bit"),
        per_tick("min", "least", min),
        per_tick("median", "median", median),
        per_tick("max", "most", max).note("whole interrupt; instructions are not cycles"),
        KeyFigure::new(
            "flash_bytes",
            "Flash",
            outcome.sizes.flash_bytes as f64,
            "bytes",
        )
        .note("of the firmware built for the emulator"),
        KeyFigure::new("ram_bytes", "RAM", outcome.ram_bytes() as f64, "bytes").note(format!(
            "{} of them stack at its deepest",
            outcome.stack_bytes
        )),
    ]
}

fn errors(section: &mut Section, outcome: &Outcome) {
    section.paragraph(
        "Without compensation the drive is the reference over the model's slope where all plays \
         slide. The error is taken at the sensor's samples after the first periods; the stage's \
         amplifier lag, sensor noise and the 12-bit converter of the sensor are in it.",
    );
    section.table(
        [
            "Reference",
            "largest without, µm",
            "largest with, µm",
            "rms without, µm",
            "rms with, µm",
        ],
        outcome.followed.iter().map(|one| {
            vec![
                Cell::from(one.input.name),
                one.without.max_um.into(),
                one.with.max_um.into(),
                one.without.rms_um.into(),
                one.with.rms_um.into(),
            ]
        }),
    );
}

fn traces(section: &mut Section, followed: &Followed, sample_time_s: f64) {
    // The last two periods: one of each amplitude where there are two.
    let shown = (2.0 / followed.input.frequency_hz / sample_time_s).round() as usize;
    let from = followed.reference_um.len().saturating_sub(shown);
    let time_ms: Vec<f64> = (0..shown).map(|k| k as f64 * sample_time_s * 1e3).collect();
    let error = |displacement: &[f64]| -> Vec<f64> {
        let pairs = displacement.iter().zip(&followed.reference_um);
        pairs.skip(from).map(|(y, r)| y - r).collect()
    };
    let time = || Axis::linear("Time", "ms");
    let name = followed.input.name;
    let trace = |label, values: &[f64]| Series::new(label, Style::Line, &time_ms, values);
    section.plot(
        Plot::new(
            format!("Displacement, {name}"),
            time(),
            Axis::linear("Displacement", "um"),
        )
        .series(trace("without", &followed.without_um[from..]))
        .series(trace("with", &followed.with_um[from..]))
        .series(trace("reference", &followed.reference_um[from..])),
    );
    section.plot(
        Plot::new(
            format!("Error, {name}"),
            time(),
            Axis::linear("Error", "um"),
        )
        .series(trace("without", &error(&followed.without_um)))
        .series(trace("with", &error(&followed.with_um))),
    );
}

fn instructions(section: &mut Section, ascending: &[u32]) {
    const BINS: u32 = 40;
    let (Some(&least), Some(&most)) = (ascending.first(), ascending.last()) else {
        return;
    };
    let width = (most - least) / BINS + 1;
    let mut counts = vec![0.0; ((most - least) / width + 1) as usize];
    for &count in ascending {
        counts[((count - least) / width) as usize] += 1.0;
    }
    let centres: Vec<f64> = (0..counts.len() as u32)
        .map(|bin| f64::from(least + bin * width) + f64::from(width - 1) / 2.0)
        .collect();
    section.plot(
        Plot::new(
            "Samples by their instructions",
            Axis::linear("Instructions", ""),
            Axis::linear("Samples", "").including(0.0),
        )
        .caption(
            "Samples with compensation, from the request of the interrupt to the return from it, \
             recording included. Counted, not estimated: the same in every run.",
        )
        .series(Series::new("samples", Style::Bars, &centres, &counts)),
    );
}
