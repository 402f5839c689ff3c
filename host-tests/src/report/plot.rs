//! What a plot shows: axes, series, styles. How it is drawn is in `svg`.

use super::number::display_unit;

/// One axis: title, unit, scale.
#[derive(Clone, Debug)]
pub struct Axis {
    pub(super) label: String,
    pub(super) unit: String,
    pub(super) log: bool,
    pub(super) include: Option<f64>,
}

impl Axis {
    /// A linear axis. An empty `unit` marks a dimensionless quantity; `um` is printed as µm.
    pub fn linear(label: impl Into<String>, unit: &str) -> Self {
        Self {
            label: label.into(),
            unit: display_unit(unit),
            log: false,
            include: None,
        }
    }

    /// A logarithmic axis; values that are not positive cannot be drawn and leave a gap.
    pub fn log(label: impl Into<String>, unit: &str) -> Self {
        Self {
            log: true,
            ..Self::linear(label, unit)
        }
    }

    /// Widens the drawn range so that it contains `value`, in the unit of the axis.
    pub fn including(mut self, value: f64) -> Self {
        self.include = Some(value);
        self
    }
}

/// How a series is drawn.
///
/// Colour, dash pattern and marker follow from the place of the series in its plot, so that series
/// differ in more than colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line, the first of a plot solid, later ones dashed each in its own way.
    Line,
    /// A line without dashes at any place; for noisy traces, in which dashes would be lost.
    Solid,
    /// Markers only.
    Points,
    /// Markers joined by a line.
    LinePoints,
    /// A bar from zero to each value (from the lower edge on a logarithmic axis).
    Bars,
    /// A horizontal line over the whole width, at the first value of `y`: a limit, a noise floor.
    Level,
}

/// A named sequence of points in the units of the axes.
#[derive(Clone, Debug)]
pub struct Series {
    pub(super) label: String,
    pub(super) style: Style,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
}

impl Series {
    /// A series of points (`x[i]`, `y[i]`).
    ///
    /// A point with a coordinate that is not finite, or beyond 1e100 in size, is not drawn and
    /// interrupts the line. If one slice is shorter, the surplus of the other is not drawn.
    pub fn new(label: impl Into<String>, style: Style, x: &[f64], y: &[f64]) -> Self {
        Self {
            label: label.into(),
            style,
            x: x.to_vec(),
            y: y.to_vec(),
        }
    }

    /// A horizontal line at `y`, such as a limit or a noise floor.
    pub fn level(label: impl Into<String>, y: f64) -> Self {
        Self::new(label, Style::Level, &[], &[y])
    }
}

/// Width and height of a plot on the page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Proportion {
    /// The full width of the page: time traces, frequency axes.
    #[default]
    Wide,
    /// Nearly square, two beside each other where the page is wide enough: loops, bars.
    Square,
}

/// A plot with its title, axes and series.
#[derive(Clone, Debug)]
pub struct Plot {
    pub(super) title: String,
    pub(super) caption: String,
    pub(super) x: Axis,
    pub(super) y: Axis,
    pub(super) proportion: Proportion,
    pub(super) series: Vec<Series>,
}

impl Plot {
    /// An empty wide plot.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis) -> Self {
        Self {
            title: title.into(),
            caption: String::new(),
            x,
            y,
            proportion: Proportion::Wide,
            series: Vec::new(),
        }
    }

    /// What the plot shows in words: printed under the title, read out in place of the drawing.
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Draws the plot nearly square, as [`Proportion::Square`].
    pub fn square(mut self) -> Self {
        self.proportion = Proportion::Square;
        self
    }

    /// Adds a series; later series lie over earlier ones.
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }
}
