//! The page of a diagnosis.

mod evidence;

use crate::dataset::Role;
use crate::report::{Axis, Cell, KeyFigure, Page, Plot, Section, Series, Style, Tone};

use super::diagnosis::{Diagnosis, RecordResiduals, Roles, Verdict, excess};
use super::localise::{Place, amplitudes};
use super::words::listed;

/// The page: verdict, figures, before and after, evidence, what was tried, parameters, notes.
/// `places` are what [`super::localise::localise`] says of the same diagnosis.
pub fn page(found: &Diagnosis, places: &[Place]) -> Page {
    let mut page = Page::new(format!("Diagnosis of {}", found.name));
    page.lead(format!(
        "{} records held against {}; effects that are missing, named and added.",
        found.before.records.len(),
        if found.refitted.is_some() {
            format!("the model \"{}\"", found.baseline_model.name)
        } else {
            "a baseline of plays".to_owned()
        }
    ));
    page.verdict(tone(found.verdict), found.sentence());
    page.figures(figures(found, places));
    page.section("Before and after", |section| shrink(section, found));
    page.section("Where the gap lies", |section| {
        evidence::evidence(section, found, places)
    });
    page.section("What was tried", |section| tried(section, found));
    page.section("Parameters", |section| parameters(section, found));
    page.section("What would tell more", |section| further(section, found));
    page
}

fn tone(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::Named | Verdict::None => Tone::Good,
        Verdict::Partial => Tone::Neutral,
        Verdict::Unknown => Tone::Bad,
    }
}

fn figures(found: &Diagnosis, places: &[Place]) -> Vec<KeyFigure> {
    let unit = found.unit.symbol();
    let mut figures = Vec::new();
    let mut rms = |key: &str, what: &str, roles: &Roles| {
        for (role, um) in [
            ("report", roles.report),
            ("select", roles.select),
            ("fit", roles.fit),
        ] {
            figures.extend(um.map(|um| {
                KeyFigure::new(
                    format!("gap.{key}.{role}"),
                    format!("{what}, {role} records, rms"),
                    found.unit.from_um(um),
                    unit,
                )
            }));
        }
    };
    rms("baseline", "Baseline", &found.baseline);
    if let Some(refitted) = &found.refitted {
        rms("refitted", "Baseline fitted anew", refitted);
    }
    rms("extended", "Extended model", &found.extended);
    figures.push(
        KeyFigure::new(
            "gap.noise_floor",
            "Noise floor, rms",
            found.unit.from_um(found.noise.0),
            unit,
        )
        .note(found.noise.1.describe()),
    );
    figures.push(
        KeyFigure::new(
            "gap.bar",
            "Bar, rms beyond the noise",
            found.unit.from_um(found.bar_um),
            unit,
        )
        .note("less than this is nothing"),
    );
    figures.extend(found.closed().map(|closed| {
        KeyFigure::new(
            "gap.closed",
            "Share of the gap closed, report records",
            closed,
            "",
        )
    }));
    for (i, effect) in found.effects.iter().enumerate() {
        figures.push(KeyFigure::new(
            format!("effects.{i}.left_over"),
            format!("Left over after adding {}", effect.effect.name()),
            effect.left_over,
            "",
        ));
    }
    if let Some(place) = places.first() {
        figures.push(
            KeyFigure::new(
                "where.0.share",
                "Share of the gap in its most telling place",
                place.share,
                "",
            )
            .note(format!("axis: {}", place.axis)),
        );
    }
    figures
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Fit => "fit",
        Role::Select => "select",
        Role::Report => "report",
    }
}

fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|e| e * e).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// Records with what baseline and extended model leave over of them.
fn pairs(found: &Diagnosis) -> impl Iterator<Item = (&RecordResiduals, &RecordResiduals)> {
    found.before.records.iter().filter_map(|before| {
        let after = found.after.records.iter();
        let mut after = after.filter(|after| after.name == before.name);
        Some((before, after.next()?))
    })
}

