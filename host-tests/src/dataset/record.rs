//! One file read as three signals.

use std::path::Path;

use crate::error::{Error, Place};
use crate::table::{ColumnRequest, Table};
use crate::time_grid::uniform_step;
use crate::units::Scale;

/// Where the three signals stand in a file: column position and factor to the internal unit.
#[derive(Clone, Copy)]
pub(super) struct Layout {
    pub(super) time: (usize, Scale),
    pub(super) drive: (usize, Scale),
    pub(super) displacement: (usize, Scale),
}

impl Layout {
    /// Time, drive and displacement.
    pub(super) fn requests(&self) -> [ColumnRequest; 3] {
        [self.time, self.drive, self.displacement]
            .map(|(index, scale)| ColumnRequest { index, scale })
    }
}

/// The samples of one file in seconds, volts and micrometres.
pub(super) struct Samples {
    pub(super) sample_time_s: f64,
    pub(super) time_s: Vec<f64>,
    pub(super) drive_v: Vec<f64>,
    pub(super) displacement_um: Vec<f64>,
}

/// Reads and checks all samples; `needed` is the least number of them.
pub(super) fn read(
    path: &Path,
    table: Table,
    layout: &Layout,
    needed: usize,
) -> Result<Samples, Error> {
    let place = Place::file(path);
    let time_column = table.headers()[layout.time.0].clone();
    let table = table.read(layout.requests())?;
    let [time_s, drive_v, displacement_um] = table.columns;
    if time_s.is_empty() {
        return Err(place.error(
            "there are no samples under the column names; record the file again or take it out \
             of the data set",
        ));
    }
    if time_s.len() < needed {
        return Err(place.error(format!(
            "there {} under the column names and at least {needed} are needed; record more",
            if time_s.len() == 1 {
                "is 1 sample".to_owned()
            } else {
                format!("are {} samples", time_s.len())
            },
        )));
    }
    let sample_time_s = uniform_step(&time_s, &table.lines, &place, &time_column)?;
    Ok(Samples {
        sample_time_s,
        time_s,
        drive_v,
        displacement_um,
    })
}
