//! Console blocks of a text: every command must end well and print the lines that stand under it, words
//! as they stand and numbers within a tolerance.

use std::env;
use std::path::Path;
use std::process::Command;

/// Relative difference allowed to a printed number: the last digits differ from machine to machine.
const TOLERANCE: f64 = 0.02;

/// A command of a console block and the lines under it; `...` among them stands for any lines.
#[derive(Debug, Default, PartialEq)]
pub struct Shown {
    /// What is typed, without its comment.
    pub command: String,
    /// What is printed; nothing where the text does not show it.
    pub lines: Vec<String>,
}

/// The commands of all console blocks, in order; comments are cut off.
pub fn commands(text: &str) -> Vec<Shown> {
    let blocks = text.split("```console\n").skip(1);
    let mut found: Vec<Shown> = Vec::new();
    for block in blocks {
        let block = block.split("\n```").next().unwrap();
        let mut first = true;
        for line in block.lines() {
            if let Some(command) = line.strip_prefix("$ ") {
                found.push(Shown {
                    command: command.split("  #").next().unwrap().trim().to_owned(),
                    lines: Vec::new(),
                });
            } else {
                assert!(!first, "a block begins with output: {line}");
                found.last_mut().unwrap().lines.push(line.to_owned());
            }
            first = false;
        }
    }
    found
}

/// The number that a word stands for, in any of the printed forms, with the punctuation around it.
fn number(word: &str) -> Option<f64> {
    let bare = word.trim_matches(|c: char| "(),;:%".contains(c));
    let bare = bare.strip_suffix('.').unwrap_or(bare).replace('−', "-");
    bare.parse().ok()
}

fn same_word(stated: &str, printed: &str) -> bool {
    match (number(stated), number(printed)) {
        (Some(a), Some(b)) => {
            // One unit of the last digit, where few digits are printed.
            let decimals = stated.split_once('.').map_or(0, |(_, part)| {
                part.chars().take_while(char::is_ascii_digit).count()
            });
            let unit = if stated.contains('e') {
                0.0
            } else {
                0.1_f64.powi(decimals as i32)
            };
            (a - b).abs() <= (TOLERANCE * a.abs()).max(1.001 * unit)
        }
        _ => stated == printed,
    }
}

fn same_line(stated: &str, printed: &str) -> bool {
    let (a, b): (Vec<_>, Vec<_>) = (
        stated.split_whitespace().collect(),
        printed.split_whitespace().collect(),
    );
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| same_word(a, b))
}

/// Whether `printed` is what `stated` says, from the first line to the last.
fn same_output(stated: &[String], printed: &[&str]) -> bool {
    match (stated, printed) {
        ([], []) => true,
        ([dots, rest @ ..], _) if dots == "..." => {
            (0..=printed.len()).any(|skipped| same_output(rest, &printed[skipped..]))
        }
        ([line, rest @ ..], [other, others @ ..]) => {
            same_line(line, other) && same_output(rest, others)
        }
        _ => false,
    }
}

/// Runs a command as a shell would, `cargo run --release` with the program of this test; `Err` says what
/// differs from what is stated.
pub fn run(shown: &Shown, folder: &Path) -> Result<(), String> {
    let program = Path::new(env!("CARGO_BIN_EXE_hysteron"));
    let command = shown
        .command
        .replacen("cargo run --release --", "hysteron", 1)
        .replacen("cargo run --release", "hysteron", 1);
    let name = command.split_whitespace().next().unwrap_or_default();
    if !["hysteron", "awk"].contains(&name) {
        return Err(format!("a command that this test does not know: {command}"));
    }
    let path = env::var_os("PATH").unwrap_or_default();
    let folders = [program.parent().unwrap().to_owned()];
    let path = env::join_paths(folders.into_iter().chain(env::split_paths(&path))).unwrap();
    let done = Command::new("sh")
        .args(["-c", &command])
        .env("PATH", path)
        .current_dir(folder)
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&done.stdout);
    if !done.status.success() {
        let error = String::from_utf8_lossy(&done.stderr);
        return Err(format!("{command}\n{}\n{error}", done.status));
    }
    let lines: Vec<&str> = printed.lines().collect();
    // A command alone says nothing about what it prints.
    if shown.lines.is_empty() || same_output(&shown.lines, &lines) {
        return Ok(());
    }
    Err(format!(
        "{command}\nprints\n{printed}\nand is said to print\n{}",
        shown.lines.join("\n")
    ))
}

/// What is said to a text that is not true.
#[test]
fn an_untrue_block_is_found_out() {
    let folder = tempfile::tempdir().unwrap();
    let verdict = |block: &str| {
        let all = commands(&format!("text\n```console\n{block}\n```\nmore\n"));
        all.iter().try_for_each(|shown| run(shown, folder.path()))
    };
    let hide = "$ hysteron hide --effect creep --seed 1 --out out/hidden  # a comment";
    let says = "32 records, 48519 samples; written to out/hidden: data, truth.toml";
    let block = |says: &str| format!("{hide}\n{says}");
    assert_eq!(verdict(&block(says)), Ok(()));
    assert_eq!(verdict(&block("...")), Ok(()));
    for untrue in [
        says.replace("32 records", "34 records"),
        says.replace("out/hidden:", "out/shown:"),
        format!("{says}\nand more"),
        format!("...\n{says} too"),
        String::from("..\n"),
    ] {
        let difference = verdict(&block(&untrue)).expect_err(&untrue);
        assert!(difference.contains("is said to print"), "{difference}");
    }
    for wrong in [
        "$ hysteron hide --effect crep --out out/none",
        "$ hysteron diagnose out/nothing --out out/none",
        "$ rm report.html",
    ] {
        verdict(wrong).expect_err(wrong);
    }
    assert!(same_line(
        "rms 0.217 before, 0.008 after",
        "rms 0.218 before, 0.009 after"
    ));
    assert!(!same_line(
        "rms 0.217 before, 0.008 after",
        "rms 0.224 before, 0.008 after"
    ));
    assert!(!same_line("beta = 8.3911e-4 s", "beta = 8.6e-4 s"));
}
