//! The geometry of a series as SVG path data.
//!
//! Coordinates are relative whole numbers in tenths of a pixel, the shortest exact form.

use super::decimate::{Point, thin_line, thin_scatter};
use super::frame::{Frame, bar_positions, narrowest};
use super::number::machine;
use super::plot::{Plot, Series, Style};
use std::fmt::Write;

/// Most points drawn of one series: four per column of the widest plot, the need of a time trace.
const BUDGET: usize = 4_000;

/// Up to this many points the readout quotes the values themselves, not their place in the drawing.
const QUOTED: usize = 200;

const WIDEST_BAR: f64 = 36.0;

/// What is drawn of one series.
pub(super) struct Ink {
    pub path: String,
    /// The values of a short series, `x,y` separated by blanks.
    pub quoted: Option<String>,
    /// Number of points that could be drawn.
    pub drawable: usize,
    /// Number of points drawn.
    pub drawn: usize,
}

impl Ink {
    /// The series at `place` of `plot` inside `frame`.
    pub fn new(plot: &Plot, frame: &Frame, place: usize) -> Self {
        let series = &plot.series[place];
        if series.style == Style::Level {
            return Self::level(frame, series);
        }
        let points: Vec<Point> = std::iter::zip(&series.x, &series.y)
            .map(|(&x, &y)| (frame.x_at(x), frame.y_at(y)))
            .collect();
        let strokes = match series.style {
            Style::Points => vec![thin_scatter(&points, BUDGET)],
            _ => thin_line(&points, BUDGET),
        };
        let kept = strokes.concat();
        let bars = series.style == Style::Bars;
        let path = match series.style {
            Style::Bars => bar_path(plot, frame, place, kept.iter().map(|&i| points[i])),
            _ => line_path(&points, &strokes),
        };
        let quoted = (bars || kept.len() <= QUOTED).then(|| {
            let pair = |&i: &usize| format!("{},{}", machine(series.x[i]), machine(series.y[i]));
            kept.iter().map(pair).collect::<Vec<_>>().join(" ")
        });
        let drawable = points
            .iter()
            .filter(|(x, y)| x.is_finite() && y.is_finite())
            .count();
        Self {
            path,
            quoted,
            drawable,
            drawn: kept.len(),
        }
    }

    fn level(frame: &Frame, series: &Series) -> Self {
        let value = series.y.first().copied().unwrap_or(f64::NAN);
        let level = frame.y_at(value);
        if !level.is_finite() {
            return Self {
                path: String::new(),
                quoted: None,
                drawable: 0,
                drawn: 0,
            };
        }
        let path = line_path(&[(frame.left, level), (frame.right, level)], &[vec![0, 1]]);
        let ends = [frame.x.low, frame.x.high];
        let quoted = ends
            .map(|end| format!("{},{}", machine(end), machine(value)))
            .join(" ");
        Self {
            path,
            quoted: Some(quoted),
            drawable: 1,
            drawn: 1,
        }
    }
}

/// Bars of several series stand side by side around their x.
fn bar_path(
    plot: &Plot,
    frame: &Frame,
    place: usize,
    points: impl Iterator<Item = Point>,
) -> String {
    let is_bars = |series: &&Series| series.style == Style::Bars;
    let total = plot.series.iter().filter(is_bars).count() as f64;
    let before = plot.series[..place].iter().filter(is_bars).count() as f64;
    let pitch = narrowest(bar_positions(plot).map(|x| frame.x_at(x)));
    let width = (0.7 * pitch).clamp(1.0, WIDEST_BAR) / total;
    let base = tenths(frame.y_at(if frame.y.log { frame.y.low } else { 0.0 }));
    let mut path = String::new();
    for (x, y) in points {
        let left = tenths(x + (before - total / 2.0) * width);
        let _ = write!(
            path,
            "M{left} {base}V{}h{}V{base}z",
            tenths(y),
            tenths(width)
        );
    }
    path
}

fn line_path(points: &[Point], strokes: &[Vec<usize>]) -> String {
    let mut path = String::new();
    for stroke in strokes {
        let mut corners: Vec<(i64, i64)> = stroke
            .iter()
            .map(|&i| (tenths(points[i].0), tenths(points[i].1)))
            .collect();
        corners.dedup();
        let Some((first, rest)) = corners.split_first() else {
            continue;
        };
        let _ = write!(path, "M{} {}l", first.0, first.1);
        if rest.is_empty() {
            // A stroke without length: round caps make it a visible dot.
            path.push_str("0 0");
        }
        for (i, pair) in corners.windows(2).enumerate() {
            let blank = if i == 0 { "" } else { " " };
            let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            let _ = write!(path, "{blank}{dx} {dy}");
        }
    }
    path
}

fn tenths(pixels: f64) -> i64 {
    (10.0 * pixels).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_names_each_corner_once_and_lifts_the_pen_at_gaps() {
        let points = [(0.0, 0.0), (1.0, 2.0), (1.01, 2.01), (4.0, 1.5), (9.0, 9.0)];
        assert_eq!(
            line_path(&points, &[vec![0, 1, 2, 3], vec![4]]),
            "M0 0l10 20 30 -5M90 90l0 0"
        );
    }
}
