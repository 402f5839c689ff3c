//! The page of an identification.

use crate::dataset::Role;
use crate::report::{Axis, Cell, KeyFigure, Page, Plot, Section, Series, Style, Tone};

use super::outcome::{Identification, RecordFigures, Rms};

/// The share of the straight line's residual below which a model is called good.
const GOOD: f64 = 0.25;

/// The page: verdict, figures, plots of every record, parameters, notes.
pub fn page(found: &Identification) -> Page {
    let unit = found.unit.symbol();
    let mut page = Page::new(format!("Identification of {}", found.name));
    page.lead(found.describe_structure());
    let (tone, verdict) = verdict(found);
    page.verdict(tone, verdict);
    page.figures(figures(found));
    page.section("How well it fits", |section| {
        for record in shown(found) {
            loops(section, found, record);
        }
        for record in shown(found) {
            traces(section, found, record);
        }
    });
    if found.frequency_span > 1.5 {
        page.section("Error against frequency", |section| {
            frequencies(section, found)
        });
    }
    page.section("Parameters", |section| parameters(section, found));
    page.section("Records and notes", |section| {
        section.table(
            [
                "Record".to_owned(),
                "Role".to_owned(),
                format!("Residual, rms ({unit})"),
                format!("Straight line, rms ({unit})"),
                "Not scored (s)".to_owned(),
                "State at its start".to_owned(),
            ],
            found.records.iter().map(|record| {
                vec![
                    record.name.as_str().into(),
                    role(record.role).into(),
                    found.unit.from_um(record.rms_um).into(),
                    found.unit.from_um(record.line_rms_um).into(),
                    record.left_out_s.into(),
                    record.start.as_str().into(),
                ]
            }),
        );
        section.list(found.notes());
    });
    page
}

fn verdict(found: &Identification) -> (Tone, String) {
    // The figure that counts is the one on records that took no part in the fit.
    let (role, model, line) = [
        ("report", found.rms.report, found.line_rms.report),
        ("select", found.rms.select, found.line_rms.select),
        ("fit", found.rms.fit, found.line_rms.fit),
    ]
    .into_iter()
    .find_map(|(role, model, line)| Some((role, model?, line?)))
    .unwrap_or(("fit", f64::NAN, f64::NAN));
    let unit = found.unit.symbol();
    let length = |um: f64| format!("{} {unit}", short(found.unit.from_um(um)));
    let near_noise = found.noise.is_some_and(|(noise, _)| model <= 1.5 * noise);
    let text = format!(
        "On the {role} records the model leaves {} rms where a straight line leaves {}{}.",
        length(model),
        length(line),
        match found.noise {
            Some(_) if near_noise => ": the noise floor".to_owned(),
            Some((noise, _)) => format!("; the noise floor is {}", length(noise)),
            None => String::new(),
        }
    );
    (
        if near_noise || model < GOOD * line {
            Tone::Good
        } else {
            Tone::Neutral
        },
        text,
    )
}

/// Three significant digits.
fn short(value: f64) -> String {
    crate::report::format_number(value)
}

fn figures(found: &Identification) -> Vec<KeyFigure> {
    let unit = found.unit.symbol();
    let mut figures = Vec::new();
    let mut rms = |prefix: &str, what: &str, rms: &Rms| {
        for (role, value) in [
            ("fit", rms.fit),
            ("select", rms.select),
            ("report", rms.report),
        ] {
            if let Some(um) = value {
                figures.push(KeyFigure::new(
                    format!("{prefix}.{role}"),
                    format!("{what}, {role} records, rms"),
                    found.unit.from_um(um),
                    unit,
                ));
            }
        }
    };
    rms("rms", "Residual of the model", &found.rms);
    rms(
        "straight_line_rms",
        "Residual of a straight line",
        &found.line_rms,
    );
    if let Some(whole) = &found.whole {
        let what = format!("Residual of the model on all {} samples", whole.samples);
        rms("whole", &what, &whole.rms);
    }
    if let Some((noise, source)) = found.noise {
        figures.push(
            KeyFigure::new(
                "noise_floor",
                "Noise floor, rms",
                found.unit.from_um(noise),
                unit,
            )
            .note(source.describe()),
        );
    }
    let plays = found.model.hysteresis().map_or(0, |h| h.thresholds_v.len());
    figures.push(KeyFigure::new("plays", "Play operators", plays, ""));
    figures
}

/// The records that are plotted: the first of each role.
fn shown(found: &Identification) -> impl Iterator<Item = &RecordFigures> {
    [Role::Fit, Role::Select, Role::Report]
        .into_iter()
        .filter_map(|role| found.records.iter().find(|record| record.role == role))
}

fn converted(found: &Identification, um: &[f64]) -> Vec<f64> {
    um.iter().map(|&y| found.unit.from_um(y)).collect()
}

fn loops(section: &mut Section, found: &Identification, record: &RecordFigures) {
    let unit = found.unit.symbol();
    let from = scored_from(record);
    let (drive, measured, model) = (
        &record.drive_v[from..],
        &record.measured_um[from..],
        &record.model_um[from..],
    );
    section.plot(
        Plot::new(
            format!("Loops, {} ({})", record.name, role(record.role)),
            Axis::linear("Drive", "V"),
            Axis::linear("Displacement", unit),
        )
        .caption("Displacement against drive over the scored part of the record.")
        .square()
        .series(Series::new(
            "measured",
            Style::Solid,
            drive,
            &converted(found, measured),
        ))
        .series(Series::new(
            "model",
            Style::Line,
            drive,
            &converted(found, model),
        )),
    );
}

