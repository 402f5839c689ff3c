//! Output that is there whole or not at all.

use std::fs;
use std::io::Write as _;

use hysteron_host::output::{AtomicFile, OutputFolder};

use crate::support::Folder;

#[test]
fn a_file_appears_only_by_the_commit() {
    let folder = Folder::new(&[("out.csv", b"old")]);
    let path = folder.path("out.csv");
    let mut dropped = AtomicFile::create(&path).unwrap();
    dropped.write_all(&vec![b'x'; 1 << 20]).unwrap();
    assert_eq!(
        folder.names(".").len(),
        2,
        "the temporary file stands beside its destination"
    );
    drop(dropped);
    assert_eq!(folder.names("."), ["out.csv"]);
    assert_eq!(fs::read(&path).unwrap(), b"old");

    let mut kept = AtomicFile::create(&path).unwrap();
    kept.write_bytes(b"new").unwrap();
    assert_eq!(fs::read(&path).unwrap(), b"old");
    kept.commit().unwrap();
    assert_eq!(folder.names("."), ["out.csv"]);
    assert_eq!(fs::read(&path).unwrap(), b"new");
}

#[test]
fn missing_folders_are_made_and_taken_back() {
    let folder = Folder::new(&[]);
    let path = folder.path("a/b/out.csv");
    drop(AtomicFile::create(&path).unwrap());
    assert!(folder.names(".").is_empty());
    let mut file = AtomicFile::create(&path).unwrap();
    file.write_bytes(b"1").unwrap();
    file.commit().unwrap();
    assert_eq!(folder.names("a/b"), ["out.csv"]);

    drop(OutputFolder::create(folder.path("c/../d/e")).unwrap());
    assert_eq!(folder.names("."), ["a"]);
}

#[test]
fn a_folder_of_results_appears_together() {
    let folder = Folder::new(&[("out/model.toml", b"old"), ("out/other", b"kept")]);
    let stage = |path: &str| {
        let mut out = OutputFolder::create(folder.path(path)).unwrap();
        out.add("model.toml", "new").unwrap();
        out.add("report.html", b"<html>").unwrap();
        out.add_columns("trace.csv", &[("time_s", &[0.5])]).unwrap();
        out
    };
    let staged = stage("out");
    assert_eq!(fs::read(folder.path("out/model.toml")).unwrap(), b"old");
    assert!(!folder.path("out/report.html").exists());
    drop(staged);
    assert_eq!(folder.names("out"), ["model.toml", "other"]);
    assert_eq!(fs::read(folder.path("out/model.toml")).unwrap(), b"old");

    drop(stage("fresh/deep"));
    assert_eq!(folder.names("."), ["out"]);

    stage("out").commit().unwrap();
    assert_eq!(
        folder.names("out"),
        ["model.toml", "other", "report.html", "trace.csv"]
    );
    assert_eq!(fs::read(folder.path("out/model.toml")).unwrap(), b"new");
    assert_eq!(
        fs::read(folder.path("out/trace.csv")).unwrap(),
        b"time_s\n0.5\n"
    );
}

#[test]
fn refusals() {
    let folder = Folder::new(&[("file", b"")]);
    let file = |name: &str| folder.message(&AtomicFile::create(folder.path(name)).unwrap_err());
    let out = |name: &str| folder.message(&OutputFolder::create(folder.path(name)).unwrap_err());
    assert_eq!(file("."), ".: is a folder; name a file");
    assert_eq!(out("file"), "file: is a file; name a folder");
    assert_eq!(
        out("file/out"),
        "file/out: cannot create: Not a directory (os error 20); choose a folder you may write to"
    );
    assert_eq!(
        file("file/out.csv"),
        "file/out.csv: cannot create: not a directory; choose a folder you may write to"
    );
    assert_eq!(folder.names("."), ["file"]);
}

/// A folder that even the superuser cannot write to: the message leaves the temporary name out.
#[cfg(target_os = "linux")]
#[test]
fn an_unwritable_folder_is_told_at_once() {
    assert_eq!(
        OutputFolder::create("/proc").unwrap_err().to_string(),
        "/proc: cannot create: No such file or directory (os error 2); choose a folder you may write to"
    );
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt, symlink};
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    use super::*;

    #[test]
    fn a_device_is_not_replaced() {
        let error = AtomicFile::create("/dev/null").unwrap_err();
        assert_eq!(
            error.to_string(),
            "/dev/null: is not an ordinary file; name one"
        );
    }

    #[test]
    fn a_link_stays_a_link() {
        let folder = Folder::new(&[("store/real.csv", b"old")]);
        let link = folder.path("out.csv");
        symlink(folder.path("store/real.csv"), &link).unwrap();
        let mut file = AtomicFile::create(&link).unwrap();
        file.write_bytes(b"new").unwrap();
        file.commit().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(folder.path("store/real.csv")).unwrap(), b"new");
    }

    #[test]
    fn permissions_are_those_of_any_new_file() {
        let folder = Folder::new(&[("usual", b"")]);
        let path = folder.path("out.csv");
        AtomicFile::create(&path).unwrap().commit().unwrap();
        let mode = |path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(path), mode(folder.path("usual")));
    }

    /// The other half of the test below, run in a process of its own: begins output and waits.
    #[test]
    fn interrupted_process() {
        let Some(path) = std::env::var_os("HYSTERON_TEST_INTERRUPTED") else {
            return;
        };
        hysteron_host::output::remove_unfinished_on_interrupt().unwrap();
        let path = std::path::Path::new(&path);
        let mut folder = OutputFolder::create(path.join("out/deep")).unwrap();
        folder.add("report.html", "staged").unwrap();
        let mut file = AtomicFile::create(path.join("out.csv")).unwrap();
        file.write_all(&vec![b'x'; 1 << 20]).unwrap();
        fs::write(path.join("ready"), "").unwrap();
        std::thread::sleep(Duration::from_secs(60));
        panic!("was not interrupted");
    }

    #[test]
    fn an_interrupt_leaves_nothing() {
        for signal in ["INT", "TERM"] {
            let folder = Folder::new(&[]);
            let mut child = Command::new(std::env::current_exe().unwrap())
                .args(["--exact", "output::unix::interrupted_process"])
                .env("HYSTERON_TEST_INTERRUPTED", folder.path("."))
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            let start = Instant::now();
            while !folder.path("ready").exists() && start.elapsed() < Duration::from_secs(30) {
                std::thread::sleep(Duration::from_millis(5));
            }
            let begun = folder.names(".");
            let kill = format!("kill -{signal} {}", child.id());
            assert!(
                Command::new("sh")
                    .args(["-c", &kill])
                    .status()
                    .unwrap()
                    .success()
            );
            let status = child.wait().unwrap();
            assert_eq!(
                begun.len(),
                3,
                "the folder, the temporary file and the mark: {begun:?}"
            );
            assert_eq!(status.code(), Some(130));
            assert_eq!(folder.names("."), ["ready"]);
        }
    }
}
