//! Layout of a plot: ranges, ticks and where the axes lie, in pixels of the nominal size.

use super::decimate::Point;
use super::plot::{Axis, Plot, Proportion, Series, Style};
use super::scale::{Scale, Tick, drawable};

/// Advance of a digit in tick labels, pixels.
const DIGIT: f64 = 7.4;

/// The empty share of an axis beyond the data, horizontal and vertical.
const MARGINS: (f64, f64) = (0.02, 0.05);

/// The frame around the data and the scales inside it.
pub(super) struct Frame {
    pub x: Scale,
    pub y: Scale,
    pub x_ticks: Vec<Tick>,
    pub y_ticks: Vec<Tick>,
    pub width: f64,
    pub height: f64,
    pub left: f64,
    pub right: f64,
    pub top: f64,
    pub bottom: f64,
}

impl Frame {
    pub fn new(plot: &Plot) -> Self {
        let (width, height) = match plot.proportion {
            Proportion::Wide => (1000.0, 330.0),
            Proportion::Square => (490.0, 400.0),
        };
        let x = Scale::around(&plot.x, x_values(plot), MARGINS.0);
        let y = Scale::around(&plot.y, y_values(plot), MARGINS.1);
        let (top, bottom) = (10.0, height - 48.0);
        let y_ticks = y.ticks(((bottom - top) / 50.0) as usize);
        // A common least margin lets the frames of most plots on a page line up.
        let left = 34.0 + longest(&y_ticks).max(5.0 * DIGIT);
        let room = |ticks: &[Tick]| (width - left) / labels(ticks).count() as f64;
        let mut wanted = ((width - left) / 80.0) as usize;
        let mut x_ticks = x.ticks(wanted);
        while wanted > 1 && 1.5 * longest(&x_ticks) > room(&x_ticks) {
            wanted -= 1;
            x_ticks = x.ticks(wanted);
        }
        // No label may stand out beyond the edge of the drawing.
        let right = labels(&x_ticks).fold(width - 1.0, |right, (at, label)| {
            let edge = width - 0.5 * length(label);
            right.min(left + (edge - left) / x.fraction(at).max(0.1))
        });
        Self {
            x,
            y,
            x_ticks,
            y_ticks,
            width,
            height,
            left,
            right,
            top,
            bottom,
        }
    }

    pub fn x_at(&self, value: f64) -> f64 {
        self.left + self.x.fraction(value) * (self.right - self.left)
    }

    pub fn y_at(&self, value: f64) -> f64 {
        self.bottom - self.y.fraction(value) * (self.bottom - self.top)
    }
}

/// The labelled ticks and their texts.
pub(super) fn labels(ticks: &[Tick]) -> impl Iterator<Item = (f64, &str)> {
    ticks
        .iter()
        .filter_map(|tick| Some((tick.value, tick.label.as_deref()?)))
}

fn length(label: &str) -> f64 {
    DIGIT * label.chars().count() as f64
}

fn longest(ticks: &[Tick]) -> f64 {
    labels(ticks)
        .map(|(_, label)| length(label))
        .fold(0.0, f64::max)
}

/// All values the horizontal axis must hold; bars need half their pitch beside them.
fn x_values(plot: &Plot) -> impl Iterator<Item = f64> {
    let bars: Vec<f64> = bar_positions(plot).collect();
    let pitch = narrowest(bars.iter().copied());
    let half = match pitch.is_finite() {
        _ if plot.x.log => 0.0,
        true => 0.5 * pitch,
        false => bars.first().map_or(0.0, |x| 0.05 * x.abs()),
    };
    let points = plot
        .series
        .iter()
        .filter(|series| series.style != Style::Bars);
    let points = points
        .flat_map(|series| pairs(plot, series))
        .map(|(x, _)| x);
    points.chain(bars.into_iter().flat_map(move |x| [x - half, x + half]))
}

fn y_values(plot: &Plot) -> impl Iterator<Item = f64> {
    let of_points = plot
        .series
        .iter()
        .flat_map(|series| pairs(plot, series))
        .map(|(_, y)| y);
    let levels = plot
        .series
        .iter()
        .filter(|series| series.style == Style::Level);
    let levels = levels.filter_map(|series| series.y.first().copied());
    let base = plot
        .series
        .iter()
        .any(|series| series.style == Style::Bars)
        .then_some(0.0);
    of_points.chain(levels).chain(base)
}

/// Where the bars of a plot stand, in the unit of the horizontal axis.
pub(super) fn bar_positions(plot: &Plot) -> impl Iterator<Item = f64> {
    let bars = plot
        .series
        .iter()
        .filter(|series| series.style == Style::Bars);
    bars.flat_map(|series| pairs(plot, series)).map(|(x, _)| x)
}

/// The points of a series that have a place on both axes.
fn pairs<'a>(plot: &'a Plot, series: &'a Series) -> impl Iterator<Item = Point> + 'a {
    let on_axis = |value, axis: &Axis| drawable(value, axis.log);
    std::iter::zip(series.x.iter().copied(), series.y.iter().copied())
        .filter(move |&(x, y)| on_axis(x, &plot.x) && on_axis(y, &plot.y))
}

/// The least distance between two different values; infinite if there are none.
pub(super) fn narrowest(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.collect();
    sorted.sort_by(f64::total_cmp);
    let gaps = sorted
        .windows(2)
        .map(|pair| pair[1] - pair[0])
        .filter(|&gap| gap > 0.0);
    gaps.fold(f64::INFINITY, f64::min)
}