fn traces(section: &mut Section, found: &Identification, record: &RecordFigures) {
    let unit = found.unit.symbol();
    let from = scored_from(record);
    let residual: Vec<f64> = record
        .measured_um
        .iter()
        .zip(&record.model_um)
        .map(|(y, m)| found.unit.from_um(y - m))
        .collect();
    section.plot(
        Plot::new(
            format!(
                "Displacement over time, {} ({})",
                record.name,
                role(record.role)
            ),
            Axis::linear("Time", "s"),
            Axis::linear("Displacement", unit),
        )
        .caption("Measured, and by the model, the unscored start included.")
        .series(Series::new(
            "measured",
            Style::Solid,
            &record.time_s,
            &converted(found, &record.measured_um),
        ))
        .series(Series::new(
            "model",
            Style::Line,
            &record.time_s,
            &converted(found, &record.model_um),
        )),
    );
    let mut plot = Plot::new(
        format!("Residual, {} ({})", record.name, role(record.role)),
        Axis::linear("Time", "s"),
        Axis::linear("Measured − model", unit),
    )
    .caption("Measured less modelled displacement over the scored part of the record.")
    .series(Series::new(
        "residual",
        Style::Solid,
        &record.time_s[from..],
        &residual[from..],
    ));
    if let Some((noise, _)) = found.noise {
        let three = 3.0 * found.unit.from_um(noise);
        plot = plot
            .series(Series::level("noise floor, 3 σ", three))
            .series(Series::level("noise floor, -3 σ", -three));
    }
    section.plot(plot);
}

fn frequencies(section: &mut Section, found: &Identification) {
    let mut plot = Plot::new(
        "Residual of each record",
        Axis::log("Frequency of the record", "Hz"),
        Axis::linear("Residual, rms", found.unit.symbol()).including(0.0),
    )
    .caption("Median frequency at which the record moves, and its rms residual.");
    for wanted in [Role::Fit, Role::Select, Role::Report] {
        let mut points: Vec<(f64, f64)> = found
            .records
            .iter()
            .filter(|record| record.role == wanted)
            .filter_map(|record| Some((record.frequency_hz?, found.unit.from_um(record.rms_um))))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (x, y): (Vec<f64>, Vec<f64>) = points.into_iter().unzip();
        if !x.is_empty() {
            plot = plot.series(Series::new(role(wanted), Style::Points, &x, &y));
        }
    }
    if let Some((noise, _)) = found.noise {
        plot = plot.series(Series::level("noise floor", found.unit.from_um(noise)));
    }
    section.plot(plot);
}

fn parameters(section: &mut Section, found: &Identification) {
    let Some(hysteresis) = found.model.hysteresis() else {
        return;
    };
    let (gain, offset) = found.model.output();
    section.plot(
        Plot::new(
            "Weights by threshold",
            Axis::linear("Threshold", "V").including(0.0),
            Axis::linear("Weight", "V/V"),
        )
        .caption("Weight of each play operator; the weight of the drive itself stands at zero.")
        .series(Series::new(
            "weight",
            Style::Bars,
            &[&[0.0], &hysteresis.thresholds_v[..]].concat(),
            &hysteresis.weights,
        )),
    );
    section.table(
        ["Play", "Threshold (V)", "Weight (V/V)"],
        hysteresis.weights.iter().enumerate().map(|(i, &weight)| {
            let threshold = match i.checked_sub(1) {
                Some(play) => hysteresis.thresholds_v[play],
                None => 0.0,
            };
            vec![i.into(), threshold.into(), weight.into()]
        }),
    );
    let mut rows: Vec<Vec<Cell>> = vec![
        vec!["gain_um_per_v".into(), gain.into(), "um/V".into()],
        vec!["offset_um".into(), offset.into(), "um".into()],
        vec!["beta_s".into(), hysteresis.beta_s.into(), "s".into()],
    ];
    if let Some(map) = found.model.asymmetry() {
        for (side, thresholds, slopes) in [
            ("positive", &map.thresholds.positive, &map.slopes.positive),
            ("negative", &map.thresholds.negative, &map.slopes.negative),
        ] {
            let thresholds = std::iter::once(0.0).chain(thresholds.iter().copied());
            for (i, (threshold, &slope)) in thresholds.zip(slopes).enumerate() {
                rows.push(vec![
                    format!("slopes.{side}[{i}], from {} V", short(threshold)).into(),
                    slope.into(),
                    "V/V".into(),
                ]);
            }
        }
    }
    section.table(["Parameter", "Value", "Unit"], rows);
}

fn scored_from(record: &RecordFigures) -> usize {
    let left_out = record.time_s[0] + record.left_out_s;
    record
        .time_s
        .partition_point(|&t| t < left_out - 1e-9)
        .min(record.time_s.len() - 1)
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Fit => "fit",
        Role::Select => "select",
        Role::Report => "report",
    }
}
