//! A plot as `<figure>` with inline SVG: pixels of the nominal size, series in tenths of them.

use super::frame::{Frame, labels};
use super::ink::Ink;
use super::number::{display_text, format_number, power_of_ten};
use super::plot::{Axis, Plot, Proportion, Style};
use super::scale::{Scale, Tick};
use maud::{Markup, html};
use std::fmt::Write;

/// Number of colours, dash patterns and markers in the style sheet.
const KINDS: usize = 7;

/// Markers that series refer to; once on a page.
pub(super) fn markers() -> Markup {
    let shapes: [&str; KINDS] = [
        "M-38 0a38 38 0 1 0 76 0a38 38 0 1 0 -76 0z",
        "M-34 -34h68v68h-68z",
        "M0 -46L44 32H-44z",
        "M0 -49L49 0L0 49L-49 0z",
        "M0 46L44 -32H-44z",
        "M-14 -44h28v30h30v28h-30v30h-28v-30h-30v-28h30z",
        "M-40 -20L-20 -40L0 -20L20 -40L40 -20L20 0L40 20L20 40L0 20L-20 40L-40 20L-20 0z",
    ];
    html! {
        svg width="0" height="0" style="position:absolute" aria-hidden="true" {
            defs {
                @for (k, shape) in shapes.iter().enumerate() {
                    marker id={ "m" (k) } class={ "k" (k) } viewBox="-55 -55 110 110"
                        markerUnits="userSpaceOnUse" markerWidth="110" markerHeight="110" {
                        path d=(shape) {}
                    }
                }
            }
        }
    }
}

/// The whole figure; `number` counts plots on the page and makes ids unique.
pub(super) fn figure(plot: &Plot, number: usize) -> Markup {
    let frame = Frame::new(plot);
    let inks: Vec<Ink> = (0..plot.series.len())
        .map(|k| Ink::new(plot, &frame, k))
        .collect();
    html! {
        figure.plot.wide[plot.proportion == Proportion::Wide] {
            figcaption {
                strong { (plot.title) }
                @if !plot.caption.is_empty() { " " (display_text(&plot.caption)) }
            }
            ul.legend {
                @for (k, series) in plot.series.iter().enumerate() {
                    li { (swatch(k, series.style)) (series.label) }
                }
            }
            (drawing(plot, &frame, &inks, number))
            @if let Some(note) = thinning_note(plot, &inks) { p.note { (note) } }
        }
    }
}

fn drawing(plot: &Plot, frame: &Frame, inks: &[Ink], number: usize) -> Markup {
    let Frame {
        width,
        height,
        left,
        right,
        top,
        bottom,
        ..
    } = *frame;
    let center = (short(0.5 * (left + right)), short(0.5 * (top + bottom)));
    let description = format!("plot-{number}");
    let zero = !frame.y.log && frame.y.low < 0.0 && frame.y.high > 0.0;
    html! {
        svg viewBox={ "0 0 " (width) " " (height) } role="img" tabindex="0"
            aria-label=(plot.title) aria-describedby=(description)
            data-x=(mapping(&frame.x, left, right)) data-y=(mapping(&frame.y, bottom, top))
            data-x-name=(plot.x.label) data-x-unit=(plot.x.unit)
            data-y-name=(plot.y.label) data-y-unit=(plot.y.unit) {
            desc id=(description) { (describe(plot, frame)) }
            path.grid.minor d=(grid(frame, |tick| tick.label.is_none())) {}
            path.grid d=(grid(frame, |tick| tick.label.is_some())) {}
            @if zero {
                path.zero d={ "M" (short(left)) " " (short(frame.y_at(0.0))) "H" (short(right)) } {}
            }
            g.ticks.across {
                @for (at, label) in labels(&frame.x_ticks) {
                    text x=(short(frame.x_at(at))) y=(short(bottom + 18.0)) { (label) }
                }
            }
            g.ticks.up {
                @for (at, label) in labels(&frame.y_ticks) {
                    text x=(short(left - 8.0)) y=(short(frame.y_at(at) + 4.5)) { (label) }
                }
            }
            text.axis x=(center.0) y=(short(height - 7.0)) { (axis_title(&plot.x, &frame.x)) }
            text.axis transform={ "translate(14 " (center.1) ") rotate(-90)" } {
                (axis_title(&plot.y, &frame.y))
            }
            path.frame d={
                "M" (short(left)) " " (short(top)) "H" (short(right))
                "V" (short(bottom)) "H" (short(left)) "z"
            } {}
            g transform="scale(.1)" {
                @for (k, (series, ink)) in std::iter::zip(&plot.series, inks).enumerate() {
                    g class=(class(k, series.style)) data-label=(series.label)
                        data-points=[ink.quoted.as_ref()] {
                        path d=(ink.path) {}
                    }
                }
            }
            @if inks.iter().all(|ink| ink.drawn == 0) {
                text.axis x=(center.0) y=(center.1) { "no finite data" }
            }
            circle.cursor r="6" visibility="hidden" {}
        }
    }
}

