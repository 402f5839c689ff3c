//! Commands that cannot end: Ctrl-C at any moment and a disk that is full leave no half file, what was
//! there before stays, and one line says why.

#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

const PROGRAM: &str = env!("CARGO_BIN_EXE_hysteron");

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(PROGRAM);
    command.args(arguments).current_dir(folder);
    command.output().unwrap()
}

/// Everything below a folder: relative path and content.
fn contents(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            if path.is_dir() {
                all.push((name, Vec::new()));
                open.push(path);
            } else {
                all.push((name, fs::read(path).unwrap()));
            }
        }
    }
    all.sort();
    all
}

/// A data set that takes seconds to be diagnosed, a model, and results of an earlier day.
fn prepared() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let hide = ["hide", "--effect", "creep", "--seed", "3", "--out", "set"];
    let hidden = run(folder.path(), &hide);
    assert!(hidden.status.success(), "{hidden:?}");
    fs::create_dir(folder.path().join("earlier")).unwrap();
    for name in ["model.toml", "report.html", "blind.json", "diagnosis.json"] {
        fs::write(folder.path().join("earlier").join(name), "old").unwrap();
    }
    let drive: String = (0..20_000).map(|k| format!("{k},{}\n", k % 97)).collect();
    let csv = format!("time_ms,drive_v\n{drive}");
    fs::write(folder.path().join("drive.csv"), csv).unwrap();
    folder
}

fn interrupt(child: &mut Child) -> Option<i32> {
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(10) {
        if let Some(status) = child.try_wait().unwrap() {
            return status.code();
        }
        sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    panic!("the program does not end");
}

#[test]
fn ctrl_c_in_the_middle() {
    let folder = prepared();
    let folder = folder.path();
    let before = contents(folder);
    let long: [&[&str]; 3] = [
        &["blind", "--cases", "500"],
        &["diagnose", "set/data", "--bootstrap", "10000"],
        &["identify", "set/data"],
    ];
    for arguments in long {
        for (out, wait_ms) in [("new/deep", 0), ("new/deep", 200), ("earlier", 600)] {
            let mut child = Command::new(PROGRAM)
                .args(arguments)
                .args(["--out", out])
                .current_dir(folder)
                .stdout(Stdio::null())
                .stderr(Stdio::piped())
                .spawn()
                .unwrap();
            let begun = Instant::now();
            while !folder.join(out).exists() && begun.elapsed() < Duration::from_secs(10) {
                sleep(Duration::from_millis(1));
            }
            sleep(Duration::from_millis(wait_ms));
            assert!(child.try_wait().unwrap().is_none(), "{arguments:?} ended");
            assert_eq!(interrupt(&mut child), Some(130), "{arguments:?} {wait_ms}");
            let said = child.wait_with_output().unwrap();
            assert_eq!(
                String::from_utf8_lossy(&said.stderr),
                "error: interrupted; nothing unfinished is left, earlier files are as they were\n"
            );
            assert!(
                contents(folder) == before,
                "{arguments:?} {wait_ms} ms to {out} left something"
            );
        }
    }
}

/// A limit on the size of a file refuses the write that crosses it, as a full disk does.
#[test]
fn a_disk_that_is_full() {
    let folder = prepared();
    let folder = folder.path();
    let before = contents(folder);
    // What is written, in blocks of 512 bytes, and the file that does not fit.
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/paper-j-loops");
    let identify = format!("identify {} --out", data.display());
    let simulate = "simulate --model p753 --input drive.csv --out";
    let cases = [
        (
            format!("{identify} earlier"),
            1,
            "earlier/identification.json",
        ),
        (format!("{identify} new/deep"), 64, "new/deep/report.html"),
        ("hide --effect creep --out new".into(), 200, "new/data"),
        (
            format!("{simulate} earlier/model.toml"),
            300,
            "earlier/model.toml",
        ),
        (format!("{simulate} new/y.csv"), 300, "new/y.csv"),
    ];
    for (arguments, blocks, named) in cases {
        // The signal that comes with the refusal is ignored, as the system sends none for a full disk.
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" {arguments}");
        let output = Command::new("sh")
            .args(["-c", &script, PROGRAM])
            .current_dir(folder)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments}: {said}");
        assert_eq!(said.lines().count(), 1, "{arguments}: {said}");
        assert!(
            said.starts_with(&format!("error: {named}")),
            "{arguments}: {said}"
        );
        assert!(
            said.contains("free some space or write elsewhere"),
            "{said}"
        );
        assert!(
            contents(folder) == before,
            "{arguments} with {blocks} blocks left something"
        );
    }
}

/// The summary may have nowhere to go either: files are written, and a full device is told.
#[cfg(target_os = "linux")]
#[test]
fn a_summary_that_cannot_be_printed() {
    let folder = tempfile::tempdir().unwrap();
    let hide = ["hide", "--effect", "none", "--out", "set"];
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let (reader, closed) = std::io::pipe().unwrap();
    drop(reader);
    for (stdout, code, wanted) in [
        (
            Stdio::from(full),
            2,
            "error: standard output: cannot write: ",
        ),
        (Stdio::from(closed), 0, ""),
    ] {
        let child = Command::new(PROGRAM)
            .args(hide)
            .current_dir(folder.path())
            .stdout(stdout)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert!(said.starts_with(wanted), "{said}");
        assert_eq!(said.lines().count(), usize::from(code > 0), "{said}");
        assert!(folder.path().join("set/truth.toml").is_file());
    }
}
