//! The page: verdict, key figures, sections.

use super::number::{display_text, display_unit, format_number};
use super::plot::Plot;
use super::svg;
use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("hover.js");

/// Forbids the browser every request, whatever a title or label may contain.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'";

/// A table of more columns is set smaller, so that it fits the page.
const DENSE: usize = 7;

/// A table of more columns is a matrix, its headers stand upright.
const MATRIX: usize = 12;

/// How a verdict is meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tone {
    /// The aim is met.
    Good,
    /// Neither met nor missed; a statement.
    Neutral,
    /// The aim is missed.
    Bad,
}

impl Tone {
    /// Class in the style sheet, sign, and the word for those who do not see the sign.
    fn marks(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::Good => ("good", "✓", "Good: "),
            Self::Neutral => ("neutral", "i", "Note: "),
            Self::Bad => ("bad", "✕", "Bad: "),
        }
    }
}

/// A number or a text in a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Shown with four significant digits; `data-value` holds it in full.
    Number(f64),
    /// Shown as it is.
    Text(String),
    /// A count shaded by its share, 0 to 1, in the colour of a tone; nothing for a count of zero.
    Shaded {
        /// The count.
        count: usize,
        /// How dark.
        share: f64,
        /// Which colour.
        tone: Tone,
    },
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<usize> for Cell {
    fn from(value: usize) -> Self {
        Self::Number(value as f64)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl Cell {
    fn shown(&self) -> String {
        match self {
            Self::Number(value) => format_number(*value),
            Self::Text(text) => display_text(text),
            Self::Shaded { count: 0, .. } => String::new(),
            Self::Shaded { count, .. } => count.to_string(),
        }
    }

    /// The value in full, as a test or a script reads it back.
    fn exact(&self) -> String {
        match self {
            Self::Number(value) => {
                let (plain, scientific) = (format!("{value}"), format!("{value:e}"));
                if plain.len() <= 20 { plain } else { scientific }
            }
            Self::Text(text) => text.clone(),
            Self::Shaded { count, .. } => count.to_string(),
        }
    }

    fn is_number(&self) -> bool {
        matches!(self, Self::Number(_) | Self::Shaded { .. })
    }

    /// Class and background of a shaded cell; pale enough at any share for the text on it.
    fn shade(&self) -> Option<(&'static str, String)> {
        match *self {
            Self::Shaded { count, share, tone } if count > 0 => {
                let percent = (10.0 + 40.0 * share.clamp(0.0, 1.0)).round();
                let mixed = format!("color-mix(in srgb, var(--tone) {percent}%, transparent)");
                Some((tone.marks().0, format!("background: {mixed}")))
            }
            _ => None,
        }
    }
}

/// A line of the key figures' table.
#[derive(Clone, Debug)]
pub struct KeyFigure {
    key: String,
    label: String,
    value: Cell,
    unit: String,
    note: String,
}

impl KeyFigure {
    /// A key figure; `key` names the same value in the JSON beside the page and becomes the `id`
    /// and `data-key` of its cell, whose `data-value` holds the value in full.
    pub fn new(
        key: impl Into<String>,
        label: impl Into<String>,
        value: impl Into<Cell>,
        unit: &str,
    ) -> Self {
        Self {
            key: key.into(),
            label: label.into(),
            value: value.into(),
            unit: display_unit(unit),
            note: String::new(),
        }
    }

    /// What the value should be held against: a limit, a published figure.
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.note = note.into();
        self
    }
}

#[derive(Clone, Debug)]
enum Block {
    Paragraph(String),
    List(Vec<String>),
    Plot(Box<Plot>),
    Table {
        headers: Vec<String>,
        rows: Vec<Vec<Cell>>,
    },
}

/// A titled part of a page; its content appears in the order in which it is added.
#[derive(Clone, Debug)]
pub struct Section {
    title: String,
    blocks: Vec<Block>,
}

impl Section {
    /// A paragraph of plain text.
    pub fn paragraph(&mut self, text: impl Into<String>) {
        self.blocks.push(Block::Paragraph(text.into()));
    }

    /// A list of short notes in plain text.
    pub fn list<T: Into<String>>(&mut self, items: impl IntoIterator<Item = T>) {
        self.blocks
            .push(Block::List(items.into_iter().map(Into::into).collect()));
    }

    /// A plot; square plots that follow each other share a row.
    pub fn plot(&mut self, plot: Plot) {
        self.blocks.push(Block::Plot(Box::new(plot)));
    }

    /// A table with one cell per header in every row.
    pub fn table<H: Into<String>>(
        &mut self,
        headers: impl IntoIterator<Item = H>,
        rows: impl IntoIterator<Item = Vec<Cell>>,
    ) {
        self.blocks.push(Block::Table {
            headers: headers.into_iter().map(Into::into).collect(),
            rows: rows.into_iter().collect(),
        });
    }
}

/// A self-contained HTML page.
#[derive(Clone, Debug)]
pub struct Page {
    title: String,
    lead: String,
    verdict: Option<(Tone, String)>,
    figures: Vec<KeyFigure>,
    sections: Vec<Section>,
}

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            lead: String::new(),
            verdict: None,
            figures: Vec::new(),
            sections: Vec::new(),
        }
    }

    /// The line under the title: which data, which model.
    pub fn lead(&mut self, text: impl Into<String>) -> &mut Self {
        self.lead = text.into();
        self
    }

    /// The one sentence a hurried reader takes away; a later call replaces an earlier one.
    pub fn verdict(&mut self, tone: Tone, text: impl Into<String>) -> &mut Self {
        self.verdict = Some((tone, text.into()));
        self
    }

    /// Adds lines to the table of key figures.
    pub fn figures(&mut self, figures: impl IntoIterator<Item = KeyFigure>) -> &mut Self {
        self.figures.extend(figures);
        self
    }

    /// Adds a section and lets `fill` add its content.
    pub fn section(
        &mut self,
        title: impl Into<String>,
        fill: impl FnOnce(&mut Section),
    ) -> &mut Self {
        let mut section = Section {
            title: title.into(),
            blocks: Vec::new(),
        };
        fill(&mut section);
        self.sections.push(section);
        self
    }

    /// The page as a complete HTML document, the same for the same content.
    pub fn to_html(&self) -> String {
        let mut plots = 0..;
        html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    title { (self.title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    (svg::markers())
                    main {
                        h1 { (self.title) }
                        @if !self.lead.is_empty() { p.lead { (display_text(&self.lead)) } }
                        @if let Some((tone, text)) = &self.verdict { (verdict(*tone, text)) }
                        @if !self.figures.is_empty() { (key_figures(&self.figures)) }
                        @for section in &self.sections {
                            section {
                                h2 { (section.title) }
                                @for group in section.blocks.chunk_by(both_plots) {
                                    (blocks(group, &mut plots))
                                }
                            }
                        }
                        footer { "hysteron " (env!("CARGO_PKG_VERSION")) }
                    }
                    div id="readout" role="status" {}
                    script { (PreEscaped(SCRIPT)) }
                }
            }
        }
        .into_string()
    }
}

