//! `blind.json` and its page.

use crate::report::{Axis, Cell, KeyFigure, Page, Plot, Section, Series, Style, Tone};

use super::outcome::{Outcome, REVEALED};
use super::run::Blind;
use super::scores::{ByEffect, Confusion, Scores, Share};

impl Blind {
    /// The page.
    pub fn page(&self) -> Page {
        let scores = &self.scores;
        let plan = &self.plan;
        let mut page = Page::new("Blind trials of the diagnosis");
        page.lead(format!(
            "{} cases of tier {}, protocol {}, noise {} to {} % of the stroke, seeds from {}. An \
             effect must be found where it moves what the refitted baseline leaves on the select \
             records by at least {REVEALED} times the noise.",
            plan.cases,
            plan.tier.number(),
            plan.protocol.name(),
            plan.noise.low,
            plan.noise.high,
            plan.seed,
        ));
        let (tone, text) = verdict(self);
        page.verdict(tone, text);
        page.figures(figures(self));
        if !scores.confusion.truths.is_empty() {
            page.section("What was hidden, what was named", |section| {
                section.paragraph(
                    "All cases with one effect or none, whatever the size of the effect. A row is a \
                     hidden effect, a column the first name with the verdict named, or the verdict; \
                     shades are shares of the row.",
                );
                confusion(section, &scores.confusion);
            });
        }
        page.section("From which size on effects are found", |section| {
            section.plot(curve(scores));
            section.table(
                ["Reach, from", "to", "Cases", "Solved", "Share"],
                scores.detection.iter().map(|bin| {
                    vec![
                        bin.from.into(),
                        bin.to.map_or(Cell::from("more"), Cell::Number),
                        bin.solved.of.into(),
                        bin.solved.count.into(),
                        optional(bin.solved.rate()),
                    ]
                }),
            );
        });
        if !scores.by_effect.is_empty() {
            page.section("By effect", |section| by_effect(section, &scores.by_effect));
        }
        page.section("What went wrong", |section| {
            failures(section, &self.outcomes)
        });
        page
    }
}

fn optional(value: Option<f64>) -> Cell {
    value.map_or(Cell::from("–"), Cell::Number)
}

fn shown(share: Share) -> Cell {
    if share.of == 0 {
        return "–".into();
    }
    format!("{} of {}", share.count, share.of).into()
}

fn verdict(blind: &Blind) -> (Tone, String) {
    let scores = &blind.scores;
    let found = if blind.plan.effects == 1 {
        scores.top_1
    } else {
        scores.exact
    };
    let tone = if scores.false_names.count == 0 && found.count == found.of && found.of > 0 {
        Tone::Good
    } else {
        Tone::Neutral
    };
    let (what, how) = if blind.plan.effects == 1 {
        ("effects", "first")
    } else {
        ("sets of effects", "exactly")
    };
    let mut text = format!(
        "{} of {} {what} that must be found are named {how}, the truth is among the names in {}",
        found.count, found.of, scores.in_set.count,
    );
    let none = scores.false_names;
    text += &if none.of > 0 {
        format!(
            "; something is named in {} of {} cases without effect.",
            none.count, none.of
        )
    } else {
        ".".to_owned()
    };
    (tone, text)
}

fn figures(blind: &Blind) -> Vec<KeyFigure> {
    let scores = &blind.scores;
    let mut figures = Vec::new();
    for (key, label, share) in [
        ("revealed", "Effects that must be found", scores.revealed),
        ("top_1", "Named, truth first", scores.top_1),
        (
            "top_1_or_partial",
            "Named or partial, truth first",
            scores.top_1_or_partial,
        ),
        ("in_set", "Truth in the set", scores.in_set),
        ("exact", "All named and nothing else", scores.exact),
        ("surplus", "More named than hidden", scores.surplus),
        (
            "solved_below",
            "Smaller effects, solved all the same",
            scores.solved_below,
        ),
        (
            "misnamed_below",
            "Smaller effects, first name wrong",
            scores.misnamed_below,
        ),
        (
            "false_names",
            "No effect, something named",
            scores.false_names,
        ),
        ("false_alarms", "No effect, unknown", scores.false_alarms),
        (
            "flagged",
            "Template left out, unknown or partial",
            scores.flagged,
        ),
        ("errors", "Diagnoses that failed", scores.errors),
    ] {
        if let (Some(rate), Some((low, high))) = (share.rate(), share.interval()) {
            let key = format!("scores.{key}.rate");
            figures.push(KeyFigure::new(key, label, rate, "").note(format!(
                "{} of {}; 95 %: {low:.2} to {high:.2}",
                share.count, share.of
            )));
        }
    }
    if let Some(size) = scores.mean_set_size {
        figures.push(KeyFigure::new(
            "scores.mean_set_size",
            "Mean size of the set",
            size,
            "",
        ));
    }
    for (key, label, unit, spread) in [
        ("closed", "Gap closed, median", "", scores.closed),
        (
            "seconds",
            "Time of a diagnosis on one core, median",
            "s",
            scores.seconds,
        ),
    ] {
        if let Some(spread) = spread {
            let key = format!("scores.{key}.median");
            figures.push(
                KeyFigure::new(key, label, spread.median, unit)
                    .note(format!("{:.3} to {:.3}", spread.least, spread.largest)),
            );
        }
    }
    figures
}