fn grid(frame: &Frame, chosen: impl Fn(&&Tick) -> bool) -> String {
    let Frame {
        left,
        right,
        top,
        bottom,
        ..
    } = frame;
    let mut path = String::new();
    for tick in frame.x_ticks.iter().filter(&chosen) {
        let _ = write!(path, "M{:.1} {top}V{bottom}", frame.x_at(tick.value));
    }
    for tick in frame.y_ticks.iter().filter(&chosen) {
        let _ = write!(path, "M{left:.1} {:.1}H{right:.1}", frame.y_at(tick.value));
    }
    path
}

/// The drawing in words, for those who cannot see it.
fn describe(plot: &Plot, frame: &Frame) -> String {
    let axis = |axis: &Axis, scale: &Scale| {
        let (low, high) = (format_number(scale.low), format_number(scale.high));
        let kind = if scale.log { ", logarithmic" } else { "" };
        format!("{} from {low} to {high} {}{kind}", axis.label, axis.unit)
    };
    let names: Vec<&str> = plot
        .series
        .iter()
        .map(|series| series.label.as_str())
        .collect();
    format!(
        "{} Horizontal axis: {}. Vertical axis: {}. Series: {}.",
        display_text(&plot.caption),
        axis(&plot.x, &frame.x),
        axis(&plot.y, &frame.y),
        names.join(", ")
    )
}

fn class(place: usize, style: Style) -> String {
    let kind = match style {
        Style::Line => "line dashed",
        Style::Solid => "line",
        Style::Points => "marks",
        Style::LinePoints => "line marks",
        Style::Bars => "bars",
        Style::Level => "level",
    };
    format!("series k{} {kind}", place % KINDS)
}

fn swatch(place: usize, style: Style) -> Markup {
    let path = match style {
        Style::Bars => "M100 20h140v100h-140z",
        Style::Points => "M170 70l0 0l0 0",
        _ => "M10 70L170 70L330 70",
    };
    html! {
        svg.swatch viewBox="0 0 34 14" width="34" height="14" aria-hidden="true" {
            g class=(class(place, style)) transform="scale(.1)" { path d=(path) {} }
        }
    }
}

fn axis_title(axis: &Axis, scale: &Scale) -> String {
    let power = match scale.exponent() {
        0 => String::new(),
        exponent => format!("×{} ", power_of_ten(exponent)),
    };
    match format!("{power}{}", axis.unit).trim_end() {
        "" => axis.label.clone(),
        unit => format!("{} ({unit})", axis.label),
    }
}

/// What the readout script needs to go from the drawing back to values.
fn mapping(scale: &Scale, from: f64, to: f64) -> String {
    let kind = if scale.log { "log" } else { "linear" };
    format!("{kind} {:e} {:e} {from} {to}", scale.low, scale.high)
}

fn thinning_note(plot: &Plot, inks: &[Ink]) -> Option<String> {
    let thinned = std::iter::zip(&plot.series, inks).filter(|(_, ink)| ink.drawn < ink.drawable);
    let parts: Vec<String> = thinned
        .map(|(series, ink)| format!("{} {} of {}", series.label, ink.drawn, ink.drawable))
        .collect();
    (!parts.is_empty()).then(|| {
        format!(
            "Points drawn, extremes always among them: {}.",
            parts.join(", ")
        )
    })
}

fn short(pixels: f64) -> String {
    let text = format!("{pixels:.1}");
    text.strip_suffix(".0").map_or(text.clone(), str::to_owned)
}
