//! Adds a record to a data set, which begins with its first one.

use std::path::Path;

use toml::Spanned;
use toml::de::DeValue;

use super::description::Description;
use super::record::{self, Layout};
use super::{MIN_SAMPLES, Role};
use crate::error::{Error, Place, quoted};
use crate::output::OutputFolder;
use crate::table::Table;
use crate::toml_text::{Step, TomlText, read_text};
use crate::units::{LengthUnit, TimeUnit, Unit, VoltageUnit};

const TIME: &str = "time_s";
const INPUT: &str = "input_v";
const OUTPUT: &str = "displacement_um";

/// A record to be added.
#[derive(Clone, Copy, Debug)]
pub struct NewRecord<'a> {
    /// Stem of its file; a number is added where there is such a file already.
    pub stem: &'a str,
    /// What it serves for.
    pub role: Role,
    /// Time of its first sample in s, on the data set's clock.
    pub start_s: f64,
    /// Time between samples in s.
    pub sample_time_s: f64,
    /// Drive at the actuator in V.
    pub drive_v: &'a [f64],
    /// Displacement in um, one for each drive.
    pub displacement_um: &'a [f64],
}

/// Adds a record to the data set in `folder`, or begins one there, and gives the name of its file.
/// Both the file and the new `dataset.toml` appear together or not at all.
///
/// # Errors
/// Fewer than [`MIN_SAMPLES`] samples, a data set with other columns, a record that begins before
/// the last one listed ends, and what the system refuses.
pub fn add_record(folder: impl AsRef<Path>, new: &NewRecord<'_>) -> Result<String, Error> {
    let folder = folder.as_ref();
    let samples = new.drive_v.len();
    if samples < MIN_SAMPLES {
        return Err(Error::request(format!(
            "{samples} samples are too few for a record, it needs {MIN_SAMPLES}; record longer"
        )));
    }
    let description = folder.join("dataset.toml");
    let mut text = if description.exists() {
        let text = read_text(&description)?;
        check(folder, &text, Place::file(&description), new)?;
        text
    } else {
        beginning(folder)
    };
    let file = free_name(folder, new.stem);
    let role = match new.role {
        Role::Fit => "fit",
        Role::Select => "select",
        Role::Report => "report",
    };
    if !text.ends_with('\n') {
        text.push('\n');
    }
    text.push_str(&format!(
        "\n[[record]]\nfile = {}\nrole = \"{role}\"\n",
        toml::Value::from(file.as_str())
    ));

    let time_s: Vec<f64> = (0..samples)
        .map(|k| new.start_s + k as f64 * new.sample_time_s)
        .collect();
    let mut out = OutputFolder::create(folder)?;
    out.add_columns(
        &file,
        &[
            (TIME, &time_s),
            (INPUT, new.drive_v),
            (OUTPUT, new.displacement_um),
        ],
    )?;
    out.add("dataset.toml", text)?;
    out.commit()?;
    Ok(file)
}

fn beginning(folder: &Path) -> String {
    let name = folder
        .file_name()
        .map_or("recorded".into(), |name| name.to_string_lossy());
    format!(
        "name = {}\n\n[signals]\n\
         time   = {{ column = \"{TIME}\", unit = \"s\" }}\n\
         input  = {{ column = \"{INPUT}\", unit = \"V\" }}\n\
         output = {{ column = \"{OUTPUT}\", unit = \"um\" }}\n",
        toml::Value::from(&*name)
    )
}

/// Refuses a data set that the record does not fit into.
fn check(folder: &Path, text: &str, place: Place, new: &NewRecord<'_>) -> Result<(), Error> {
    let toml = TomlText::new(text, place);
    let table = toml.table()?;
    let span = table.span();
    let there: Description = toml.typed(Spanned::new(span, DeValue::Table(table.into_inner())))?;
    let signals = &there.signals;
    let same = signals.time.column == TIME
        && signals.time.unit == TimeUnit::Second
        && signals.input.column == INPUT
        && signals.input.unit == VoltageUnit::Volt
        && signals.output.column == OUTPUT
        && signals.output.unit == LengthUnit::Micrometre;
    if !same {
        return Err(toml.place_of(&[Step::Key("signals")]).error(format!(
            "the data set has other columns or units than {TIME}, {INPUT}, {OUTPUT}; record into a \
             new folder"
        )));
    }
    let Some(last) = there.records.last() else {
        return Ok(());
    };
    let file = folder.join(&last.file);
    let table = Table::open(&file)?;
    let remedy = "record into a new folder";
    let layout = Layout {
        time: (table.position(TIME, remedy)?, TimeUnit::Second.scale()),
        drive: (table.position(INPUT, remedy)?, VoltageUnit::Volt.scale()),
        displacement: (
            table.position(OUTPUT, remedy)?,
            LengthUnit::Micrometre.scale(),
        ),
    };
    let samples = record::read(&file, table, &layout, MIN_SAMPLES)?;
    match samples.time_s.last() {
        Some(&end) if new.start_s <= end => Err(Place::file(&file).error(format!(
            "ends at {end} s and the new record begins at {} s by the target's clock, which begins \
             anew when it is switched on; record into a new folder than {}",
            new.start_s,
            quoted(&folder.to_string_lossy()),
        ))),
        _ => Ok(()),
    }
}

fn free_name(folder: &Path, stem: &str) -> String {
    let first = format!("{stem}.csv");
    if !folder.join(&first).exists() {
        return first;
    }
    (2u32..)
        .map(|number| format!("{stem}-{number}.csv"))
        .find(|name| !folder.join(name).exists())
        .unwrap_or(first)
}
