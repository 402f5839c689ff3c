//! The section on where the gap lies.

use crate::report::{Axis, Plot, Section, Series, Style};

use super::super::diagnosis::Diagnosis;
use super::super::localise::{Bin, Place};

pub(super) fn evidence(section: &mut Section, found: &Diagnosis, places: &[Place]) {
    if places.is_empty() {
        section.paragraph("What the baseline leaves over is not above the noise anywhere.");
        return;
    }
    section.paragraph(
        "What the baseline leaves over beyond the noise on the fit and select records, the most telling \
         axis first. Bands hold nine of ten block bootstrap draws.",
    );
    section.list(
        places
            .iter()
            .map(|place| format!("{}: {}", heading(place), place.summary)),
    );
    let (plotted, listed): (Vec<&Place>, Vec<&Place>) = places
        .iter()
        .partition(|place| place.bins.iter().any(|bin| bin.at.is_finite()));
    for place in plotted {
        section.plot(plot(found, place));
    }
    for place in listed {
        table(section, found, place);
    }
}

fn heading(place: &Place) -> &'static str {
    match place.axis {
        "frequency" => "Frequency",
        "time" => "Time within the records",
        "record" => "Time over the records",
        "amplitude" => "Drive",
        "rate" => "Rate",
        "branch" => "Branch",
        "turning-point" => "Distance from the last turning point",
        _ => "Correlation",
    }
}

fn plot(found: &Diagnosis, place: &Place) -> Plot {
    let unit = found.unit.symbol();
    let of = |value: fn(&Bin) -> f64| -> Vec<f64> {
        let values = place.bins.iter().map(value);
        values.map(|um| found.unit.from_um(um)).collect()
    };
    let at: Vec<f64> = place.bins.iter().map(|bin| bin.at).collect();
    let (label, axis_unit) = place.along;
    let label: String = label
        .split_at_checked(1)
        .map_or_else(String::new, |(first, rest)| first.to_uppercase() + rest);
    let x = if place.log {
        Axis::log(label, axis_unit)
    } else {
        Axis::linear(label, axis_unit)
    };
    let plot = Plot::new(
        heading(place),
        x,
        Axis::linear("Baseline's residual, rms", unit).including(0.0),
    )
    .caption(if place.axis == "frequency" {
        "What each band of frequencies adds to the rms of all records."
    } else {
        "Rms of the residual in each bin."
    })
    .series(Series::new(
        "residual",
        Style::LinePoints,
        &at,
        &of(|bin| bin.rms_um),
    ))
    .series(Series::new(
        "5 %",
        Style::Line,
        &at,
        &of(|bin| bin.band_um.0),
    ))
    .series(Series::new(
        "95 %",
        Style::Line,
        &at,
        &of(|bin| bin.band_um.1),
    ));
    if place.axis == "frequency" {
        return plot;
    }
    let noise = Series::level("noise floor", found.unit.from_um(found.noise.0));
    let plot = plot.series(noise);
    if place.axis == "record" {
        plot
    } else {
        plot.square()
    }
}

fn table(section: &mut Section, found: &Diagnosis, place: &Place) {
    let unit = found.unit.symbol();
    if place.axis == "correlation" {
        section.table(
            [
                "Residual against",
                "Correlation",
                "Would explain of the gap (%)",
            ],
            place.bins.iter().map(|bin| {
                vec![
                    bin.label.as_str().into(),
                    bin.rms_um.into(),
                    (100.0 * bin.share).into(),
                ]
            }),
        );
        return;
    }
    section.table(
        [
            heading(place).to_owned(),
            format!("Rms ({unit})"),
            format!("5 % ({unit})"),
            format!("95 % ({unit})"),
            "Share of the gap (%)".to_owned(),
            "Share of the samples (%)".to_owned(),
        ],
        place.bins.iter().map(|bin| {
            vec![
                bin.label.as_str().into(),
                found.unit.from_um(bin.rms_um).into(),
                found.unit.from_um(bin.band_um.0).into(),
                found.unit.from_um(bin.band_um.1).into(),
                (100.0 * bin.share).into(),
                (100.0 * bin.expected).into(),
            ]
        }),
    );
}
