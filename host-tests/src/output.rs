//! Output that is there whole or not at all.
//!
//! A file is written beside its destination under a temporary name and renamed when complete, so an
//! error on the way leaves the destination as it was. [`remove_unfinished_on_interrupt`] extends that
//! to Ctrl-C and to the signals that end a process politely.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use crate::error::{Error, Place};
use crate::interrupt;
use crate::signals::{self, Column};

/// What an interrupt has to remove.
struct Unfinished {
    files: BTreeSet<PathBuf>,
    folders: Vec<PathBuf>,
}

static UNFINISHED: Mutex<Unfinished> = Mutex::new(Unfinished {
    files: BTreeSet::new(),
    folders: Vec::new(),
});

fn unfinished() -> MutexGuard<'static, Unfinished> {
    // The sets are consistent after every single step, so a panic elsewhere does not spoil them.
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Makes Ctrl-C, and termination and hang-up where the system knows them, remove every unfinished
/// file before the process says so in one line and ends with exit code 130; while an [`interrupt::Deferred`] lives, the first
/// one is left to its owner. To be called once, by the program's `main`.
///
/// # Errors
/// When the handler cannot be installed, for example because there is one already.
pub fn remove_unfinished_on_interrupt() -> Result<(), Error> {
    ctrlc::set_handler(|| {
        if interrupt::defer() {
            return;
        }
        // The lock is kept until the end, so that nothing new begins and nothing half-renamed stays.
        let unfinished = unfinished();
        for file in &unfinished.files {
            let _ = fs::remove_file(file);
        }
        for folder in unfinished.folders.iter().rev() {
            let _ = fs::remove_dir(folder);
        }
        // A line of progress may stand where the message goes.
        let mut errors = io::stderr().lock();
        let clear = if errors.is_terminal() { "\r\x1b[K" } else { "" };
        let _ = writeln!(
            errors,
            "{clear}error: interrupted; nothing unfinished is left, earlier files are as they were"
        );
        std::process::exit(130);
    })
    .map_err(|error| Error::request(format!("Ctrl-C cannot be handled: {error}; start again")))
}

/// Keeps a temporary file on the list of what an interrupt removes.
#[derive(Debug)]
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        unfinished().files.remove(&self.0);
    }
}

/// Folders made on the way, removed again unless kept.
#[derive(Debug, Default)]
struct MadeFolders(Vec<PathBuf>);

impl MadeFolders {
    /// Makes a folder and the missing ones above it.
    fn make(path: &Path) -> io::Result<Self> {
        let mut made = Self::default();
        if path.exists() && !path.is_dir() {
            return Err(io::ErrorKind::NotADirectory.into());
        }
        let missing: Vec<_> = path
            .ancestors()
            .take_while(|part| !part.as_os_str().is_empty() && !part.exists())
            .collect();
        for part in missing.iter().rev() {
            let mut unfinished = unfinished();
            match fs::create_dir(part) {
                Ok(()) => {
                    unfinished.folders.push(part.to_path_buf());
                    made.0.push(part.to_path_buf());
                }
                // Somebody else made it, or it is a way back up as in `new/..`.
                Err(_) if part.is_dir() => {}
                Err(error) => return Err(error),
            }
        }
        Ok(made)
    }

    fn keep(&mut self) {
        let made = std::mem::take(&mut self.0);
        unfinished().folders.retain(|folder| !made.contains(folder));
    }
}

impl Drop for MadeFolders {
    fn drop(&mut self) {
        for folder in self.0.iter().rev() {
            // Fails, as it should, where somebody else has put something into it.
            let _ = fs::remove_dir(folder);
        }
        self.keep();
    }
}

/// A file that appears at its destination only by [`AtomicFile::commit`]; dropped before, it leaves
/// no trace.
#[derive(Debug)]
pub struct AtomicFile {
    // Dropped in this order: the file, its entry in the list, the folders around it.
    writer: BufWriter<NamedTempFile>,
    listed: Listed,
    made: MadeFolders,
    destination: PathBuf,
    /// As the caller named it: a link may lead to a name with another end.
    named: PathBuf,
    place: Place,
}

impl AtomicFile {
    /// Begins a file; a missing folder is made. The file there now stays as it is until the commit.
    ///
    /// # Errors
    /// When the destination is a folder or a device, or its folder cannot be made or written to.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let place = Place::file(path);
        // A link keeps its place: the file that it leads to is replaced.
        let destination = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if destination.is_dir() {
            return Err(place.error("is a folder; name a file"));
        }
        if destination.exists() && !destination.is_file() {
            return Err(place.error("is not an ordinary file; name one"));
        }
        let folder = match destination.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent,
            _ => Path::new("."),
        };
        let made = MadeFolders::make(folder).map_err(|source| cannot_create(&place, source))?;
        let (file, listed) = {
            let mut unfinished = unfinished();
            let file = temporary_in(folder).map_err(|source| cannot_create(&place, source))?;
            unfinished.files.insert(file.path().to_owned());
            let listed = Listed(file.path().to_owned());
            (file, listed)
        };
        let writer = BufWriter::with_capacity(1 << 18, file);
        Ok(Self {
            writer,
            listed,
            made,
            destination,
            named: path.to_owned(),
            place,
        })
    }

    /// The destination, as named by the caller, for messages.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// Writes named columns in the form that the name of the destination says, see
    /// [`signals::write_as`].
    ///
    /// # Errors
    /// Those of [`signals::write_as`].
    pub fn write_columns(&mut self, columns: &[Column<'_>]) -> Result<(), Error> {
        signals::write_as(&self.named, &mut self.writer, &self.place, columns)
    }

    /// Writes bytes.
    ///
    /// # Errors
    /// When the system refuses, for example because the disk is full.
    pub fn write_bytes(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.writer
            .write_all(bytes)
            .map_err(|source| cannot_write(&self.place, source))
    }

    /// Puts the complete file at its destination.
    ///
    /// # Errors
    /// When the system refuses to write the rest or to rename; the destination is then as it was.
    pub fn commit(mut self) -> Result<(), Error> {
        self.complete()?;
        publish(vec![self])
    }

    /// Everything that may fail for want of space, before anything is renamed.
    fn complete(&mut self) -> Result<(), Error> {
        let written = self.writer.flush();
        // On disk before the rename: a crash must not leave an empty file under the final name.
        written
            .and_then(|()| self.writer.get_ref().as_file().sync_all())
            .map_err(|source| cannot_write(&self.place, source))
    }

    /// Renames a completed file. What is handed back takes [`UNFINISHED`] when it is dropped.
    fn rename(self) -> (Result<(), Error>, Listed, MadeFolders) {
        let Self {
            writer,
            listed,
            made,
            destination,
            place,
            ..
        } = self;
        let renamed = writer
            .into_inner()
            .map_err(io::IntoInnerError::into_error)
            .and_then(|file| file.persist(&destination).map_err(|refused| refused.error))
            .map_err(|source| cannot_write(&place, source));
        (renamed.map(drop), listed, made)
    }
}