fn shrink(section: &mut Section, found: &Diagnosis) {
    let unit = found.unit.symbol();
    // Of each role the record that the baseline explains worst.
    let worst = [Role::Report, Role::Select, Role::Fit].map(|role| {
        pairs(found)
            .filter(|(before, _)| before.role == role)
            .max_by(|(a, _), (b, _)| rms(&a.residual_um).total_cmp(&rms(&b.residual_um)))
    });
    for (before, after) in worst.into_iter().flatten().take(2) {
        one_record(section, found, before, after);
    }
    section.table(
        [
            "Record".to_owned(),
            "Role".to_owned(),
            format!("Baseline, rms ({unit})"),
            format!("Extended, rms ({unit})"),
            "Gap closed (%)".to_owned(),
        ],
        pairs(found).map(|(before, after)| {
            let (a, b) = (rms(&before.residual_um), rms(&after.residual_um));
            let gap = excess(a, found.noise.0);
            let closed: Cell = if gap > found.bar_um {
                (100.0 * (1.0 - excess(b, found.noise.0) / gap)).into()
            } else {
                "–".into()
            };
            vec![
                before.name.as_str().into(),
                role(before.role).into(),
                found.unit.from_um(a).into(),
                found.unit.from_um(b).into(),
                closed,
            ]
        }),
    );
}

fn one_record(
    section: &mut Section,
    found: &Diagnosis,
    before: &RecordResiduals,
    after: &RecordResiduals,
) {
    let unit = found.unit.symbol();
    let converted =
        |um: &[f64]| -> Vec<f64> { um.iter().map(|&e| found.unit.from_um(e)).collect() };
    let (e0, e1) = (
        converted(&before.residual_um),
        converted(&after.residual_um),
    );
    let title = |what: &str| format!("{what}, {} ({})", before.name, role(before.role));
    let count = before.residual_um.len();
    let time: Vec<f64> = (0..count)
        .map(|k| before.start_s + k as f64 * before.sample_time_s)
        .collect();
    let three = 3.0 * found.unit.from_um(found.noise.0);
    section.plot(
        Plot::new(
            title("Residual over time"),
            Axis::linear("Time", "s"),
            Axis::linear("Measured − model", unit),
        )
        .caption("What baseline and extended model leave over of the record's scored part.")
        .series(Series::new("baseline", Style::Solid, &time, &e0))
        .series(Series::new("extended model", Style::Solid, &time, &e1))
        .series(Series::level("noise floor, 3 σ", three))
        .series(Series::level("noise floor, −3 σ", -three)),
    );
    let (hz, a0) = amplitudes(before);
    let (hz1, a1) = amplitudes(after);
    section.plot(
        Plot::new(
            title("Spectrum of the residual"),
            Axis::log("Frequency", "Hz"),
            Axis::log("Amplitude", unit),
        )
        .caption(
            "Amplitude of each line of the residual, over whole periods where the drive has any.",
        )
        .series(Series::new("baseline", Style::Solid, &hz, &converted(&a0)))
        .series(Series::new(
            "extended model",
            Style::Solid,
            &hz1,
            &converted(&a1),
        )),
    );
    section.plot(
        Plot::new(
            title("Loop"),
            Axis::linear("Drive", "V"),
            Axis::linear("Displacement", unit),
        )
        .caption("Measured displacement, and by the extended model.")
        .square()
        .series(Series::new(
            "measured",
            Style::Solid,
            &before.drive_v,
            &converted(&before.displacement_um),
        ))
        .series(Series::new(
            "extended model",
            Style::Line,
            &after.drive_v,
            &converted(
                &std::iter::zip(&after.displacement_um, &after.residual_um)
                    .map(|(y, e)| y - e)
                    .collect::<Vec<_>>(),
            ),
        )),
    );
    section.plot(
        Plot::new(
            title("Residual against the drive"),
            Axis::linear("Drive", "V"),
            Axis::linear("Measured − model", unit),
        )
        .caption("The same residuals against the drive.")
        .square()
        .series(Series::new("baseline", Style::Solid, &before.drive_v, &e0))
        .series(Series::new(
            "extended model",
            Style::Solid,
            &after.drive_v,
            &e1,
        )),
    );
}

