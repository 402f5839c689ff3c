//! Any text as each of the program's TOML files: read or refused in one line, and a model that was
//! read is read again as it was written, and can be built.

use std::fs;
use std::path::Path;

use hysteron::settings::Settings;
use hysteron_host::dataset::Dataset;
use hysteron_host::link::settings;
use hysteron_host::plant::hidden::Truth;
use hysteron_host::{model_file, stage};

/// Takes `bytes` as the content of a file, which is made in `folder`.
pub fn run(folder: &Path, bytes: &[u8]) {
    let (kind, content) = bytes.split_first().unwrap_or((&0, &[]));
    let file = folder.join("any.toml");
    // A new file: some file systems write one that is overwritten to the disk at once.
    let _ = fs::remove_file(&file);
    if fs::write(&file, content).is_err() {
        return;
    }
    match kind % 4 {
        0 | 1 => model(&file),
        2 => {
            record(folder);
            match Dataset::load(&file) {
                Ok(set) => assert!(!set.records.is_empty()),
                Err(error) => one_line(&error.to_string()),
            }
        }
        _ => {
            match settings::load(&file, &Settings::default()) {
                Ok(read) => assert!(read.validate().is_ok()),
                Err(error) => one_line(&error.to_string()),
            }
            if let Err(error) = Truth::load(&file) {
                one_line(&error.to_string());
            }
        }
    }
}

fn model(file: &Path) {
    let model = match model_file::load(file) {
        Ok(model) => model,
        Err(error) => return one_line(&error.to_string()),
    };
    let again = model_file::parse(&model.to_toml_string(), "again.toml").unwrap();
    assert_eq!(again, model);
    match stage::chain(&model, 1e-4) {
        Ok(chain) => {
            let mut state = chain.start(0.0);
            for drive in [0.0, 10.0, -10.0, 1e3, 0.0] {
                chain.step(&mut state, drive);
            }
        }
        Err(error) => one_line(&error.to_string()),
    }
    if let Err(error) = stage::drive(&model, 1e-4, &[0.0, 1.0, -1.0]) {
        one_line(&error.to_string());
    }
    if let Err(error) = stage::drive_ahead(&model, 1e-4, &[0.0, 1.0, -1.0]) {
        one_line(&error.to_string());
    }
}

/// A record that a data set may list.
fn record(folder: &Path) {
    let file = folder.join("a.csv");
    if !file.exists() {
        let rows: String = (0..10).map(|k| format!("{k},{k},{k}\n")).collect();
        fs::write(file, format!("t,u,y\n{rows}")).unwrap();
    }
}

fn one_line(message: &str) {
    assert_eq!(message.lines().count(), 1, "{message:?}");
}
