//! The page of two models side by side.

use super::compare::{Compared, Reached};
use crate::report::{Axis, KeyFigure, Page, Plot, Section, Series, Style, Tone};

/// Verdict, key figures, what each compensator costs, traces, error traces.
pub fn comparison_page(compared: &Compared) -> Page {
    let mut page = Page::new(format!("Processor in the loop: {}", compared.name));
    page.lead(format!(
        "The firmware in an emulated Cortex-M4F drives one simulated stage along one reference, once \
         with the model \"{}\" and once with \"{}\" uploaded over the link.",
        compared.baseline.model, compared.extended.model
    ));
    let (tone, text) = verdict(compared);
    page.verdict(tone, text);
    page.figures(key_figures(compared));
    page.section("Both compensators", |section| both(section, compared));
    page.section("Traces", |section| traces(section, compared));
    page
}

fn named(compared: &Compared) -> [(&'static str, &Reached); 2] {
    [
        ("baseline", &compared.baseline),
        ("extended", &compared.extended),
    ]
}

fn verdict(compared: &Compared) -> (Tone, String) {
    if let Some(difference) = &compared.first_difference {
        return (
            Tone::Bad,
            format!("Firmware and host do not agree: {difference}."),
        );
    }
    let (before, after) = (
        compared.baseline.error.rms_um,
        compared.extended.error.rms_um,
    );
    let held: u32 = named(compared).iter().map(|(_, one)| one.limited).sum();
    let limits = match held {
        0 => String::new(),
        held => format!(" The limits of the settings held the drives back in {held} samples."),
    };
    let tone = if after < before && held == 0 {
        Tone::Good
    } else {
        Tone::Bad
    };
    let text = format!(
        "Firmware and host agree bit for bit in {} samples; the extended model takes the rms error \
         from {before:.3} µm to {after:.3} µm.{limits}",
        compared.samples
    );
    (tone, text)
}

fn key_figures(compared: &Compared) -> Vec<KeyFigure> {
    let mut figures = vec![
        KeyFigure::new(
            "samples",
            "Samples compared with the host",
            compared.samples as f64,
            "",
        )
        .note("drive codes, states and link bytes, bit for bit"),
    ];
    for (key, one) in named(compared) {
        let figure = |what: &str, label: &str, value: f64, unit: &str| {
            KeyFigure::new(
                format!("{key}.{what}"),
                format!("{label}, {key}"),
                value,
                unit,
            )
        };
        figures.push(figure("error_um.rms", "Rms error", one.error.rms_um, "um"));
        figures.push(figure(
            "error_um.max",
            "Largest error",
            one.error.max_um,
            "um",
        ));
    }
    figures
}

fn both(section: &mut Section, compared: &Compared) {
    section.paragraph(
        "The error is taken at the sensor's samples; the steps of converter and sensor are in it. The \
         latency is the time by which the stage follows later than it is asked to; the error does not \
         count it. Instructions are those of the whole interrupt, and not cycles.",
    );
    section.table(
        [
            "",
            "Model",
            "Compensator",
            "rms error, µm",
            "largest error, µm",
            "latency, samples",
            "latency, ms",
            "instructions, median",
            "instructions, most",
            "held back, samples",
        ],
        named(compared).map(|(role, one)| {
            let (_, median, most) = one.instructions;
            vec![
                role.into(),
                one.model.as_str().into(),
                one.inverse.into(),
                one.error.rms_um.into(),
                one.error.max_um.into(),
                one.latency.into(),
                (one.latency as f64 * compared.sample_time_s * 1e3).into(),
                f64::from(median).into(),
                f64::from(most).into(),
                f64::from(one.limited).into(),
            ]
        }),
    );
    let notes = named(compared).into_iter();
    let notes = notes.filter(|(_, one)| !one.left_out.is_empty());
    section.list(notes.map(|(role, one)| {
        let names = one.left_out.join(", ");
        format!("Left out of the {role} model, since no compensator undoes it: {names}.")
    }));
}

fn traces(section: &mut Section, compared: &Compared) {
    let reference = &compared.reference_um;
    let time_ms: Vec<f64> = (0..reference.len())
        .map(|k| k as f64 * compared.sample_time_s * 1e3)
        .collect();
    let time = || Axis::linear("Time", "ms");
    let mut displacement = Plot::new("Displacement", time(), Axis::linear("Displacement", "um"));
    let mut error = Plot::new("Error", time(), Axis::linear("Error", "um"));
    for (role, one) in named(compared) {
        let displacement_um = &one.displacement_um;
        let pairs = displacement_um.iter().zip(reference);
        let errors: Vec<f64> = pairs.map(|(y, v)| y - v).collect();
        let series = |values: &[f64]| Series::new(role, Style::Line, &time_ms, values);
        displacement = displacement.series(series(displacement_um));
        error = error.series(series(&errors));
    }
    section.plot(displacement.series(Series::new("reference", Style::Line, &time_ms, reference)));
    section.plot(error);
}
