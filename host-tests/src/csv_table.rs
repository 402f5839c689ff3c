//! Rows of finite numbers from a CSV file, with the line of each for messages.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Terminator};

use crate::error::{Error, Place, quoted};
use crate::table::ColumnRequest;

const READ_BUFFER: usize = 1 << 18;

/// An opened CSV file whose line of column names has been read.
pub(crate) struct CsvTable {
    reader: csv::Reader<Box<dyn Read>>,
    record: ByteRecord,
    place: Place,
    headers: Vec<String>,
    header_line: u64,
}

impl CsvTable {
    /// Opens a file and reads its line of column names.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let place = Place::file(path);
        let unreadable = |source| {
            place
                .clone()
                .io_error("cannot read", "check the path and its permissions", source)
        };
        if path.is_dir() {
            return Err(place.error("is a folder; name a CSV, .npz or .npy file"));
        }
        let file = File::open(path).map_err(unreadable)?;
        Self::from_reader(Box::new(file), place)
    }

    /// The same from any source of bytes.
    pub(crate) fn from_reader(source: Box<dyn Read>, place: Place) -> Result<Self, Error> {
        // A line feed as the only terminator makes the line count exact for CRLF files too (the
        // carriage return is trimmed with the other blanks); one more at the end does it for a last
        // line without one. Both let a record's line be read off after it.
        let source: Box<dyn Read> = Box::new(source.chain(&b"\n"[..]));
        let mut table = Self {
            reader: ReaderBuilder::new()
                .has_headers(false)
                .flexible(true)
                .comment(Some(b'#'))
                .terminator(Terminator::Any(b'\n'))
                .buffer_capacity(READ_BUFFER)
                .from_reader(source),
            record: ByteRecord::new(),
            place,
            headers: Vec::new(),
            header_line: 1,
        };
        let Some(line) = table.next_row()? else {
            return Err(table.place.error(
                "the file holds no rows; it needs a line of column names and rows of numbers",
            ));
        };
        table.header_line = line;
        table.headers = table
            .record
            .iter()
            .map(|cell| String::from_utf8_lossy(trim(cell)).into())
            .collect();
        if table
            .headers
            .iter()
            .all(|header| header.parse::<f64>().is_ok())
        {
            return Err(table
                .header_place()
                .error("the first line holds numbers; put a line of column names before it"));
        }
        Ok(table)
    }

    /// The column names, blanks around them removed.
    pub(crate) fn headers(&self) -> &[String] {
        &self.headers
    }

    /// The line of column names.
    pub(crate) fn header_place(&self) -> Place {
        self.place.clone().line(self.header_line)
    }

    /// Reads the next row: its line, and the requested numbers in the order of the request.
    pub(crate) fn next_numbers<const N: usize>(
        &mut self,
        requests: &[ColumnRequest; N],
    ) -> Result<Option<(u64, [f64; N])>, Error> {
        let Some(line) = self.next_row()? else {
            return Ok(None);
        };
        if self.record.len() != self.headers.len() {
            return Err(self.place.clone().line(line).error(format!(
                "the row has {} and the header {}; give every row one number a column, with a \
                 decimal point",
                cells(self.record.len()),
                self.headers.len(),
            )));
        }
        let mut values = [0.0; N];
        for (value, request) in values.iter_mut().zip(requests) {
            let cell = trim(&self.record[request.index]);
            *value = parse(cell)
                .and_then(|value| finite(request.scale.apply(value), cell))
                .map_err(|problem| {
                    let name = &self.headers[request.index];
                    let place = self.place.clone().line(line).column(name);
                    place.error(format!("{problem}; remove or repair the row"))
                })?;
        }
        Ok(Some((line, values)))
    }

    /// Bytes of the file that have been read.
    pub(crate) fn bytes_read(&self) -> u64 {
        self.reader.position().byte()
    }

    /// Reads the next row that is neither blank nor a comment into `record`; gives its line.
    fn next_row(&mut self) -> Result<Option<u64>, Error> {
        loop {
            let more = self
                .reader
                .read_byte_record(&mut self.record)
                .map_err(|error| {
                    let remedy = "check the file and the disk it is on";
                    self.place
                        .clone()
                        .io_error("cannot read", remedy, io::Error::other(error))
                })?;
            if !more {
                return Ok(None);
            }
            let text = self.record.as_slice();
            if text.contains(&b'\n') {
                let breaks = text.iter().filter(|&&byte| byte == b'\n').count() as u64;
                // A quote that is never closed swallows the line feed at the end of the file too.
                let ended = u64::from(!text.ends_with(b"\n"));
                let line = self.reader.position().line() - ended - breaks;
                let problem = "a quoted cell runs on past the end of the line; close the quote";
                return Err(self.place.clone().line(line).error(problem));
            }
            let line = self.reader.position().line() - 1;
            let first = trim(self.record.get(0).unwrap_or_default());
            if (first.is_empty() && self.record.len() == 1) || first.starts_with(b"#") {
                continue;
            }
            if !text.is_ascii() && str::from_utf8(text).is_err() {
                let problem = "the row is not UTF-8 text; save the file as UTF-8";
                return Err(self.place.clone().line(line).error(problem));
            }
            return Ok(Some(line));
        }
    }
}

fn trim(cell: &[u8]) -> &[u8] {
    cell.trim_ascii()
}

fn cells(count: usize) -> String {
    if count == 1 {
        "1 cell".to_owned()
    } else {
        format!("{count} cells")
    }
}

fn parse(cell: &[u8]) -> Result<f64, String> {
    if cell.is_empty() {
        return Err("the cell is empty".to_owned());
    }
    fast_float2::parse(cell)
        .map_err(|_| format!("{} is not a number", quoted(&String::from_utf8_lossy(cell))))
}

fn finite(value: f64, cell: &[u8]) -> Result<f64, String> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(format!(
            "{} is not a finite number",
            quoted(&String::from_utf8_lossy(cell))
        ))
    }
}