/// Renames completed files in one go: an interrupt comes before the first rename or after the last.
fn publish(files: Vec<AtomicFile>) -> Result<(), Error> {
    // Both outlive the lock, which what they hold takes when it is dropped.
    let mut files = files.into_iter();
    let mut tried = Vec::with_capacity(files.len());
    {
        let _unfinished = unfinished();
        for file in files.by_ref() {
            let (renamed, listed, made) = file.rename();
            let refused = renamed.is_err();
            tried.push((renamed, listed, made));
            if refused {
                break;
            }
        }
    }
    tried
        .into_iter()
        .try_for_each(|(renamed, listed, mut made)| {
            drop(listed);
            if renamed.is_ok() {
                made.keep();
            }
            renamed
        })
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// A folder of results that appear together.
///
/// Files are staged one by one under temporary names inside the folder and renamed in one go by
/// [`OutputFolder::commit`]. Dropped before, it leaves earlier files as they were and removes the
/// folder again if it made it.
#[derive(Debug)]
pub struct OutputFolder {
    // Dropped in this order: a folder can only be removed when it is empty.
    staged: Vec<AtomicFile>,
    made: MadeFolders,
    path: PathBuf,
}

impl OutputFolder {
    /// Makes the folder where it is missing, and makes sure now, before any long work, that files can
    /// be written to it.
    ///
    /// # Errors
    /// When the path is a file, or the folder cannot be made or written to.
    pub fn create(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let place = Place::file(path);
        if path.exists() && !path.is_dir() {
            return Err(place.error("is a file; name a folder"));
        }
        let made = MadeFolders::make(path).map_err(|source| cannot_create(&place, source))?;
        {
            let _unfinished = unfinished();
            temporary_in(path)
                .and_then(NamedTempFile::close)
                .map_err(|source| cannot_create(&place, source))?;
        }
        Ok(Self {
            staged: Vec::new(),
            made,
            path: path.to_owned(),
        })
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Stages a complete file under its final name inside the folder.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn add(&mut self, name: &str, bytes: impl AsRef<[u8]>) -> Result<(), Error> {
        let mut file = AtomicFile::create(self.path.join(name))?;
        file.write_bytes(bytes.as_ref())?;
        self.add_file(file)
    }

    /// Stages named columns, see [`AtomicFile::write_columns`].
    ///
    /// # Errors
    /// Those of [`AtomicFile::write_columns`].
    pub fn add_columns(&mut self, name: &str, columns: &[Column<'_>]) -> Result<(), Error> {
        let mut file = AtomicFile::create(self.path.join(name))?;
        file.write_columns(columns)?;
        self.add_file(file)
    }

    fn add_file(&mut self, mut file: AtomicFile) -> Result<(), Error> {
        // A full disk shows here, while nothing has been renamed yet.
        file.complete()?;
        // Other files stand in a folder that this one made: it goes when all of them have gone.
        self.made.0.append(&mut file.made.0);
        self.staged.push(file);
        Ok(())
    }

    /// Puts all staged files at their destinations.
    ///
    /// # Errors
    /// When the system refuses a rename, which after staging only happens when somebody else changes
    /// the folder meanwhile; files renamed before it are complete.
    pub fn commit(mut self) -> Result<(), Error> {
        publish(std::mem::take(&mut self.staged))?;
        self.made.keep();
        Ok(())
    }
}

/// A new file with a name of its own. Opened here rather than by the library, which would make it
/// readable by its owner alone and put its name, that the user does not know, into the messages.
fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    tempfile::Builder::new()
        .prefix(".hysteron-")
        .suffix(".tmp")
        .make_in(folder, |path| {
            fs::File::options().write(true).create_new(true).open(path)
        })
}

fn cannot_create(place: &Place, source: io::Error) -> Error {
    let remedy = "choose a folder you may write to";
    place.clone().io_error("cannot create", remedy, source)
}

fn cannot_write(place: &Place, source: io::Error) -> Error {
    let remedy = "free some space or write elsewhere";
    place
        .clone()
        .io_error("cannot write", remedy, of_system(source))
}

/// What the system said, without the temporary name that the library adds.
fn of_system(error: io::Error) -> io::Error {
    let within = error.get_ref().and_then(|within| within.source());
    let code = within
        .and_then(|source| source.downcast_ref::<io::Error>())
        .and_then(io::Error::raw_os_error);
    code.map_or(error, io::Error::from_raw_os_error)
}
