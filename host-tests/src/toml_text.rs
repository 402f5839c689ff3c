//! TOML files read with the line kept for every message, also for checks made after parsing.

use std::fmt;
use std::fs;
use std::path::Path;

use serde::Deserialize;
use serde::de::IntoDeserializer;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Error, Place};

/// The text of a TOML file and its name in messages.
pub(crate) struct TomlText<'a> {
    text: &'a str,
    place: Place,
}

/// One step into a TOML document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// A key of a table.
    Key(&'static str),
    /// An element of an array, from 0.
    Index(usize),
}

/// Reads a whole text file; a byte order mark is dropped.
pub(crate) fn read_text(path: &Path) -> Result<String, Error> {
    let place = Place::file(path);
    if path.is_dir() {
        return Err(place.error("is a folder; name a file"));
    }
    let bytes = fs::read(path).map_err(|source| {
        place
            .clone()
            .io_error("cannot read", "check the path and its permissions", source)
    })?;
    let mut text = String::from_utf8(bytes).map_err(|error| {
        let valid = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        place
            .line(line_after(valid))
            .error("not UTF-8 text; save the file as UTF-8")
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

impl<'a> TomlText<'a> {
    pub(crate) fn new(text: &'a str, place: Place) -> Self {
        Self { text, place }
    }

    /// The document as a table that knows where each value stands.
    pub(crate) fn table(&self) -> Result<Spanned<DeTable<'a>>, Error> {
        DeTable::parse(self.text).map_err(|error| self.syntax_error(&error))
    }

    /// A typed value; what serde refuses is told with its key and line.
    pub(crate) fn typed<T: Deserialize<'a>>(
        &self,
        value: Spanned<DeValue<'a>>,
    ) -> Result<T, Error> {
        let span = value.span();
        T::deserialize(value.into_deserializer()).map_err(|error| {
            let offset = error.span().unwrap_or(span).start;
            let keys = self.keys_at(offset);
            let colon = if keys.is_empty() { "" } else { ": " };
            self.at(offset)
                .error(format!("{keys}{colon}{}", error.message()))
        })
    }

    /// The place of a value, or of the innermost table around it that is there.
    pub(crate) fn place_of(&self, steps: &[Step]) -> Place {
        let Ok(table) = DeTable::parse(self.text) else {
            return self.place.clone();
        };
        let offset = table.span().start;
        let root = DeValue::Table(table.into_inner());
        let mut value = &root;
        let mut offset = offset;
        for step in steps {
            let next = match step {
                Step::Key(key) => value.as_table().and_then(|table| table.get(*key)),
                Step::Index(index) => value.as_array().and_then(|array| array.get(*index)),
            };
            let Some(next) = next else { break };
            offset = next.span().start;
            value = next.get_ref();
        }
        self.at(offset)
    }

    /// The place of a byte of the text.
    pub(crate) fn at(&self, offset: usize) -> Place {
        let end = offset.min(self.text.len());
        self.place
            .clone()
            .line(line_after(&self.text.as_bytes()[..end]))
    }

    fn syntax_error(&self, error: &toml::de::Error) -> Error {
        let place = error
            .span()
            .map_or_else(|| self.place.clone(), |span| self.at(span.start));
        place.error(error.message())
    }

    /// The dotted keys of the value that holds a byte of the text, or of the table that has a key
    /// there; empty for the whole document.
    fn keys_at(&self, offset: usize) -> String {
        let Ok(table) = DeTable::parse(self.text) else {
            return String::new();
        };
        let mut keys = Vec::new();
        find_in_table(table.get_ref(), offset, &mut keys);
        keys.concat().trim_start_matches('.').to_owned()
    }
}

fn find_in_table(table: &DeTable<'_>, offset: usize, keys: &mut Vec<String>) -> bool {
    // A key that should not be there belongs to the table around it.
    if table.keys().any(|key| key.span().contains(&offset)) {
        return true;
    }
    table.iter().any(|(key, value)| {
        keys.push(format!(".{}", key.get_ref()));
        let found = find_in_value(value, offset, keys);
        if !found {
            keys.pop();
        }
        found
    })
}

fn find_in_value(value: &Spanned<DeValue<'_>>, offset: usize, keys: &mut Vec<String>) -> bool {
    let inside = match value.get_ref() {
        DeValue::Table(table) => find_in_table(table, offset, keys),
        DeValue::Array(array) => array.iter().enumerate().any(|(index, item)| {
            keys.push(format!("[{index}]"));
            let found = find_in_value(item, offset, keys);
            if !found {
                keys.pop();
            }
            found
        }),
        _ => false,
    };
    inside || value.span().contains(&offset)
}

/// The line that follows some bytes, from 1.
fn line_after(bytes: &[u8]) -> u64 {
    1 + bytes.iter().filter(|&&byte| byte == b'\n').count() as u64
}

/// Shows steps as in `hysteresis.weights[2]`.
pub(crate) struct Steps<'a>(pub(crate) &'a [Step]);

impl fmt::Display for Steps<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (position, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if position == 0 => write!(f, "{key}")?,
                Step::Key(key) => write!(f, ".{key}")?,
                Step::Index(index) => write!(f, "[{index}]")?,
            }
        }
        Ok(())
    }
}
