//! Every command line that the pages or the helps show is one that the program accepts.

use std::fs;
use std::path::Path;

use clap::error::ErrorKind;
use clap::{Command, CommandFactory, Parser};

use super::Arguments;

/// What a page shows: in a block to type as it stands, or in a sentence, where the rest may be left to the
/// reader.
struct Shown {
    command: String,
    in_sentence: bool,
}

/// The command lines of a page.
fn shown(page: &str) -> Vec<Shown> {
    let mut found = Vec::new();
    let (mut fenced, mut prose) = (false, String::new());
    for line in page.lines() {
        if line.starts_with("```") {
            fenced = !fenced;
            continue;
        }
        let typed = if fenced {
            Some(line)
        } else {
            line.strip_prefix("    ")
        };
        match typed.map(|line| line.trim_start_matches("$ ")) {
            Some(line) if line.starts_with("hysteron ") => found.push(Shown {
                // What stands apart is a remark.
                command: line.split("  ").next().unwrap().to_owned(),
                in_sentence: false,
            }),
            Some(_) => {}
            None => prose.extend([line, "\n"]),
        }
    }
    let spans = prose.split('`').skip(1).step_by(2);
    found.extend(
        spans
            .filter(|span| span.starts_with("hysteron "))
            .map(|span| Shown {
                command: span.to_owned(),
                in_sentence: true,
            }),
    );
    found
}

/// As typed, with something in the place of what a reader puts there: a word in capitals is a command, a
/// number or a path.
fn typed(command: &str) -> Vec<String> {
    let command = command.split(" > ").next().unwrap();
    let words = command.split_whitespace();
    let words = words.map(|word| match word.trim_matches(['[', ']']) {
        "COMMAND" => "demo",
        "ACTION" => "info",
        "N" | "S" | "T" => "2",
        other => other,
    });
    words.map(str::to_owned).collect()
}

fn verdict(shown: &Shown) -> Result<(), String> {
    match Arguments::try_parse_from(typed(&shown.command)) {
        Ok(_) => Ok(()),
        Err(error) => match error.kind() {
            ErrorKind::DisplayHelp | ErrorKind::DisplayVersion => Ok(()),
            ErrorKind::MissingRequiredArgument
            | ErrorKind::MissingSubcommand
            | ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
                if shown.in_sentence =>
            {
                Ok(())
            }
            _ => Err(format!("{}\n{error}", shown.command)),
        },
    }
}

#[test]
fn the_pages_show_commands_that_are_accepted() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let docs = fs::read_dir(root.join("docs")).unwrap();
    let mut pages: Vec<_> = docs.map(|entry| entry.unwrap().path()).collect();
    pages.retain(|path| path.extension().is_some_and(|ending| ending == "md"));
    pages.extend(
        ["README.md", "CONTRIBUTING.md", "docs/golden/README.md"].map(|name| root.join(name)),
    );
    let mut seen = 0;
    for page in pages {
        for shown in shown(&fs::read_to_string(&page).unwrap()) {
            if let Err(refused) = verdict(&shown) {
                panic!("{}: {refused}", page.display());
            }
            seen += 1;
        }
    }
    assert!(seen > 50, "{seen}");
}

/// Examples of a command and of those below it.
fn examples(command: &Command, found: &mut Vec<String>) {
    let help = command
        .get_after_help()
        .map(ToString::to_string)
        .unwrap_or_default();
    let lines = help
        .lines()
        .map(str::trim)
        .filter(|line| line.starts_with("hysteron "));
    found.extend(lines.map(str::to_owned));
    for below in command.get_subcommands() {
        examples(below, found);
    }
}

#[test]
fn the_helps_show_commands_that_are_accepted() {
    let mut found = Vec::new();
    examples(&Arguments::command(), &mut found);
    assert!(found.len() > 25, "{found:?}");
    for command in found {
        let shown = Shown {
            command: command.split("  ").next().unwrap().to_owned(),
            in_sentence: false,
        };
        verdict(&shown).unwrap();
    }
}

#[test]
fn a_wrong_command_is_found_out() {
    let page = "Text `hysteron identify` and `hysteron blind --cases N\n--tier T`.\n\n    $ hysteron hide --effect creep --out out/x  # now\n\n```console\n$ hysteron link --port $P settings > a.toml\n```\n";
    let found = shown(page);
    let commands: Vec<&str> = found.iter().map(|one| one.command.as_str()).collect();
    assert_eq!(
        commands,
        [
            "hysteron hide --effect creep --out out/x",
            "hysteron link --port $P settings > a.toml",
            "hysteron identify",
            "hysteron blind --cases N\n--tier T"
        ]
    );
    assert!(found.iter().all(|one| verdict(one).is_ok()));
    for wrong in [
        "hysteron diagnos data --out out/x",
        "hysteron diagnose data --outt out/x",
        "hysteron blind --tier 5 --out out/x",
        "hysteron identify",
        "hysteron compensate --model p753 --reference r.csv --out d.csv --inverse previe",
    ] {
        let shown = Shown {
            command: wrong.to_owned(),
            in_sentence: false,
        };
        assert!(verdict(&shown).is_err(), "{wrong}");
    }
}
