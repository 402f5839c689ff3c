//! Signals in and out, as CSV or NumPy's arrays: a drive or a reference to read, named columns to write.

use std::io::{Seek, Write};
use std::path::Path;

use crate::error::{Error, Place, quoted};
use crate::numpy;
use crate::table::{ColumnRequest, Table};
use crate::time_grid::uniform_step;
use crate::units::{LengthUnit, Scale, TimeUnit, Unit, VoltageUnit, column_names, unit_of_column};

/// A uniformly sampled signal.
///
/// `time_s` and `values` have the same length, at least two, and hold finite numbers only.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Sample time in seconds: the mean step of the time column.
    pub sample_time_s: f64,
    /// Time of each sample in seconds, as written in the file.
    pub time_s: Vec<f64>,
    /// Value of each sample in volts for a drive, in micrometres for a length.
    pub values: Vec<f64>,
}

/// What a signal is; the name of its column is the quantity's name and a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Column `drive_v` or `drive_mv`, read in volts.
    Drive,
    /// Column `reference_um`, `reference_nm`, `reference_mm` or `reference_m`, read in micrometres.
    Reference,
    /// Column `displacement_um`, `_nm`, `_mm` or `_m`, read in micrometres.
    Displacement,
}

/// A column to write: its name, with the unit, and its numbers.
pub type Column<'a> = (&'a str, &'a [f64]);

/// Reads the columns of time (`time_s`, `time_ms` or `time_us`) and of one quantity; any other
/// column is passed over.
///
/// # Errors
/// One line with file, line and column where the file cannot be read, a column is missing or there
/// in two units, a number is missing or not finite, there are fewer than two samples, or time does
/// not advance uniformly.
pub fn read(path: impl AsRef<Path>, quantity: Quantity) -> Result<Signal, Error> {
    let path = path.as_ref();
    let table = Table::open(path)?;
    let [time, value] = if table.is_unnamed() {
        in_order(&table)?
    } else {
        let value = match quantity {
            Quantity::Drive => find::<VoltageUnit>(&table, "drive"),
            Quantity::Reference => find::<LengthUnit>(&table, "reference"),
            Quantity::Displacement => find::<LengthUnit>(&table, "displacement"),
        };
        [find::<TimeUnit>(&table, "time")?, value?]
    };
    let time_column = table.headers()[time.index].clone();
    let table = table.read([time, value])?;
    let [time_s, values] = table.columns;
    let place = Place::file(path);
    if time_s.len() < 2 {
        return Err(place.error(
            "fewer than two samples under the column names; the sample time cannot be told, add \
             rows",
        ));
    }
    let sample_time_s = uniform_step(&time_s, &table.lines, &place, &time_column)?;
    Ok(Signal {
        sample_time_s,
        time_s,
        values,
    })
}

/// The two columns of a plain array: time in seconds, and volts or micrometres.
fn in_order(table: &Table) -> Result<[ColumnRequest; 2], Error> {
    if table.headers().len() != 2 {
        return Err(table.header_place().error(format!(
            "the array has {} columns without names; save two, time in s and the signal in V or um, or \
             arrays with names in a .npz file",
            table.headers().len()
        )));
    }
    let scale = Scale::Times(1.0);
    Ok([0, 1].map(|index| ColumnRequest { index, scale }))
}

fn find<U: Unit>(table: &Table, stem: &str) -> Result<ColumnRequest, Error> {
    let unit = |header: &String| unit_of_column::<U>(header, stem);
    let mut matches = table
        .headers()
        .iter()
        .enumerate()
        .filter_map(|(index, header)| unit(header).map(|unit| (index, unit)));
    match (matches.next(), matches.next()) {
        (Some((index, unit)), None) => Ok(ColumnRequest {
            index,
            scale: unit.scale(),
        }),
        (Some((first, _)), Some((second, _))) => {
            let headers = table.headers();
            Err(table.header_place().error(format!(
                "columns {} and {} both hold the {stem}; keep one",
                headers[first], headers[second],
            )))
        }
        (None, _) => Err(table.header_place().error(format!(
            "no column {}, {}; rename or add the column",
            column_names::<U>(stem),
            table.found(),
        ))),
    }
}

/// Writes named columns of equal length as CSV, each number with the fewest digits that read back
/// as the same `f64`.
///
/// `place` names the destination in messages.
///
/// # Errors
/// Columns of different lengths and numbers that are not finite are refused before anything is
/// written; else the writer's refusal, with the destination's name.
pub fn write(mut to: impl Write, place: &Place, columns: &[Column<'_>]) -> Result<(), Error> {
    let rows = checked(place, columns)?;
    write_rows(&mut to, columns, rows).map_err(|source| refused(place, source))
}

/// As [`write()`], in the form that the end of the destination's name says: `.npy` one structured array
/// with a field a column, `.npz` an archive with an array a column, all of doubles, else CSV.
///
/// # Errors
/// As [`write()`].
pub fn write_as(
    path: impl AsRef<Path>,
    mut to: impl Write + Seek,
    place: &Place,
    columns: &[Column<'_>],
) -> Result<(), Error> {
    let Some(form) = numpy::Form::of(path.as_ref()) else {
        return write(to, place, columns);
    };
    checked(place, columns)?;
    numpy::write(&mut to, form, columns).map_err(|source| refused(place, source))
}

fn refused(place: &Place, source: std::io::Error) -> Error {
    place
        .clone()
        .io_error("cannot write", "free some space or write elsewhere", source)
}

/// The number of rows of columns that can be written.
fn checked(place: &Place, columns: &[Column<'_>]) -> Result<usize, Error> {
    let rows = columns.first().map_or(0, |(_, values)| values.len());
    for (name, values) in columns {
        let place = || place.clone().column(*name);
        if values.len() != rows {
            let problem = format!(
                "{} numbers where {} has {rows}; nothing is written",
                values.len(),
                quoted(columns[0].0)
            );
            return Err(place().error(problem));
        }
        if let Some(row) = values.iter().position(|value| !value.is_finite()) {
            let problem = format!(
                "sample {row} came out as {}; nothing is written",
                values[row]
            );
            return Err(place().error(problem));
        }
    }
    Ok(rows)
}

fn write_rows(to: &mut impl Write, columns: &[Column<'_>], rows: usize) -> std::io::Result<()> {
    let mut header = csv::Writer::from_writer(&mut *to);
    header.write_record(columns.iter().map(|(name, _)| name))?;
    header.flush()?;
    drop(header);
    let mut number = zmij::Buffer::new();
    for row in 0..rows {
        for (position, (_, values)) in columns.iter().enumerate() {
            if position > 0 {
                to.write_all(b",")?;
            }
            to.write_all(number.format_finite(values[row]).as_bytes())?;
        }
        to.write_all(b"\n")?;
    }
    to.flush()
}
