//! Columns of finite numbers from NumPy's files, row by row: memory does not grow with the file.
//!
//! A `.npz` file is a zip archive of arrays, each a column under its name. A `.npy` file is one array:
//! a structured one with a column a field, or one of two dimensions with a row a sample, whose columns
//! have the names 0, 1, ... `docs/interchange.md` has the rules.

mod header;
mod literal;
mod source;
mod write;

use std::path::Path;

use header::{Entry, Header, Kind, other_type};
use source::{Member, Stream};
pub(crate) use write::{Form, write};

use crate::error::{Error, Place};
use crate::table::ColumnRequest;

/// Columns of a plain array at most: more is an array that lies the other way.
const MOST_COLUMNS: u64 = 4096;

/// Whether the name of a file ends as one of NumPy's.
pub(crate) fn is_numpy(path: &Path) -> bool {
    Form::of(path).is_some()
}

/// An opened file whose headers have been read.
pub(crate) struct NumpyTable {
    place: Place,
    names: Vec<String>,
    columns: Vec<Column>,
    members: Vec<Member>,
    unnamed: bool,
    /// Rows read, and rows that there are.
    row: u64,
    rows: u64,
    /// The arrays that are read; none before the first row.
    streams: Vec<(usize, Stream)>,
}

/// A column of numbers, or what is wrong with it.
struct Column {
    member: usize,
    found: Result<Numbers, String>,
}

#[derive(Clone, Copy)]
struct Numbers {
    rows: u64,
    /// Bytes of a row, and those of them before the number.
    row_bytes: usize,
    offset: usize,
    kind: Kind,
}

impl NumpyTable {
    /// Opens a file and reads its headers.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let place = Place::file(path);
        if path.is_dir() {
            return Err(place.error("is a folder; name a file"));
        }
        let mut table = Self {
            place,
            names: Vec::new(),
            columns: Vec::new(),
            members: Vec::new(),
            unnamed: false,
            row: 0,
            rows: 0,
            streams: Vec::new(),
        };
        match Form::of(path) {
            Some(Form::Npz) => table.open_archive(path)?,
            _ => table.open_array(path)?,
        }
        Ok(table)
    }

    fn open_archive(&mut self, path: &Path) -> Result<(), Error> {
        for (name, member) in source::members(path, &self.place)? {
            let found = member
                .open(&self.place)
                .and_then(|mut stream| header(&mut stream))
                .and_then(|header| checked(&header, member.size()).map(|()| header))
                .and_then(|header| line_of(&header));
            self.names.push(name);
            self.columns.push(Column {
                member: self.members.len(),
                found,
            });
            self.members.push(member);
        }
        if self.names.is_empty() {
            return Err(self.place.clone().error(
                "the archive holds no arrays; save them with numpy.savez(file, time_s=..., ...)",
            ));
        }
        Ok(())
    }

    fn open_array(&mut self, path: &Path) -> Result<(), Error> {
        let refuse = |problem: String| self.place.clone().error(format!("the array {problem}"));
        let member = Member::whole(path, &self.place)?;
        let header = member
            .open(&self.place)
            .and_then(|mut stream| header(&mut stream))
            .and_then(|header| checked(&header, member.size()).map(|()| header))
            .map_err(refuse)?;
        let shape = shown(&header.shape);
        let mut add = |name: String, found| {
            self.names.push(name);
            self.columns.push(Column { member: 0, found });
        };
        match (&header.entry, header.shape.as_slice()) {
            (Entry::Fields(fields, bytes), &[rows]) => {
                for field in fields {
                    let numbers = |kind| Numbers {
                        rows,
                        row_bytes: *bytes as usize,
                        offset: field.offset as usize,
                        kind,
                    };
                    let found = field.kind.clone().map(numbers);
                    add(field.name.clone(), found.map_err(|text| other_type(&text)));
                }
            }
            (Entry::Number(kind), &[rows, columns]) if (2..=MOST_COLUMNS).contains(&columns) => {
                if header.fortran {
                    return Err(refuse(
                        "is in Fortran order, column after column; save numpy.ascontiguousarray of it"
                            .into(),
                    ));
                }
                for column in 0..columns {
                    let numbers = Numbers {
                        rows,
                        row_bytes: (columns * kind.bytes()) as usize,
                        offset: (column * kind.bytes()) as usize,
                        kind: *kind,
                    };
                    add(column.to_string(), Ok(numbers));
                }
                self.unnamed = true;
            }
            (Entry::Number(_), _) => {
                return Err(refuse(format!(
                    "has the shape {shape}; save two dimensions, a row a sample and a column a signal"
                )));
            }
            (Entry::Fields(..), _) => {
                return Err(refuse(format!(
                    "has fields and the shape {shape}; save one dimension, an entry a sample"
                )));
            }
        }
        self.members.push(member);
        Ok(())
    }

    /// Names of the columns.
    pub(crate) fn headers(&self) -> &[String] {
        &self.names
    }

    /// Whether the columns have numbers for names.
    pub(crate) fn is_unnamed(&self) -> bool {
        self.unnamed
    }

    /// The file.
    pub(crate) fn place(&self) -> Place {
        self.place.clone()
    }

    /// Rows of the requested columns, which all have as many.
    pub(crate) fn rows(&self, requests: &[ColumnRequest]) -> Result<u64, Error> {
        let mut first: Option<(u64, &str)> = None;
        for request in requests {
            let name = &self.names[request.index];
            let rows = self.numbers(request.index)?.rows;
            match first {
                Some((others, other)) if others != rows => {
                    let place = self.place.clone().column(name);
                    return Err(place.error(format!(
                        "holds {rows} samples where {other} holds {others}; save arrays of one length"
                    )));
                }
                _ => first = first.or(Some((rows, name))),
            }
        }
        Ok(first.map_or(0, |(rows, _)| rows))
    }

    fn numbers(&self, index: usize) -> Result<Numbers, Error> {
        self.columns[index]
            .found
            .as_ref()
            .copied()
            .map_err(|problem| {
                let place = self.place.clone().column(&self.names[index]);
                place.error(format!("the array {problem}"))
            })
    }

    /// Opens the arrays of the requested columns at their first number.
    fn begin(&mut self, requests: &[ColumnRequest]) -> Result<(), Error> {
        self.rows = self.rows(requests)?;
        for request in requests {
            let (numbers, at) = (self.numbers(request.index)?, &self.columns[request.index]);
            if self.streams.iter().any(|&(member, _)| member == at.member) {
                continue;
            }
            let opened = self.members[at.member]
                .open(&self.place)
                .and_then(|mut stream| header(&mut stream).map(|_| stream));
            let mut stream = opened.map_err(|problem| {
                let place = self.place.clone().column(&self.names[request.index]);
                place.error(format!("the array {problem}"))
            })?;
            stream.row = vec![0; numbers.row_bytes];
            self.streams.push((at.member, stream));
        }
        Ok(())
    }

    /// The index of the next row and the requested numbers.
    pub(crate) fn next_numbers<const N: usize>(
        &mut self,
        requests: &[ColumnRequest; N],
    ) -> Result<Option<(u64, [f64; N])>, Error> {
        if self.streams.is_empty() {
            self.begin(requests)?;
        }
        let (row, rows) = (self.row, self.rows);
        let damaged = |place: &Place, problem: String| {
            let problem = format!("the array {problem} (row {row} of {rows})");
            Err(place.clone().error(problem))
        };
        if row == rows {
            for (_, stream) in &mut self.streams {
                if let Err(problem) = stream.finish() {
                    return damaged(&self.place, problem);
                }
            }
            return Ok(None);
        }
        for (_, stream) in &mut self.streams {
            if let Err(problem) = stream.next_row() {
                return damaged(&self.place, problem);
            }
        }
        let mut values = [0.0; N];
        for (value, request) in values.iter_mut().zip(requests) {
            let (numbers, member) = (
                self.numbers(request.index)?,
                self.columns[request.index].member,
            );
            let stream = self.streams.iter().find(|&&(at, _)| at == member);
            let bytes = stream.and_then(|(_, stream)| stream.row.get(numbers.offset..));
            let number = numbers.kind.number(bytes.unwrap_or_default());
            *value = request.scale.apply(number);
            if !value.is_finite() {
                let place = self.place.clone().line(row);
                return Err(place.column(&self.names[request.index]).error(format!(
                    "{number} is not a finite number; remove or repair the sample"
                )));
            }
        }
        self.row += 1;
        Ok(Some((row, values)))
    }

    /// How much has been read, in percent.
    pub(crate) fn percent(&self) -> u64 {
        (100.0 * self.row as f64 / self.rows.max(1) as f64) as u64
    }
}

