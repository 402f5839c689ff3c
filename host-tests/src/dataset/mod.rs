//! Data sets: measured records of drive and displacement, checked and converted to internal units.
//!
//! A data set is a folder with a `dataset.toml` that lists CSV or NumPy files and their roles (`docs/dataset.md`
//! is the format's description), or one such file alone.

mod description;
mod folder;
mod lone;
pub mod long;
mod record;
mod save;
mod write;

use std::path::Path;

use serde::{Deserialize, Serialize};

pub use crate::units::LengthUnit;
pub use description::{schema, schema_text};
pub(crate) use save::{Columns, add_files};
pub use write::{NewRecord, add_record};

use crate::error::{Error, Place};

/// The least number of samples a record may have.
pub const MIN_SAMPLES: usize = 8;

/// A checked data set.
#[derive(Clone, Debug, PartialEq)]
pub struct Dataset {
    /// The name the data set gives itself; for a file alone its stem.
    pub name: String,
    /// The unit in which the data set states its displacement, and in which figures about it are
    /// reported. The records themselves are in micrometres.
    pub output_unit: LengthUnit,
    /// Whether the displacement's offset is one for all records or arbitrary in each.
    pub zero: Zero,
    /// The same for the drive.
    ///
    /// A drive offset that is arbitrary in each record passes through a bank of play operators as an
    /// offset of the displacement (play commutes with a shift of its input), so a fit of the
    /// hysteresis alone may treat it as `zero: PerRecord`. It does not pass through an asymmetry or
    /// any other stage that depends on the absolute value.
    pub input_zero: Zero,
    /// The records in the order of the data set; at least one has the role [`Role::Fit`].
    ///
    /// There may be none with [`Role::Select`] or [`Role::Report`]. Whoever chooses a structure then
    /// has to choose without held-out data, and there is no held-out figure to report.
    pub records: Vec<Record>,
}

/// One uniformly sampled stretch of measurement in volts, micrometres and seconds.
///
/// `time_s`, `drive_v` and `displacement_um` have the same length, at least [`MIN_SAMPLES`], and
/// hold finite numbers only.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// The file's stem, or the file as listed where two stems are equal; for a part of a file alone
    /// the stem and the role, as in `scan (fit)`. Unique in the data set.
    pub name: String,
    /// What the record serves for.
    pub role: Role,
    /// Time of the first sample in seconds, on the data set's own clock.
    pub start_s: f64,
    /// Sample time in seconds: the mean step of the time column.
    pub sample_time_s: f64,
    /// Absolute time of each sample in seconds, as recorded.
    pub time_s: Vec<f64>,
    /// Drive voltage of each sample in volts.
    pub drive_v: Vec<f64>,
    /// Displacement of each sample in micrometres.
    pub displacement_um: Vec<f64>,
    /// The index in [`Dataset::records`] of the record that this one continues without a gap: its
    /// first sample comes one sample time after the other's last, so the state of every play
    /// operator (and of any other stage with a memory) at its start is the state at the other's end.
    ///
    /// Set for the second and third part of a file alone. `None` where the state at the start is
    /// unknown.
    pub continues: Option<usize>,
}

/// What a record serves for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Parameters are fitted to it.
    Fit,
    /// The structure is chosen on it (how many plays, which effects).
    Select,
    /// Looked at once, at the end, for the figures that are reported.
    Report,
}

/// Whether a signal's offset means the same in all records.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Zero {
    /// One offset for all records.
    #[default]
    Shared,
    /// The offset is arbitrary in each record and has to be fitted there.
    PerRecord,
}

impl Dataset {
    /// Loads a data set from a folder with a `dataset.toml`, from that file itself (any `.toml`
    /// file), or from one CSV, `.npz` or `.npy` file alone.
    ///
    /// A file alone gives three records that continue each other: the first 60 % of its samples to
    /// fit, the next 20 % to select and the last 20 % to report.
    ///
    /// # Errors
    /// One line with file, line and column for anything that is missing, malformed, not finite, not
    /// uniformly sampled or in an unknown unit; `docs/dataset.md` lists what is refused.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        if path.is_dir() {
            let description = path.join("dataset.toml");
            if !description.exists() {
                return Err(Place::file(path).error(
                    "the folder holds no dataset.toml; write one (see docs/dataset.md) or name \
                     one CSV, .npz or .npy file",
                ));
            }
            return folder::load(&description);
        }
        if !path.exists() {
            return Err(Place::file(path).error(
                "there is no such file or folder; name a folder with a dataset.toml, or one CSV, \
                 .npz or .npy file",
            ));
        }
        let is_toml = path
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("toml"));
        if is_toml {
            folder::load(path)
        } else {
            lone::load(path)
        }
    }

    /// The records of one role, in the order of the data set.
    pub fn with_role(&self, role: Role) -> impl Iterator<Item = &Record> {
        self.records
            .iter()
            .filter(move |record| record.role == role)
    }
}
