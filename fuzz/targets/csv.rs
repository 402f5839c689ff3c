//! Any bytes as a CSV of signals: read or refused in one line, and what was read is a uniform record
//! that is read again as it was written.

use std::fs;
use std::io;
use std::path::Path;

use hysteron_host::dataset::Dataset;
use hysteron_host::error::Place;
use hysteron_host::signals::{self, Quantity};

/// Takes `bytes` as the content of a file, which is made in `folder`.
pub fn run(folder: &Path, bytes: &[u8]) {
    let (kind, content) = bytes.split_first().unwrap_or((&0, &[]));
    let file = folder.join("any.csv");
    let header: &[u8] = match kind % 4 {
        0 => b"",
        1 => b"time_s,drive_v\n",
        2 => b"time_ms,reference_nm\n",
        _ => b"time_s,drive_v,displacement_um\n",
    };
    if put(&file, &[header, content].concat()).is_err() {
        return;
    }
    for (quantity, name) in [
        (Quantity::Drive, "drive_v"),
        (Quantity::Reference, "reference_um"),
    ] {
        match signals::read(&file, quantity) {
            Ok(signal) => again(folder, name, quantity, &signal),
            Err(error) => one_line(&error.to_string()),
        }
    }
    match Dataset::load(&file) {
        Ok(set) => {
            assert_eq!(set.records.len(), 3);
            for record in &set.records {
                let count = record.time_s.len();
                assert!(count >= 8 && record.sample_time_s > 0.0);
                assert_eq!(
                    [record.drive_v.len(), record.displacement_um.len()],
                    [count; 2]
                );
                let all = [&record.time_s, &record.drive_v, &record.displacement_um];
                assert!(
                    all.iter()
                        .all(|values| values.iter().all(|x| x.is_finite()))
                );
            }
        }
        Err(error) => one_line(&error.to_string()),
    }
}

fn again(folder: &Path, name: &str, quantity: Quantity, signal: &signals::Signal) {
    assert!(signal.time_s.windows(2).all(|pair| pair[0] < pair[1]));
    assert_eq!(signal.time_s.len(), signal.values.len());
    let file = folder.join("again.csv");
    let columns = [("time_s", &signal.time_s[..]), (name, &signal.values[..])];
    let mut text = Vec::new();
    signals::write(&mut text, &Place::file(&file), &columns).unwrap();
    put(&file, &text).unwrap();
    assert_eq!(&signals::read(&file, quantity).unwrap(), signal);
}

/// A new file each time: some file systems write one that is overwritten to the disk at once.
fn put(file: &Path, bytes: &[u8]) -> io::Result<()> {
    let _ = fs::remove_file(file);
    fs::write(file, bytes)
}

fn one_line(message: &str) {
    assert_eq!(message.lines().count(), 1, "{message:?}");
}