fn tried(section: &mut Section, found: &Diagnosis) {
    let unit = found.unit.symbol();
    if found.screened.is_empty() {
        section.paragraph("No effect of the library can be shown by these records.");
    } else {
        section.paragraph(
            "The baseline with each effect of the library alone, everything fitted anew, on the select \
             records. Those that a first screening puts far behind are not looked at closely and not \
             listed.",
        );
        section.table(
            [
                "Effect".to_owned(),
                format!("Rms ({unit})"),
                "Left over of the gap (%)".to_owned(),
            ],
            found.screened.iter().map(|&(effect, um)| {
                let before = excess(
                    found.fitted_baseline().select.unwrap_or(f64::NAN),
                    found.noise.0,
                );
                let left = excess(um, found.noise.0) / before.max(f64::MIN_POSITIVE);
                vec![
                    effect.name().into(),
                    found.unit.from_um(um).into(),
                    (100.0 * left).into(),
                ]
            }),
        );
    }
    if !found.ablation.is_empty() {
        section.paragraph("The extended model without one of its effects, all else fitted anew.");
        section.table(
            [
                "Left out".to_owned(),
                format!("Rms on the select records ({unit})"),
            ],
            found.ablation.iter().map(|out| {
                vec![
                    out.effect.name().into(),
                    found.unit.from_um(out.select_um).into(),
                ]
            }),
        );
    }
}

fn parameters(section: &mut Section, found: &Diagnosis) {
    if !found.effects.is_empty() {
        section
            .paragraph("Parameters under the keys and in the units of model.toml (um, V, s, Hz).");
        section.table(
            [
                "Effect",
                "Parameter",
                "Value",
                "Low, 95 %",
                "High, 95 %",
                "Undone by the compensator",
            ],
            found.effects.iter().flat_map(|one| {
                let undone = if one.effect.template().inverted() {
                    "yes"
                } else {
                    "no"
                };
                one.numbers_with_intervals().map(move |(key, value, ends)| {
                    let end = |x: Option<f64>| x.map_or_else(|| "–".into(), Cell::from);
                    vec![
                        one.effect.name().into(),
                        key.into(),
                        value.into(),
                        end(ends.map(|ends| ends.0)),
                        end(ends.map(|ends| ends.1)),
                        undone.into(),
                    ]
                })
            }),
        );
    }
    let Some(hysteresis) = found.model.hysteresis() else {
        return;
    };
    let (gain, offset) = found.model.output();
    section.table(
        ["Core", "Value", "Unit"],
        [
            ("gain_um_per_v", gain, "um/V"),
            ("offset_um", offset, "um"),
            ("beta_s", hysteresis.beta_s, "s"),
            ("plays", hysteresis.thresholds_v.len() as f64, ""),
        ]
        .map(|(key, value, unit)| vec![key.into(), value.into(), unit.into()]),
    );
    let mut plot = Plot::new(
        "Weights by threshold",
        Axis::linear("Threshold", "V").including(0.0),
        Axis::linear("Weight", "V/V"),
    )
    .caption("Weight of each play operator; that of the drive itself is left out.");
    for (name, model) in [
        ("extended model", &found.model),
        ("baseline", &found.baseline_model),
    ] {
        if let Some(core) = model.hysteresis() {
            let weights = core.weights.get(1..).unwrap_or_default();
            plot = plot.series(Series::new(
                name,
                Style::LinePoints,
                &core.thresholds_v,
                weights,
            ));
        }
    }
    section.plot(plot);
}

fn further(section: &mut Section, found: &Diagnosis) {
    for one in found
        .effects
        .iter()
        .filter(|one| !one.also_possible.is_empty())
    {
        let rivals: Vec<&str> = one.also_possible.iter().map(|e| e.name()).collect();
        section.paragraph(format!(
            "In place of {} these records leave {} possible as well.",
            one.effect.name(),
            listed(&rivals)
        ));
    }
    match &found.next_record {
        Some(next) => section.paragraph(next.as_str()),
        None => section.paragraph("No effect found is ambiguous: no further record is asked for."),
    }
    section.list(found.notes.iter().cloned());
}