fn both_plots(a: &Block, b: &Block) -> bool {
    matches!((a, b), (Block::Plot(_), Block::Plot(_)))
}

fn verdict(tone: Tone, text: &str) -> Markup {
    let (class, sign, word) = tone.marks();
    html! {
        p class={ "verdict " (class) } {
            span.sign aria-hidden="true" { (sign) }
            span { span.unseen { (word) } (display_text(text)) }
        }
    }
}

fn key_figures(figures: &[KeyFigure]) -> Markup {
    let noted = figures.iter().any(|figure| !figure.note.is_empty());
    html! {
        table.figures {
            thead {
                tr {
                    th scope="col" { "Key figure" }
                    th.number scope="col" { "Value" }
                    th scope="col" { "Unit" }
                    @if noted { th scope="col" { "Note" } }
                }
            }
            tbody {
                @for figure in figures {
                    tr {
                        th scope="row" { (display_text(&figure.label)) }
                        td.number id=(figure.key) data-key=(figure.key)
                            data-value=(figure.value.exact()) { (figure.value.shown()) }
                        td { (figure.unit) }
                        @if noted { td { (display_text(&figure.note)) } }
                    }
                }
            }
        }
    }
}

fn blocks(group: &[Block], plots: &mut impl Iterator<Item = usize>) -> Markup {
    html! {
        @if let [Block::Plot(_), ..] = group {
            div.plots {
                @for block in group {
                    @if let (Block::Plot(plot), Some(number)) = (block, plots.next()) {
                        (svg::figure(plot, number))
                    }
                }
            }
        } @else {
            @for block in group {
                @match block {
                    Block::Paragraph(text) => p { (display_text(text)) },
                    Block::List(items) => ul { @for item in items { li { (display_text(item)) } } },
                    Block::Table { headers, rows } => (table(headers, rows)),
                    Block::Plot(_) => {},
                }
            }
        }
    }
}

fn table(headers: &[String], rows: &[Vec<Cell>]) -> Markup {
    let numeric = |column: usize| {
        rows.iter()
            .any(|row| row.get(column).is_some_and(Cell::is_number))
    };
    html! {
        div.scroll {
            table.dense[headers.len() > DENSE].matrix[headers.len() > MATRIX] {
                thead {
                    tr {
                        @for (column, header) in headers.iter().enumerate() {
                            th.number[numeric(column)] scope="col" { (display_text(header)) }
                        }
                    }
                }
                tbody {
                    @for row in rows {
                        tr {
                            @for (column, cell) in row.iter().enumerate() {
                                @let (tone, style) = cell.shade().unzip();
                                td.number[numeric(column)].(tone.unwrap_or_default())[tone.is_some()]
                                    style=[style]
                                    data-value=[cell.is_number().then(|| cell.exact())] {
                                    (cell.shown())
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}
