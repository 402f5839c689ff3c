//! Data sets longer than memory or patience: read as a stream, condensed to so many samples, and at
//! the end scored as a stream, every sample.
//!
//! A first pass surveys each file: its grid of times, the drive's range and where it lies, and at which
//! scale of time drive and displacement bend. A second keeps means of neighbouring samples, as many to
//! a mean as neither signal bends within, of the whole record where these are few enough, else of
//! stretches of it. `docs/dataset.md` has the rules and what they cost.

mod condense;
mod survey;

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::record::Layout;
use super::{Dataset, LengthUnit, Role, Zero, folder, lone};
use crate::error::{Error, Place};
use crate::table::{ColumnRequest, Table};
use survey::Survey;

/// Samples of a data set that are worked on if not told otherwise.
pub const MOST_SAMPLES: usize = 1 << 18;
/// The fewest that make sense: windows still have cycles.
pub const LEAST_SAMPLES: usize = 1 << 12;
/// Bytes of the shortest row, `0,0,0` and a line feed.
const SHORTEST_ROW: u64 = 6;
/// Rows between two words of progress.
const TOLD_EVERY: u64 = 1 << 18;

/// What a data set says of itself, its samples not yet read.
pub(super) struct Plan {
    pub(super) name: String,
    pub(super) output_unit: LengthUnit,
    pub(super) zero: Zero,
    pub(super) input_zero: Zero,
    pub(super) sources: Vec<Source>,
}

/// A file of a data set.
pub(super) struct Source {
    pub(super) file: PathBuf,
    pub(super) name: String,
    /// Its role; `None` for a file alone, which is shared out between the three.
    pub(super) role: Option<Role>,
    pub(super) layout: Layout,
}

/// A data set to work on and, where it is a condensed one, where it comes from.
pub struct Loaded {
    /// All samples, or means and stretches of them.
    pub dataset: Dataset,
    /// The files, to be scored as a whole.
    pub long: Option<Long>,
}

/// The files of a condensed data set.
pub struct Long {
    plan: Plan,
    surveys: Vec<Survey>,
    notes: Vec<String>,
}

/// A file of a condensed data set, for a pass over all its samples.
pub struct Whole<'a> {
    /// Samples.
    pub samples: u64,
    /// Time of the first in s.
    pub start_s: f64,
    /// Time between two in s.
    pub sample_time_s: f64,
    /// Lowest and highest drive in V.
    pub drive_v: (f64, f64),
    /// Which samples serve for what.
    pub roles: Vec<(Role, Range<u64>)>,
    source: &'a Source,
}

/// Loads a data set as [`Dataset::load`] does, condensed where it has more than `most` samples (at
/// least [`LEAST_SAMPLES`] are kept). `progress` is told what is done now.
///
/// # Errors
/// Those of [`Dataset::load`].
pub fn load(path: &Path, most: usize, progress: &dyn Fn(&str)) -> Result<Loaded, Error> {
    let most = most.max(LEAST_SAMPLES);
    let all = || {
        let dataset = Dataset::load(path)?;
        Ok(Loaded {
            dataset,
            long: None,
        })
    };
    let Some(plan) = plan(path)? else {
        return all();
    };
    let mut bytes = 0u64;
    for source in &plan.sources {
        match std::fs::metadata(&source.file) {
            // What can be read only once cannot be surveyed.
            Ok(about) if !about.is_file() => return all(),
            Ok(about) => {
                let requests = source.layout.requests();
                let rows = Table::open(&source.file)?.rows(&requests)?;
                bytes += rows.map_or(about.len(), |rows| rows.saturating_mul(SHORTEST_ROW));
            }
            Err(_) => return all(),
        }
    }
    if bytes <= SHORTEST_ROW * most as u64 {
        return all();
    }
    let surveys = plan
        .sources
        .iter()
        .map(|source| Survey::of(source, progress))
        .collect::<Result<Vec<_>, _>>()?;
    let rows: u64 = surveys.iter().map(|survey| survey.rows).sum();
    if rows <= most as u64 {
        return all();
    }
    let (records, mut notes) = condense::records(&plan, &surveys, most, progress)?;
    let kept: usize = records.iter().map(|record| record.drive_v.len()).sum();
    notes.insert(
        0,
        format!(
            "The data set holds {rows} samples, more than the {most} that are worked on; {kept} were \
             made of them:"
        ),
    );
    Ok(Loaded {
        dataset: Dataset {
            name: plan.name.clone(),
            output_unit: plan.output_unit,
            zero: plan.zero,
            input_zero: plan.input_zero,
            records,
        },
        long: Some(Long {
            plan,
            surveys,
            notes,
        }),
    })
}

