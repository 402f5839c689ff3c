//! The one visual language of every page the program writes.
//!
//! A [`Page`] is a single HTML file that needs no network and no second file: a verdict, a table of
//! key figures, then sections of text, [`Plot`]s and tables. Plots are inline SVG, visible without
//! scripts; a short script adds the values under the pointer. Series of any length are thinned to
//! what the drawing can show, extremes kept, so that a page stays well below 2 MB.
//!
//! ```
//! use hysteron_host::report::{Axis, KeyFigure, Page, Plot, Series, Style, Tone};
//!
//! let drive = [0.0, 50.0, 100.0];
//! let displacement = [0.0, 7.1, 15.2];
//! let mut page = Page::new("Identification of stage A");
//! page.verdict(Tone::Good, "The model follows the held-out record within 0.31 µm rms.");
//! page.figures([KeyFigure::new("rms.report", "Error on the held-out record, rms", 0.31, "µm")]);
//! page.section("How well it fits", |section| {
//!     section.plot(
//!         Plot::new("Loop", Axis::linear("Drive", "V"), Axis::linear("Displacement", "µm"))
//!             .series(Series::new("measured", Style::Line, &drive, &displacement)),
//!     );
//! });
//! let html = page.to_html();
//! assert!(html.contains("data-key=\"rms.report\" data-value=\"0.31\""));
//! ```

mod curve;
mod decimate;
mod frame;
mod ink;
mod number;
mod page;
mod plot;
mod scale;
mod svg;

pub use number::format_number;
pub use page::{Cell, KeyFigure, Page, Section, Tone};
pub use plot::{Axis, Plot, Proportion, Series, Style};
