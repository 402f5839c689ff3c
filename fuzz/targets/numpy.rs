//! Any bytes as NumPy's files, and arrays of any header in a right frame: read or refused in one line;
//! what was read is finite, as long as its header says, and is read again as it was written.

use std::fs;
use std::io::{self, Cursor, Write};
use std::path::Path;

use hysteron_host::dataset::long;
use hysteron_host::error::Place;
use hysteron_host::signals::{self, Quantity, Signal};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Arrays of an archive made here, in their order in the input.
const MEMBERS: [&str; 4] = ["time_s", "drive_v", "displacement_um", "reference_um"];

/// Takes `bytes` as the content of a file, which is made in `folder`.
pub fn run(folder: &Path, bytes: &[u8]) {
    let (kind, content) = bytes.split_first().unwrap_or((&0, &[]));
    let (end, made) = match kind % 5 {
        0 => ("npy", content.to_vec()),
        1 => ("npz", content.to_vec()),
        2 => ("npy", array(content)),
        3 => ("npz", archive(content, CompressionMethod::Stored)),
        _ => ("npz", archive(content, CompressionMethod::Deflated)),
    };
    let file = folder.join("any").with_extension(end);
    if put(&file, &made).is_err() {
        return;
    }
    let told = match kind % 5 {
        0 | 2 => rows_told(&made).map(|rows| rows.first().copied().unwrap_or(0)),
        _ => None,
    };
    for (quantity, name) in [
        (Quantity::Drive, "drive_v"),
        (Quantity::Reference, "reference_um"),
        (Quantity::Displacement, "displacement_um"),
    ] {
        match signals::read(&file, quantity) {
            Ok(signal) => {
                as_long(told, signal.values.len());
                let end = ["npy", "npz"][usize::from(kind / 5 % 2)];
                again(
                    &folder.join("again").with_extension(end),
                    name,
                    quantity,
                    &signal,
                );
            }
            Err(error) => one_line(&error.to_string()),
        }
    }
    match long::load(&file, long::LEAST_SAMPLES, &|_| {}) {
        Ok(loaded) => {
            let mut all = 0;
            for record in &loaded.dataset.records {
                let count = record.time_s.len();
                assert!(count >= 8 && record.sample_time_s > 0.0);
                assert_eq!(
                    [record.drive_v.len(), record.displacement_um.len()],
                    [count; 2]
                );
                let columns = [&record.time_s, &record.drive_v, &record.displacement_um];
                assert!(
                    columns
                        .iter()
                        .all(|values| values.iter().all(|x| x.is_finite()))
                );
                all += count;
            }
            if loaded.long.is_none() {
                assert_eq!(loaded.dataset.records.len(), 3);
                as_long(told, all);
            }
        }
        Err(error) => one_line(&error.to_string()),
    }
}

/// An array whose header is the first line of `content`, its length as it should be.
fn array(content: &[u8]) -> Vec<u8> {
    let line = content.iter().position(|&byte| byte == b'\n');
    let (text, numbers) = content.split_at(line.map_or(content.len(), |at| at + 1));
    let length = u16::try_from(text.len()).unwrap_or(u16::MAX).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], text, numbers].concat()
}

/// An archive of arrays, each of so many bytes as the two before it say.
fn archive(mut content: &[u8], method: CompressionMethod) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default().compression_method(method);
    for name in MEMBERS {
        let [low, high, rest @ ..] = content else {
            break;
        };
        let length = usize::from(u16::from_le_bytes([*low, *high]));
        let (member, rest) = rest.split_at(length.min(rest.len()));
        content = rest;
        archive.start_file(format!("{name}.npy"), options).unwrap();
        archive.write_all(&array(member)).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// The shape in a file's header, where it is there once and as NumPy writes it.
fn rows_told(file: &[u8]) -> Option<Vec<u64>> {
    let header = match file.get(6)? {
        1 => file.get(10..)?,
        _ => file.get(12..)?,
    };
    let length = match file[6] {
        1 => usize::from(u16::from_le_bytes([file[8], file[9]])),
        _ => u32::from_le_bytes([file[8], file[9], file[10], file[11]]) as usize,
    };
    let text = String::from_utf8_lossy(header.get(..length)?);
    let (_, after) = text.split_once("'shape': (")?;
    let (inside, rest) = after.split_once(')')?;
    if text.matches("shape").count() != 1 || rest.contains('\\') {
        return None;
    }
    inside
        .split(',')
        .filter(|axis| !axis.trim().is_empty())
        .map(|axis| axis.trim().parse().ok())
        .collect()
}

/// A new file each time: some file systems write one that is overwritten to the disk at once.
fn put(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let _ = fs::remove_file(file);
    fs::write(file, bytes)
}

fn as_long(told: Option<u64>, count: usize) {
    if let Some(told) = told {
        assert_eq!(told, count as u64);
    }
}

fn again(file: &Path, name: &str, quantity: Quantity, signal: &Signal) {
    assert!(signal.time_s.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(signal.time_s.len(), signal.values.len());
    let all = [&signal.time_s, &signal.values];
    assert!(
        all.iter()
            .all(|values| values.iter().all(|x| x.is_finite()))
    );
    let columns = [("time_s", &signal.time_s[..]), (name, &signal.values[..])];
    let mut bytes = Cursor::new(Vec::new());
    signals::write_as(file, &mut bytes, &Place::file(file), &columns).unwrap();
    put(file, &bytes.into_inner()).unwrap();
    assert_eq!(&signals::read(file, quantity).unwrap(), signal);
}

fn one_line(message: &str) {
    assert_eq!(message.lines().count(), 1, "{message:?}");
}
