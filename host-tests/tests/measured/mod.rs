//! Where the measured data lie.

use std::path::PathBuf;

/// The folder of a measured data set, below `HYSTERON_DATA`; `None`, said loudly, when that is unset.
///
/// Set but wrong is a failure: where the data are expected no test may skip.
pub fn folder(name: &str) -> Option<PathBuf> {
    let Some(root) = std::env::var_os("HYSTERON_DATA") else {
        eprintln!("SKIPPED: needs measured data, see host-tests/data/README.md; set HYSTERON_DATA");
        return None;
    };
    let folder = PathBuf::from(root).join(name);
    assert!(
        folder.is_dir(),
        "HYSTERON_DATA is set, but {} is no folder",
        folder.display()
    );
    Some(folder)
}
