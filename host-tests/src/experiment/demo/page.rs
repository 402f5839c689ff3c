//! The page of the demonstration.

use crate::dataset::Role;
use crate::report::{Axis, Cell, KeyFigure, Page, Plot, Section, Series, Style, Tone};

use super::{Demonstration, Tracking};

/// A compensated stage is expected to err by less than this share of what it does without.
const GOOD: f64 = 0.25;

/// The page.
pub fn page(demonstration: &Demonstration) -> Page {
    let found = &demonstration.found;
    let mut page = Page::new("Demonstration: from measured records to a compensated drive");
    page.lead(
        "A simulated piezo stage of 100 µm travel (continuous hysteresis, rate dependence, 16-bit \
         converter, amplifier lag, 10 nm sensor noise) was measured, identified from the records \
         in data/, and driven along two references.",
    );
    let (tone, text) = verdict(demonstration);
    page.verdict(tone, text);
    page.figures(figures(demonstration));
    page.section("Driven along a reference", |section| {
        section.paragraph(
            "Without compensation the drive is the reference over the slope of the best straight \
             line; with it, the inverse of the identified model. The first period, in which the \
             stage leaves its initial state, is drawn but not scored. The lag of the amplifier is \
             part of the errors.",
        );
        for tracking in &demonstration.tracking {
            section.plot(against_reference(tracking));
        }
        for tracking in &demonstration.tracking {
            section.plot(errors(tracking));
        }
    });
    page.section("What was identified", |section| {
        section.paragraph(format!(
            "{}. The multisine below was not used to fit or to choose anything.",
            found.describe_structure()
        ));
        report_record(section, demonstration);
        section.table(
            [
                "Record",
                "Role",
                "Model, rms (µm)",
                "Straight line, rms (µm)",
            ],
            found.records.iter().map(|record| {
                vec![
                    record.name.as_str().into(),
                    role(record.role).into(),
                    record.rms_um.into(),
                    record.line_rms_um.into(),
                ]
            }),
        );
    });
    if let Some(discovery) = &demonstration.discovery {
        discovery.show(&mut page);
    }
    page.section("What to do with your own stage", |section| {
        section.list([
            "Record drive voltage and displacement as CSV and list the files in a dataset.toml, as \
             in data/.",
            "hysteron identify data/ --out stage/ writes model.toml, identification.json and a page.",
            "hysteron compensate --model stage/model.toml --reference scan.csv --out drive.csv \
             writes the drive.",
        ]);
    });
    page
}

fn verdict(demonstration: &Demonstration) -> (Tone, String) {
    let parts: Vec<String> = demonstration
        .tracking
        .iter()
        .map(|tracking| {
            let [without, with] = tracking.largest_um;
            format!(
                "from {without:.1} to {with:.2} µm along a {}",
                tracking.name
            )
        })
        .collect();
    let good = demonstration
        .tracking
        .iter()
        .all(|tracking| tracking.largest_um[1] < GOOD * tracking.largest_um[0]);
    let mut text = format!(
        "Compensation lowers the largest error {}.",
        parts.join(", and ")
    );
    if let Some(discovery) = &demonstration.discovery {
        text += &discovery.sentence();
    }
    (if good { Tone::Good } else { Tone::Neutral }, text)
}

fn figures(demonstration: &Demonstration) -> Vec<KeyFigure> {
    let mut figures = Vec::new();
    for (i, tracking) in demonstration.tracking.iter().enumerate() {
        for (key, what, both) in [
            ("largest_error_um", "Largest error", tracking.largest_um),
            ("rms_error_um", "Rms error", tracking.rms_um),
        ] {
            for (drive, value) in [("straight_line", both[0]), ("compensated", both[1])] {
                figures.push(KeyFigure::new(
                    format!("references.{i}.{key}.{drive}"),
                    format!("{what}, {}, {}", tracking.name, drive.replace('_', " ")),
                    value,
                    "um",
                ));
            }
        }
    }
    let found = &demonstration.found;
    for (key, what, um) in [
        (
            "identification.straight_line_report_rms_um",
            "Straight line on the report record, rms",
            found.line_rms.report,
        ),
        (
            "identification.report_rms_um",
            "Identified model on the report record, rms",
            found.rms.report,
        ),
        (
            "identification.noise_floor_um",
            "Noise floor, rms",
            found.noise.map(|(um, _)| um),
        ),
    ] {
        if let Some(um) = um {
            figures.push(KeyFigure::new(key, what, Cell::Number(um), "um"));
        }
    }
    figures.extend(demonstration.discovery.iter().flat_map(|one| one.figures()));
    figures
}

fn against_reference(tracking: &Tracking) -> Plot {
    let settled = tracking.settled..;
    let line = |label: &str, values: &[f64]| {
        Series::new(
            label,
            Style::Line,
            &tracking.reference_um[settled.clone()],
            &values[settled.clone()],
        )
    };
    Plot::new(
        format!("Loop, {}", tracking.name),
        Axis::linear("Reference", "um"),
        Axis::linear("Displacement", "um"),
    )
    .square()
    .series(line("straight line", &tracking.without_um))
    .series(line("compensated", &tracking.with_um))
}

fn errors(tracking: &Tracking) -> Plot {
    let line = |label: &str, values: &[f64]| {
        let error: Vec<f64> = tracking
            .reference_um
            .iter()
            .zip(values)
            .map(|(wanted, y)| wanted - y)
            .collect();
        Series::new(label, Style::Line, &tracking.time_s, &error)
    };
    Plot::new(
        format!("Error, {}", tracking.name),
        Axis::linear("Time", "s"),
        Axis::linear("Reference − displacement", "um"),
    )
    .series(line("straight line", &tracking.without_um))
    .series(line("compensated", &tracking.with_um))
}

fn report_record(section: &mut Section, demonstration: &Demonstration) {
    let Some(record) = demonstration
        .found
        .records
        .iter()
        .find(|record| record.role == Role::Report)
    else {
        return;
    };
    let scored_s = record
        .time_s
        .first()
        .map_or(0.0, |start| start + record.left_out_s);
    let from = record.time_s.partition_point(|&t| t < scored_s);
    section.plot(
        Plot::new(
            format!("Loops, {} (report)", record.name),
            Axis::linear("Drive", "V"),
            Axis::linear("Displacement", "um"),
        )
        .square()
        .series(Series::new(
            "measured",
            Style::Solid,
            &record.drive_v[from..],
            &record.measured_um[from..],
        ))
        .series(Series::new(
            "model",
            Style::Line,
            &record.drive_v[from..],
            &record.model_um[from..],
        )),
    );
    let residual: Vec<f64> = record
        .measured_um
        .iter()
        .zip(&record.model_um)
        .map(|(y, model)| y - model)
        .collect();
    section.plot(
        Plot::new(
            format!("Residual, {} (report)", record.name),
            Axis::linear("Time", "s"),
            Axis::linear("Measured − model", "um"),
        )
        .square()
        .series(Series::new(
            "residual",
            Style::Solid,
            &record.time_s[from..],
            &residual[from..],
        )),
    );
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Fit => "fit",
        Role::Select => "select",
        Role::Report => "report",
    }
}
