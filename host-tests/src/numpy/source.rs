//! Bytes of an array, from a file of its own or from an archive.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use flate2::Crc;
use flate2::read::DeflateDecoder;
use zip::{CompressionMethod, ZipArchive};

use crate::error::{Error, Place};

const READ_BUFFER: usize = 1 << 16;

/// Where an array lies.
pub(super) struct Member {
    path: PathBuf,
    start: u64,
    /// Bytes in the file, and of the array.
    stored: u64,
    size: u64,
    packing: Packing,
    /// Checksum, in an archive.
    crc: Option<u32>,
}

#[derive(Clone, Copy, PartialEq)]
enum Packing {
    None,
    Deflate,
    Unknown,
}

/// An array that is being read.
pub(super) struct Stream {
    reader: Box<dyn Read>,
    sum: Crc,
    wanted: Option<u32>,
    /// The row read last; its length is set by who reads.
    pub(super) row: Vec<u8>,
}

fn unreadable(place: &Place, source: io::Error) -> Error {
    place
        .clone()
        .io_error("cannot read", "check the path and its permissions", source)
}

/// The arrays of an archive with their names.
pub(super) fn members(path: &Path, place: &Place) -> Result<Vec<(String, Member)>, Error> {
    let file = File::open(path).map_err(|source| unreadable(place, source))?;
    let not_archive = |error| {
        place.clone().error(format!(
            "is not a whole zip archive ({error}); copy it again or save it with numpy.savez"
        ))
    };
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(not_archive)?;
    let mut members = Vec::new();
    for index in 0..archive.len() {
        let entry = archive.by_index_raw(index).map_err(not_archive)?;
        let Some(name) = entry
            .name()
            .map_err(not_archive)?
            .strip_suffix(".npy")
            .map(str::to_owned)
        else {
            continue;
        };
        let packing = match entry.compression() {
            _ if entry.encrypted() => Packing::Unknown,
            CompressionMethod::Stored => Packing::None,
            CompressionMethod::Deflated => Packing::Deflate,
            _ => Packing::Unknown,
        };
        let member = Member {
            path: path.to_owned(),
            start: entry.data_start().unwrap_or(0),
            stored: entry.compressed_size(),
            size: entry.size(),
            packing,
            crc: Some(entry.crc32()),
        };
        members.push((name, member));
    }
    Ok(members)
}

impl Member {
    /// A file that is one array.
    pub(super) fn whole(path: &Path, place: &Place) -> Result<Self, Error> {
        let about = std::fs::metadata(path).map_err(|source| unreadable(place, source))?;
        if !about.is_file() {
            return Err(place.clone().error("is not an ordinary file; name one"));
        }
        Ok(Self {
            path: path.to_owned(),
            start: 0,
            stored: about.len(),
            size: about.len(),
            packing: Packing::None,
            crc: None,
        })
    }

    /// Bytes of the array with its header.
    pub(super) fn size(&self) -> u64 {
        self.size
    }

    /// Opens the array at its header.
    pub(super) fn open(&self, place: &Place) -> Result<Stream, String> {
        let open = || -> io::Result<BufReader<File>> {
            let mut file = BufReader::with_capacity(READ_BUFFER, File::open(&self.path)?);
            file.seek(SeekFrom::Start(self.start))?;
            Ok(file)
        };
        let file = open().map_err(|error| format!("cannot be read from {place}: {error}"))?;
        let stored = file.take(self.stored);
        let reader: Box<dyn Read> = match self.packing {
            Packing::None => Box::new(stored),
            Packing::Deflate => Box::new(BufReader::with_capacity(
                READ_BUFFER,
                DeflateDecoder::new(stored).take(self.size),
            )),
            Packing::Unknown => {
                return Err(
                    "is packed or locked in a way that this program does not know; save it with \
                     numpy.savez or numpy.savez_compressed"
                        .into(),
                );
            }
        };
        Ok(Stream {
            reader,
            sum: Crc::new(),
            wanted: self.crc,
            row: Vec::new(),
        })
    }
}

impl Read for Stream {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let count = self.reader.read(to)?;
        self.sum.update(&to[..count]);
        Ok(count)
    }
}

impl Stream {
    /// Reads the next row.
    pub(super) fn next_row(&mut self) -> Result<(), String> {
        let read = self.reader.read_exact(&mut self.row);
        read.map_err(|error| format!("is damaged: {error}; copy or save the file again"))?;
        self.sum.update(&self.row);
        Ok(())
    }

    /// Holds the checksum of all rows against the archive's.
    pub(super) fn finish(&mut self) -> Result<(), String> {
        if self.wanted.is_some_and(|wanted| wanted != self.sum.sum()) {
            return Err("is damaged: its checksum is wrong; copy or save the file again".into());
        }
        Ok(())
    }
}