/// `None` where [`Dataset::load`] has something to say of the path itself.
fn plan(path: &Path) -> Result<Option<Plan>, Error> {
    let is_toml = path
        .extension()
        .is_some_and(|end| end.eq_ignore_ascii_case("toml"));
    let description = match path.is_dir() {
        true => path.join("dataset.toml"),
        false => path.to_owned(),
    };
    if !description.is_file() {
        return Ok(None);
    }
    if path.is_dir() || is_toml {
        folder::plan(&description).map(Some)
    } else {
        lone::plan(path).map(Some)
    }
}

impl Long {
    /// What was kept of each file, a sentence each.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Whether each file has an offset of its own.
    pub fn own_offsets(&self) -> bool {
        self.plan.zero == Zero::PerRecord || self.plan.input_zero == Zero::PerRecord
    }

    /// The files.
    pub fn files(&self) -> impl Iterator<Item = Whole<'_>> {
        let pairs = self.plan.sources.iter().zip(&self.surveys);
        pairs.map(|(source, survey)| Whole {
            samples: survey.rows,
            start_s: survey.first_s,
            sample_time_s: survey.sample_time_s(),
            drive_v: survey.drive_v(),
            roles: parts(source, survey.rows)
                .into_iter()
                .map(|(role, _, rows)| (role, rows))
                .collect(),
            source,
        })
    }
}

impl Whole<'_> {
    /// Hands each drive (V) and displacement (um) to `take`, in order, until it refuses one.
    ///
    /// # Errors
    /// What `take` refused; a file that has changed since it was read first.
    pub fn each(
        &self,
        progress: &dyn Fn(&str),
        mut take: impl FnMut(f64, f64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let mut rows = Rows::open(self.source, "scoring", progress)?;
        let mut count = 0;
        while let Some((_, [_, drive, displacement])) = rows.next()? {
            take(drive, displacement)?;
            count += 1;
        }
        if count != self.samples {
            return Err(Place::file(&self.source.file)
                .error("the file has changed while it was worked on; begin again"));
        }
        Ok(())
    }
}

/// Roles, labels and rows of the records that a file makes.
fn parts(source: &Source, rows: u64) -> Vec<(Role, Option<&'static str>, Range<u64>)> {
    match source.role {
        Some(role) => vec![(role, None, 0..rows)],
        None => lone::parts(rows as usize)
            .map(|(role, label, rows)| (role, Some(label), rows.start as u64..rows.end as u64))
            .to_vec(),
    }
}

/// A file's rows one after the other.
struct Rows<'a> {
    table: Table,
    requests: [ColumnRequest; 3],
    doing: &'static str,
    name: &'a str,
    bytes: u64,
    count: u64,
    progress: &'a dyn Fn(&str),
}

impl<'a> Rows<'a> {
    fn open(
        source: &'a Source,
        doing: &'static str,
        progress: &'a dyn Fn(&str),
    ) -> Result<Self, Error> {
        Ok(Self {
            table: Table::open(&source.file)?,
            requests: source.layout.requests(),
            doing,
            name: &source.name,
            bytes: std::fs::metadata(&source.file).map_or(0, |about| about.len()),
            count: 0,
            progress,
        })
    }

    /// Line, and time (s), drive (V) and displacement (um).
    fn next(&mut self) -> Result<Option<(u64, [f64; 3])>, Error> {
        if self.count.is_multiple_of(TOLD_EVERY) {
            let percent = self.table.percent(self.bytes);
            let (doing, name) = (self.doing, self.name);
            (self.progress)(&format!(
                "{doing} {name}: {percent} %, {} samples",
                self.count
            ));
        }
        self.count += 1;
        self.table.next_numbers(&self.requests)
    }
}
