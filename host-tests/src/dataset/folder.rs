//! A data set described by a `dataset.toml`.

use std::collections::HashMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

use toml::Spanned;
use toml::de::DeValue;

use super::description::{Description, Signals};
use super::long::{Plan, Source};
use super::record::{self, Layout};
use super::{Dataset, MIN_SAMPLES, Record, Role};
use crate::error::{Error, Place, quoted};
use crate::table::Table;
use crate::toml_text::{Step, TomlText, read_text};
use crate::units::Unit;

/// A description with the files of its records.
fn described(path: &Path) -> Result<(Description, Vec<PathBuf>), Error> {
    let text = read_text(path)?;
    let toml = TomlText::new(&text, Place::file(path));
    let table = toml.table()?;
    let span = table.span();
    let description: Description =
        toml.typed(Spanned::new(span, DeValue::Table(table.into_inner())))?;
    check_columns(&description.signals, &toml)?;
    if !description
        .records
        .iter()
        .any(|entry| entry.role == Role::Fit)
    {
        return Err(toml
            .place_of(&[Step::Key("record")])
            .error("no record has the role \"fit\"; give it to at least one"));
    }

    let folder = path.parent().unwrap_or(Path::new(""));
    let files = record_files(folder, &description, &toml)?;
    Ok((description, files))
}

/// What a `dataset.toml` describes, the samples not yet read.
pub(super) fn plan(path: &Path) -> Result<Plan, Error> {
    let (description, files) = described(path)?;
    let names = record_names(&description);
    let sources = files.into_iter().zip(names).zip(&description.records);
    let sources = sources.map(|((file, name), entry)| {
        let layout = layout(&Table::open(&file)?, &description.signals)?;
        Ok(Source {
            role: Some(entry.role),
            layout,
            file,
            name,
        })
    });
    Ok(Plan {
        sources: sources.collect::<Result<_, Error>>()?,
        output_unit: description.signals.output.unit,
        zero: description.signals.output.zero,
        input_zero: description.signals.input.zero,
        name: description.name,
    })
}

/// Loads the data set that a `dataset.toml` describes.
pub(super) fn load(path: &Path) -> Result<Dataset, Error> {
    let (description, files) = described(path)?;
    let names = record_names(&description);
    let mut records = Vec::with_capacity(files.len());
    for ((file, name), entry) in files.iter().zip(names).zip(&description.records) {
        let table = Table::open(file)?;
        let layout = layout(&table, &description.signals)?;
        let samples = record::read(file, table, &layout, MIN_SAMPLES)?;
        records.push(Record {
            name,
            role: entry.role,
            start_s: samples.time_s[0],
            sample_time_s: samples.sample_time_s,
            time_s: samples.time_s,
            drive_v: samples.drive_v,
            displacement_um: samples.displacement_um,
            continues: None,
        });
    }
    Ok(Dataset {
        name: description.name,
        output_unit: description.signals.output.unit,
        zero: description.signals.output.zero,
        input_zero: description.signals.input.zero,
        records,
    })
}

/// No column may serve as two signals.
fn check_columns(signals: &Signals, toml: &TomlText<'_>) -> Result<(), Error> {
    let named = [
        ("time", &signals.time.column),
        ("input", &signals.input.column),
        ("output", &signals.output.column),
    ];
    for (later, (key, column)) in named.iter().enumerate() {
        if let Some((other, _)) = named[..later].iter().find(|(_, name)| name == column) {
            let place = toml.place_of(&[Step::Key("signals"), Step::Key(key), Step::Key("column")]);
            return Err(place.error(format!(
                "signals.{key}.column: {} is the column of {other} already; name another",
                quoted(column)
            )));
        }
    }
    Ok(())
}

/// The records' files, each one there, inside the folder and listed once.
fn record_files(
    folder: &Path,
    description: &Description,
    toml: &TomlText<'_>,
) -> Result<Vec<PathBuf>, Error> {
    let mut seen = HashMap::new();
    let mut files = Vec::with_capacity(description.records.len());
    for (index, entry) in description.records.iter().enumerate() {
        let refuse = |problem: String| {
            let steps = [Step::Key("record"), Step::Index(index), Step::Key("file")];
            let file = quoted(&entry.file);
            Err(toml
                .place_of(&steps)
                .error(format!("record[{index}].file: {file} {problem}")))
        };
        let inside = |part| matches!(part, Component::Normal(_) | Component::CurDir);
        let relative = Path::new(&entry.file);
        if !relative.components().all(inside) {
            return refuse(
                "leads out of the data set's folder; put the file into the folder".to_owned(),
            );
        }
        let file = folder.join(relative);
        if !file.is_file() {
            let what = if file.is_dir() {
                "is a folder"
            } else {
                "is not there"
            };
            return refuse(format!(
                "{what}; name a CSV, .npz or .npy file in the data set's folder"
            ));
        }
        // The same samples under two roles would make a held-out figure worthless.
        let same = fs::canonicalize(&file).unwrap_or_else(|_| file.clone());
        if let Some(other) = seen.insert(same, index) {
            return refuse(format!(
                "is the file of record[{other}] already; list it once"
            ));
        }
        files.push(file);
    }
    Ok(files)
}

/// File stems, or the file as listed where a stem is not unique.
fn record_names(description: &Description) -> Vec<String> {
    let stem = |file: &str| {
        Path::new(file)
            .file_stem()
            .map_or(file.to_owned(), |stem| stem.to_string_lossy().into())
    };
    let mut uses: HashMap<String, usize> = HashMap::new();
    for entry in &description.records {
        *uses.entry(stem(&entry.file)).or_default() += 1;
    }
    let name = |file: &String| Some(stem(file)).filter(|name| uses[name] == 1);
    description
        .records
        .iter()
        .map(|entry| name(&entry.file).unwrap_or_else(|| entry.file.clone()))
        .collect()
}

fn layout(table: &Table, signals: &Signals) -> Result<Layout, Error> {
    let remedy = "name a column of the file in dataset.toml";
    Ok(Layout {
        time: (
            table.position(&signals.time.column, remedy)?,
            signals.time.unit.scale(),
        ),
        drive: (
            table.position(&signals.input.column, remedy)?,
            signals.input.unit.scale(),
        ),
        displacement: (
            table.position(&signals.output.column, remedy)?,
            signals.output.unit.scale(),
        ),
    })
}
