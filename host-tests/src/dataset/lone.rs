//! One file alone: columns recognised by name, samples split by position.

use std::ops::Range;
use std::path::Path;

use super::long::{Plan, Source};
use super::record::{self, Layout, Samples};
use super::{Dataset, LengthUnit, MIN_SAMPLES, Record, Role, Zero};
use crate::error::Error;
use crate::table::Table;
use crate::units::{TimeUnit, Unit, VoltageUnit, unit_of_column};

const TIME_STEMS: &[&str] = &["time", "t"];
const DRIVE_STEMS: &[&str] = &["drive", "input", "voltage", "u"];
const DISPLACEMENT_STEMS: &[&str] = &["displacement", "output", "position", "y"];

/// Shares of the samples: the first part fits, the next selects, the rest reports.
const FIT_PERCENT: usize = 60;
const SELECT_PERCENT: usize = 20;
/// So that the shortest part, a fifth, has enough samples.
const NEEDED: usize = 100 / SELECT_PERCENT * MIN_SAMPLES;

fn layout(table: &Table) -> Result<(Layout, LengthUnit), Error> {
    if table.is_unnamed() {
        return in_order(table);
    }
    let (time, time_unit) = find::<TimeUnit>(table, "time", TIME_STEMS)?;
    let (drive, drive_unit) = find::<VoltageUnit>(table, "drive", DRIVE_STEMS)?;
    let (displacement, output_unit) =
        find::<LengthUnit>(table, "displacement", DISPLACEMENT_STEMS)?;
    let layout = Layout {
        time: (time, time_unit.scale()),
        drive: (drive, drive_unit.scale()),
        displacement: (displacement, output_unit.scale()),
    };
    Ok((layout, output_unit))
}

/// The three columns of a plain array: time in seconds, drive in volts, displacement in micrometres.
fn in_order(table: &Table) -> Result<(Layout, LengthUnit), Error> {
    if table.headers().len() != 3 {
        return Err(table.header_place().error(format!(
            "the array has {} columns without names; save three, time in s, drive in V, displacement in \
             um, or arrays with names in a .npz file",
            table.headers().len()
        )));
    }
    let layout = Layout {
        time: (0, TimeUnit::Second.scale()),
        drive: (1, VoltageUnit::Volt.scale()),
        displacement: (2, LengthUnit::Micrometre.scale()),
    };
    Ok((layout, LengthUnit::Micrometre))
}

fn stem(path: &Path) -> String {
    path.file_stem()
        .map_or_else(String::new, |stem| stem.to_string_lossy().into())
}

/// The file, its samples not yet read.
pub(super) fn plan(path: &Path) -> Result<Plan, Error> {
    let (layout, output_unit) = layout(&Table::open(path)?)?;
    Ok(Plan {
        name: stem(path),
        output_unit,
        zero: Zero::Shared,
        input_zero: Zero::Shared,
        sources: vec![Source {
            name: stem(path),
            role: None,
            layout,
            file: path.to_owned(),
        }],
    })
}

/// Loads one file as three records that continue each other.
pub(super) fn load(path: &Path) -> Result<Dataset, Error> {
    let table = Table::open(path)?;
    let (layout, output_unit) = layout(&table)?;
    let samples = record::read(path, table, &layout, NEEDED)?;
    let stem = stem(path);
    let records = split(&stem, &samples);
    Ok(Dataset {
        name: stem,
        output_unit,
        zero: Zero::Shared,
        input_zero: Zero::Shared,
        records,
    })
}

/// The three parts of so many samples.
pub(super) fn parts(count: usize) -> [(Role, &'static str, Range<usize>); 3] {
    let fit_end = count * FIT_PERCENT / 100;
    let select_end = count * (FIT_PERCENT + SELECT_PERCENT) / 100;
    [
        (Role::Fit, "fit", 0..fit_end),
        (Role::Select, "select", fit_end..select_end),
        (Role::Report, "report", select_end..count),
    ]
}

/// Cuts the samples into the three parts.
fn split(stem: &str, samples: &Samples) -> Vec<Record> {
    let parts = parts(samples.time_s.len());
    let part = |(index, (role, label, range)): (usize, (Role, &str, Range<usize>))| Record {
        name: format!("{stem} ({label})"),
        role,
        start_s: samples.time_s[range.start],
        sample_time_s: samples.sample_time_s,
        time_s: samples.time_s[range.clone()].to_vec(),
        drive_v: samples.drive_v[range.clone()].to_vec(),
        displacement_um: samples.displacement_um[range].to_vec(),
        continues: index.checked_sub(1),
    };
    parts.into_iter().enumerate().map(part).collect()
}

/// The one column whose name is one of the stems with a unit of the quantity.
fn find<U: Unit>(table: &Table, quantity: &str, stems: &[&str]) -> Result<(usize, U), Error> {
    let unit = |header: &String| stems.iter().find_map(|stem| unit_of_column(header, stem));
    let headers = table.headers();
    let matches: Vec<_> = headers
        .iter()
        .enumerate()
        .filter_map(|(index, header)| unit(header).map(|unit| (index, unit)))
        .collect();
    match matches.as_slice() {
        &[only] => Ok(only),
        [] => Err(table.header_place().error(format!(
            "no {quantity} column, {}; name it {}, or write a dataset.toml (see docs/dataset.md)",
            table.found(),
            crate::units::column_names::<U>(stems[0]),
        ))),
        [(first, _), (second, _), ..] => Err(table.header_place().error(format!(
            "{} and {} could both be the {quantity}; rename one, or write a dataset.toml (see \
             docs/dataset.md)",
            headers[*first], headers[*second],
        ))),
    }
}