fn confusion(section: &mut Section, confusion: &Confusion) {
    let headers = ["Hidden"].into_iter().map(str::to_owned);
    let headers = headers.chain(confusion.answers.iter().cloned());
    let rows = confusion
        .truths
        .iter()
        .zip(&confusion.counts)
        .map(|(truth, counts)| {
            let all = counts.iter().sum::<usize>().max(1) as f64;
            let cells = counts
                .iter()
                .zip(&confusion.answers)
                .map(|(&count, answer)| {
                    let right = truth == answer;
                    Cell::Shaded {
                        count,
                        share: count as f64 / all,
                        tone: if right { Tone::Good } else { Tone::Bad },
                    }
                });
            [Cell::from(truth.as_str())]
                .into_iter()
                .chain(cells)
                .collect()
        })
        .collect::<Vec<Vec<Cell>>>();
    section.table(headers, rows);
}

fn curve(scores: &Scores) -> Plot {
    let x: Vec<f64> = scores.detection.iter().map(|bin| bin.middle()).collect();
    let rate = |bin: &super::Bin| bin.solved.rate().unwrap_or(f64::NAN);
    let y: Vec<f64> = scores.detection.iter().map(rate).collect();
    let bound = |upper: bool| -> Vec<f64> {
        let bins = scores.detection.iter();
        bins.map(|bin| match bin.solved.interval() {
            Some((low, high)) => {
                if upper {
                    high
                } else {
                    low
                }
            }
            None => f64::NAN,
        })
        .collect()
    };
    Plot::new(
        "Share of cases solved",
        Axis::log("How far the effect moves the gap, over the noise", ""),
        Axis::linear("Share", "").including(0.0),
    )
    .caption("One effect: verdict named, the truth first. Several: all of them and nothing else.")
    .series(Series::new("solved", Style::LinePoints, &x, &y))
    .series(Series::new(
        "95 %, lower end",
        Style::Line,
        &x,
        &bound(false),
    ))
    .series(Series::new(
        "95 %, upper end",
        Style::Line,
        &x,
        &bound(true),
    ))
}

fn by_effect(section: &mut Section, effects: &[ByEffect]) {
    section.paragraph("Cases in which the effects must be found.");
    section.table(
        [
            "Hidden",
            "Solved",
            "Truth in the set",
            "Flagged without its template",
        ],
        effects.iter().map(|one| {
            vec![
                one.effect.as_str().into(),
                shown(one.solved),
                shown(one.in_set),
                shown(one.flagged),
            ]
        }),
    );
}

fn failures(section: &mut Section, outcomes: &[Outcome]) {
    let wrong = |one: &&Outcome| !one.solved();
    if !outcomes.iter().any(|one| !one.solved()) {
        section.paragraph("Nothing.");
        return;
    }
    section.paragraph(format!(
        "Every case that is not solved; those with a reach under {REVEALED} need not be. The command \
         writes the data again, for hysteron diagnose."
    ));
    section.table(
        [
            "Hidden",
            "Answer",
            "Reach",
            "Strength (%)",
            "Noise (%)",
            "Noise found over true",
            "Gap closed",
            "Seed",
            "To see it again",
        ],
        outcomes.iter().filter(wrong).map(|one| {
            let answer = one.answer.as_ref().ok();
            vec![
                one.hidden().into(),
                one.in_words().into(),
                optional(answer.map(|answer| answer.reach)),
                one.case.strength.into(),
                one.case.noise_percent.into(),
                optional(answer.map(|answer| answer.noise_ratio)),
                optional(answer.and_then(|answer| answer.closed)),
                one.case.seed.to_string().into(),
                one.command().into(),
            ]
        }),
    );
}
