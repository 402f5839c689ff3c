//! Writes a whole data set in units and column names of one's choice.

use std::path::Path;

use super::{Dataset, Role, Zero};
use crate::error::Error;
use crate::output::OutputFolder;
use crate::units::{TimeUnit, Unit, VoltageUnit};

/// How the columns of a data set are called, without their units, and in which units they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Columns<'a> {
    pub(crate) time_unit: TimeUnit,
    pub(crate) input: &'a str,
    pub(crate) input_unit: VoltageUnit,
    pub(crate) output: &'a str,
}

impl Dataset {
    /// Writes the data set into a folder, all its files or none: time in seconds (`time_s`), drive in
    /// volts (`drive_v`), displacement in the data set's own unit.
    ///
    /// # Errors
    /// A folder or file that cannot be written, a number that is not finite.
    pub fn save(&self, folder: impl AsRef<Path>) -> Result<(), Error> {
        let mut out = OutputFolder::create(folder)?;
        let columns = Columns {
            time_unit: TimeUnit::Second,
            input: "drive",
            input_unit: VoltageUnit::Volt,
            output: "displacement",
        };
        add_files(self, &columns, &mut out, Path::new(""))?;
        out.commit()
    }
}

/// Stages a CSV file for each record and a `dataset.toml` in the folder `below` of `out`.
pub(crate) fn add_files(
    dataset: &Dataset,
    columns: &Columns<'_>,
    out: &mut OutputFolder,
    below: &Path,
) -> Result<(), Error> {
    let time = format!("time_{}", columns.time_unit.suffix());
    let input = format!("{}_{}", columns.input, columns.input_unit.suffix());
    let output = format!("{}_{}", columns.output, dataset.output_unit.suffix());
    let zero = |zero: Zero| match zero {
        Zero::Shared => "",
        Zero::PerRecord => ", zero = \"per-record\"",
    };
    let mut text = format!(
        "name = {}\n\n[signals]\n\
         time   = {{ column = \"{time}\", unit = \"{}\" }}\n\
         input  = {{ column = \"{input}\", unit = \"{}\"{} }}\n\
         output = {{ column = \"{output}\", unit = \"{}\"{} }}\n",
        toml::Value::from(dataset.name.as_str()),
        columns.time_unit.symbol(),
        columns.input_unit.symbol(),
        zero(dataset.input_zero),
        dataset.output_unit.symbol(),
        zero(dataset.zero),
    );
    let name = |file: &str| below.join(file).to_string_lossy().into_owned();
    for record in &dataset.records {
        let file = format!("{}.csv", record.name);
        let role = match record.role {
            Role::Fit => "fit",
            Role::Select => "select",
            Role::Report => "report",
        };
        text.push_str(&format!(
            "\n[[record]]\nfile = {}\nrole = \"{role}\"\n",
            toml::Value::from(file.as_str())
        ));
        out.add_columns(
            &name(&file),
            &[
                (&time, &in_unit(&record.time_s, columns.time_unit)),
                (&input, &in_unit(&record.drive_v, columns.input_unit)),
                (
                    &output,
                    &in_unit(&record.displacement_um, dataset.output_unit),
                ),
            ],
        )?;
    }
    out.add(&name("dataset.toml"), text)
}

fn in_unit<U: Unit>(values: &[f64], unit: U) -> Vec<f64> {
    let scale = unit.scale();
    values.iter().map(|&value| scale.undo(value)).collect()
}
