//! Signals in and out as CSV: a drive or a reference to read, named columns to write.

use std::io::Write;
use std::path::Path;

use crate::csv_table::{ColumnRequest, CsvTable};
use crate::error::{Error, Place, quoted};
use crate::time_grid::uniform_step;
use crate::units::{LengthUnit, TimeUnit, Unit, VoltageUnit, column_names, unit_of_column};

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
    let table = CsvTable::open(path)?;
    let time = find::<TimeUnit>(&table, "time")?;
    let value = match quantity {
        Quantity::Drive => find::<VoltageUnit>(&table, "drive")?,
        Quantity::Reference => find::<LengthUnit>(&table, "reference")?,
        Quantity::Displacement => find::<LengthUnit>(&table, "displacement")?,
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

fn find<U: Unit>(table: &CsvTable, stem: &str) -> Result<ColumnRequest, Error> {
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
    write_rows(&mut to, columns, rows).map_err(|source| {
        place
            .clone()
            .io_error("cannot write", "free some space or write elsewhere", source)
    })
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
