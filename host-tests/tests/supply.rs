//! What the project is built from, held against `deny.toml`: licences, doubled versions and sources of
//! the host and of the target, without the network and without cargo-deny.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// A crate that is built in: name, version, licences, and where it is from if not the registry.
struct Crate {
    name: String,
    version: String,
    licence: String,
    path: Option<String>,
}

/// The crates of all features on the machine of the tests and on the target.
fn crates() -> Vec<Crate> {
    let told = Command::new("rustc").arg("-vV").output().unwrap();
    let told = String::from_utf8(told.stdout).unwrap();
    let host = told.lines().find_map(|line| line.strip_prefix("host: "));
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--locked", "--workspace", "--all-features"])
        .args([
            "--target",
            host.unwrap(),
            "--target",
            "thumbv7em-none-eabihf",
        ])
        .args(["--prefix", "none", "--no-dedupe", "--format", "{p}|{l}"])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let lines: BTreeSet<String> = String::from_utf8(output.stdout)
        .unwrap()
        .lines()
        .filter(|line| line.contains('|'))
        .map(|line| line.replace(" (proc-macro)", ""))
        .collect();
    assert!(lines.len() > 100, "{}", lines.len());
    lines
        .iter()
        .map(|line| {
            let (package, licence) = line.split_once('|').unwrap();
            let mut words = package.splitn(3, ' ');
            Crate {
                name: words.next().unwrap().to_owned(),
                version: words.next().unwrap()[1..].to_owned(),
                licence: licence.to_owned(),
                path: words.next().map(str::to_owned),
            }
        })
        .collect()
}

fn deny() -> toml::Table {
    let text = fs::read_to_string(root().join("deny.toml")).unwrap();
    text.parse().unwrap()
}

fn strings(list: &toml::Value) -> Vec<&str> {
    list.as_array()
        .unwrap()
        .iter()
        .map(|s| s.as_str().unwrap())
        .collect()
}

#[test]
fn licences_are_allowed() {
    let deny = deny();
    let allowed: Vec<spdx::Licensee> = strings(&deny["licenses"]["allow"])
        .into_iter()
        .map(|licence| spdx::Licensee::parse(licence).unwrap())
        .collect();
    let mut exceptions = BTreeMap::new();
    for exception in deny["licenses"]["exceptions"].as_array().unwrap() {
        exceptions.insert(
            exception["crate"].as_str().unwrap(),
            strings(&exception["allow"]),
        );
    }
    for Crate { name, licence, .. } in crates() {
        let text = spdx::Expression::parse_mode(&licence, spdx::ParseMode::LAX);
        let text = text.unwrap_or_else(|_| panic!("{name} is under {licence}"));
        let more = exceptions.get(name.as_str()).into_iter().flatten();
        let more: Vec<_> = more.map(|l| spdx::Licensee::parse(l).unwrap()).collect();
        let either = || allowed.iter().chain(&more);
        let good = text.evaluate(|wanted| either().any(|licence| licence.satisfies(wanted)));
        assert!(good, "{name} is under {licence}");
    }
}

#[test]
fn every_crate_is_there_once_and_from_the_registry() {
    let deny = deny();
    let skipped: BTreeSet<(&str, &str)> = deny["bans"]["skip"]
        .as_array()
        .unwrap()
        .iter()
        .map(|entry| entry["crate"].as_str().unwrap().split_once('@').unwrap())
        .collect();
    let mut versions: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for Crate {
        name,
        version,
        path,
        ..
    } in crates()
    {
        if let Some(path) = path {
            assert!(name.starts_with("hysteron"), "{name} is from {path}");
        }
        if !skipped.contains(&(name.as_str(), version.as_str())) {
            versions.entry(name).or_default().push(version);
        }
    }
    versions.retain(|_, versions| versions.len() > 1);
    assert!(versions.is_empty(), "{versions:?}");
}
