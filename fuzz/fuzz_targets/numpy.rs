//! `cargo fuzz run numpy`, see `README.md`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

#[path = "../targets/numpy.rs"]
mod numpy;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().unwrap());

fuzz_target!(|bytes: &[u8]| numpy::run(FOLDER.path(), bytes));
