//! Columns as one structured array, or as an archive of arrays.

use std::io::{self, Seek, Write};
use std::path::Path;

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use crate::signals::Column;

/// Bytes that a header and the numbers behind it begin at a multiple of.
const ALIGNED: usize = 64;

/// Which of NumPy's files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// One array.
    Npy,
    /// An archive of arrays.
    Npz,
}

impl Form {
    /// The form that the end of a file's name says.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let end = path.extension()?.to_str()?.to_ascii_lowercase();
        match end.as_str() {
            "npy" => Some(Self::Npy),
            "npz" => Some(Self::Npz),
            _ => None,
        }
    }
}

/// Writes columns of equal length as doubles: a structured array with a field a column, or an archive
/// with an array a column, not packed.
pub(crate) fn write(
    to: &mut (impl Write + Seek),
    form: Form,
    columns: &[Column<'_>],
) -> io::Result<()> {
    let rows = columns.first().map_or(0, |(_, values)| values.len());
    match form {
        Form::Npy => {
            let fields: Vec<_> = columns
                .iter()
                .map(|(name, _)| format!("('{name}', '<f8')"))
                .collect();
            to.write_all(&header(&format!("[{}]", fields.join(", ")), rows))?;
            for row in 0..rows {
                for (_, values) in columns {
                    to.write_all(&values[row].to_le_bytes())?;
                }
            }
        }
        Form::Npz => {
            let mut archive = ZipWriter::new(&mut *to);
            let long = rows as u64 * 8 >= u64::from(u32::MAX) / 2;
            let options = SimpleFileOptions::default()
                .compression_method(CompressionMethod::Stored)
                .large_file(long);
            for (name, values) in columns {
                archive.start_file(format!("{name}.npy"), options)?;
                archive.write_all(&header("'<f8'", rows))?;
                for block in values.chunks(1 << 12) {
                    let bytes: Vec<u8> = block.iter().flat_map(|v| v.to_le_bytes()).collect();
                    archive.write_all(&bytes)?;
                }
            }
            archive.finish()?;
        }
    }
    to.flush()
}

/// Everything before the numbers of an array of one dimension.
fn header(entry: &str, rows: usize) -> Vec<u8> {
    let dict = format!("{{'descr': {entry}, 'fortran_order': False, 'shape': ({rows},), }}");
    // NumPy leaves room to write a longer shape later: as many digits as 2^64 - 1 has more than this one.
    let room = 21usize.saturating_sub(rows.to_string().len());
    let unpadded = 10 + dict.len() + room + 1;
    let padding = room + unpadded.next_multiple_of(ALIGNED) - unpadded;
    let text = format!("{dict}{}\n", " ".repeat(padding));
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    // The few columns there are leave the header far below 64 KiB.
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.bytes());
    bytes
}