fn header(stream: &mut Stream) -> Result<Header, String> {
    Header::read(stream)
}

/// Holds the length of the numbers against that of the file.
fn checked(header: &Header, size: u64) -> Result<(), String> {
    let there = size.saturating_sub(header.length);
    match header.bytes() {
        Some(wanted) if wanted == there => Ok(()),
        Some(wanted) if wanted < there => Err(format!(
            "is followed by {} bytes more; save every array in a file of its own, or with numpy.savez",
            there - wanted
        )),
        _ => Err(format!(
            "is cut off: the shape {} needs more than the {there} bytes there; copy or save the file again",
            shown(&header.shape)
        )),
    }
}

/// The one column of an array in an archive: all its entries, along whichever axis they lie.
fn line_of(header: &Header) -> Result<Numbers, String> {
    let long = header.shape.iter().filter(|&&count| count != 1).count();
    match &header.entry {
        Entry::Number(kind) if long <= 1 && !header.shape.is_empty() => Ok(Numbers {
            rows: header.shape.iter().product(),
            row_bytes: kind.bytes() as usize,
            offset: 0,
            kind: *kind,
        }),
        Entry::Number(_) => Err(format!(
            "has the shape {}; save one dimension, an array a signal",
            shown(&header.shape)
        )),
        Entry::Fields(..) => Err(
            "has fields; save it alone with numpy.save, or its fields as arrays of their own"
                .into(),
        ),
    }
}

/// A shape as NumPy shows it.
fn shown(shape: &[u64]) -> String {
    match shape {
        [only] => format!("({only},)"),
        _ => {
            let axes: Vec<_> = shape.iter().map(u64::to_string).collect();
            format!("({})", axes.join(", "))
        }
    }
}
