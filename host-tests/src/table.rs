//! Columns of finite numbers from a file of any kind that samples come in: CSV or NumPy's.

use std::path::Path;

use crate::csv_table::CsvTable;
use crate::error::{Error, Place, quoted};
use crate::numpy::NumpyTable;
use crate::units::Scale;

/// An opened file whose names of columns are known and whose numbers are still to be read.
pub(crate) enum Table {
    /// Comma-separated text.
    Csv(Box<CsvTable>),
    /// A `.npy` or `.npz` file.
    Numpy(Box<NumpyTable>),
}

/// One column to read: where it is, and the factor to the internal unit.
#[derive(Clone, Copy)]
pub(crate) struct ColumnRequest {
    /// Position among the columns, from 0.
    pub(crate) index: usize,
    /// Factor to the internal unit.
    pub(crate) scale: Scale,
}

/// The requested columns, in the order of the request.
pub(crate) struct NumberTable<const N: usize> {
    /// One vector a column, all of the same length.
    pub(crate) columns: [Vec<f64>; N],
    /// The line in the file of each row.
    pub(crate) lines: LineMap,
}

/// Row to line. Only rows before which comments or blank lines were skipped take any space.
#[derive(Default)]
pub(crate) struct LineMap {
    /// (first row it holds for, line - row)
    shifts: Vec<(usize, u64)>,
}

impl LineMap {
    fn push(&mut self, row: usize, line: u64) {
        let shift = line - row as u64;
        if self.shifts.last().is_none_or(|&(_, last)| last != shift) {
            self.shifts.push((row, shift));
        }
    }

    /// What the file counts for a row, from 0: the line, from 1, of text, the index, from 0, of arrays.
    pub(crate) fn line(&self, row: usize) -> u64 {
        let entry = self.shifts.partition_point(|&(first, _)| first <= row);
        row as u64 + entry.checked_sub(1).map_or(1, |index| self.shifts[index].1)
    }
}

impl Table {
    /// Opens a file and reads the names of its columns; arrays by the end of its name, else text.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        Ok(if crate::numpy::is_numpy(path) {
            Self::Numpy(Box::new(NumpyTable::open(path)?))
        } else {
            Self::Csv(Box::new(CsvTable::open(path)?))
        })
    }

    /// The names of the columns.
    pub(crate) fn headers(&self) -> &[String] {
        match self {
            Self::Csv(table) => table.headers(),
            Self::Numpy(table) => table.headers(),
        }
    }

    /// Whether the columns have numbers for names: those of a plain array.
    pub(crate) fn is_unnamed(&self) -> bool {
        match self {
            Self::Csv(_) => false,
            Self::Numpy(table) => table.is_unnamed(),
        }
    }

    /// Where the names stand.
    pub(crate) fn header_place(&self) -> Place {
        match self {
            Self::Csv(table) => table.header_place(),
            Self::Numpy(table) => table.place(),
        }
    }

    /// The found column names for a message, with a hint where the separator is not a comma.
    pub(crate) fn found(&self) -> String {
        let hint = match self.headers() {
            [only] if only.contains([';', '\t']) => " (cells must be separated by commas)",
            _ => "",
        };
        let names: Vec<_> = self.headers().iter().map(|header| quoted(header)).collect();
        format!("found {}{hint}", names.join(", "))
    }

    /// The position of a column by its exact name; `remedy` ends the message when it is missing.
    pub(crate) fn position(&self, name: &str, remedy: &str) -> Result<usize, Error> {
        let headers = self.headers();
        let mut matches = (0..headers.len()).filter(|&index| headers[index] == name);
        match (matches.next(), matches.next()) {
            (Some(index), None) => Ok(index),
            (Some(_), Some(_)) => Err(self.header_place().error(format!(
                "column {name} is there twice; give every column its own name"
            ))),
            (None, _) => Err(self.header_place().error(format!(
                "no column {}, {}; {remedy}",
                quoted(name),
                self.found()
            ))),
        }
    }

    /// Reads the rest of the file in one pass.
    pub(crate) fn read<const N: usize>(
        mut self,
        requests: [ColumnRequest; N],
    ) -> Result<NumberTable<N>, Error> {
        let mut columns = [const { Vec::new() }; N];
        let mut lines = LineMap::default();
        let mut row = 0;
        while let Some((line, values)) = self.next_numbers(&requests)? {
            for (column, value) in columns.iter_mut().zip(values) {
                column.push(value);
            }
            lines.push(row, line);
            row += 1;
        }
        Ok(NumberTable { columns, lines })
    }

    /// Reads the next row: its line or index, and the requested numbers in the order of the request,
    /// which must be the same in every call.
    pub(crate) fn next_numbers<const N: usize>(
        &mut self,
        requests: &[ColumnRequest; N],
    ) -> Result<Option<(u64, [f64; N])>, Error> {
        match self {
            Self::Csv(table) => table.next_numbers(requests),
            Self::Numpy(table) => table.next_numbers(requests),
        }
    }

    /// Rows of the requested columns, where the file says so ahead of them.
    pub(crate) fn rows(&self, requests: &[ColumnRequest]) -> Result<Option<u64>, Error> {
        match self {
            Self::Csv(_) => Ok(None),
            Self::Numpy(table) => table.rows(requests).map(Some),
        }
    }

    /// How much of a file of so many bytes has been read, in percent.
    pub(crate) fn percent(&self, bytes: u64) -> u64 {
        match self {
            Self::Csv(table) => 100 * table.bytes_read() / bytes.max(1),
            Self::Numpy(table) => table.percent(),
        }
    }
}
