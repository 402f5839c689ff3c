//! The one error of the host program: bad input, told in one line that says what is wrong, where,
//! and what to do.

use std::fmt::{self, Display, Write as _};
use std::io;
use std::path::Path;

/// Bad input or an output that cannot be written.
///
/// `Display` is always exactly one line: line breaks and other control characters of quoted input
/// and inner messages are shown as spaces. The command line prints `error: {e}` and exits with 2.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// What the user handed over is wrong.
    #[error("{}", one_line(&format_args!("{place}: {problem}")))]
    Input {
        /// Where it is wrong.
        place: Place,
        /// What is wrong and, after a semicolon, what to do.
        problem: String,
    },
    /// The operating system refused to read or write a file.
    #[error("{}", one_line(&format_args!("{place}: {action}: {source}; {remedy}")))]
    File {
        /// The file.
        place: Place,
        /// What was tried, as in "cannot write".
        action: &'static str,
        /// What to do.
        remedy: &'static str,
        /// What the operating system said.
        source: io::Error,
    },
    /// A request that cannot be met, with no file to blame.
    #[error("{}", one_line(problem))]
    Request {
        /// What is wrong and, after a semicolon, what to do.
        problem: String,
    },
    /// The user ended the work; the command line exits with 130.
    #[error("interrupted; the output was told to stop")]
    Interrupted,
}

impl Error {
    /// A request that cannot be met; `problem` says what is wrong and what to do.
    pub fn request(problem: impl Into<String>) -> Self {
        Self::Request {
            problem: problem.into(),
        }
    }
}

/// A place in the user's files, shown as `file`, `file:line` or `file:line: column name`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    file: String,
    line: Option<u64>,
    column: Option<String>,
}

impl Place {
    /// A whole file or folder, named as the user named it.
    pub fn file(path: impl AsRef<Path>) -> Self {
        Self {
            file: path.as_ref().display().to_string(),
            line: None,
            column: None,
        }
    }

    /// The same file at a line, counted from 1.
    pub fn line(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }

    /// The same place in a named column.
    pub fn column(mut self, column: impl Into<String>) -> Self {
        self.column = Some(column.into());
        self
    }

    /// Bad input at this place; `problem` says what is wrong and what to do.
    pub fn error(self, problem: impl Into<String>) -> Error {
        Error::Input {
            place: self,
            problem: problem.into(),
        }
    }

    /// A refusal of the operating system at this place.
    pub fn io_error(self, action: &'static str, remedy: &'static str, source: io::Error) -> Error {
        Error::File {
            place: self,
            action,
            remedy,
            source,
        }
    }
}

impl Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ": column {column}")?;
        }
        Ok(())
    }
}

/// Runs of control characters and line separators become one space, so that the text is one line.
fn one_line(text: &dyn Display) -> String {
    let mut raw = String::new();
    // Writing to a String fails only if the Display inside does; what came before is then shown.
    let _ = write!(raw, "{text}");
    let breaks = |c: char| c.is_control() || matches!(c, '\u{2028}' | '\u{2029}');
    raw.split(breaks)
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .collect::<Vec<_>>()
        .join(" ")
}

/// Shows a piece of the user's text inside a message: quoted, and cut where it is long.
pub(crate) fn quoted(text: &str) -> String {
    const SHOWN: usize = 40;
    match text.char_indices().nth(SHOWN) {
        Some((cut, _)) => format!("\"{}...\"", &text[..cut]),
        None => format!("\"{text}\""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn place_is_shown_as_file_line_column() {
        let place = Place::file("a/b.csv");
        assert_eq!(place.to_string(), "a/b.csv");
        assert_eq!(place.clone().line(17).to_string(), "a/b.csv:17");
        assert_eq!(
            place.line(17).column("time_s").to_string(),
            "a/b.csv:17: column time_s"
        );
    }

    #[test]
    fn every_kind_is_one_line() {
        let inner = io::Error::other("disk\r\nfull");
        let cases = [
            Place::file("a\nb.csv").error("bad\n\n  thing\u{2028}; mend\x1b[2J it"),
            Place::file("a.csv").io_error("cannot write", "free some space", inner),
            Error::request("two\nlines"),
        ];
        let shown = cases.map(|error| error.to_string());
        assert_eq!(shown[0], "a b.csv: bad thing ; mend [2J it");
        assert_eq!(shown[1], "a.csv: cannot write: disk full; free some space");
        assert_eq!(shown[2], "two lines");
    }

    #[test]
    fn long_text_is_cut_between_characters() {
        assert_eq!(quoted("abc"), "\"abc\"");
        assert_eq!(
            quoted(&"µ".repeat(41)),
            format!("\"{}...\"", "µ".repeat(40))
        );
    }
}
