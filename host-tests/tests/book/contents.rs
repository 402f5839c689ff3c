//! The contents of the book, and links between the pages of the project.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;

use crate::golden::root;

/// The pages of docs/, by name.
fn pages() -> BTreeSet<String> {
    let entries = fs::read_dir(root("docs")).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    names.filter(|name| name.ends_with(".md")).collect()
}

/// A page without what stands in fenced blocks.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let lines = text.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Targets of the links of a page, pictures included.
fn links(text: &str) -> Vec<String> {
    let prose = prose(text);
    let targets = prose
        .split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')'));
    let local = targets
        .map(|(target, _)| target)
        .filter(|target| !target.contains("://"));
    local.map(str::to_owned).collect()
}

/// The anchors that GitHub gives to the headings of a page: small letters, digits, `-` and `_`, blanks as
/// `-`, and a number behind what comes again.
fn anchors(text: &str) -> BTreeSet<String> {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    let prose = prose(text);
    let headings = prose.lines().filter(|line| {
        let level = line.bytes().take_while(|&byte| byte == b'#').count();
        (1..=6).contains(&level) && line[level..].starts_with(' ')
    });
    let slugs = headings.map(|heading| {
        let title = heading.trim_start_matches('#').trim();
        // Of a link only its words stand in the heading.
        let title = title
            .split("](")
            .map(|part| part.split_once(')').map_or(part, |(_, rest)| rest));
        let title: String = title.collect();
        let kept = title
            .to_lowercase()
            .chars()
            .filter_map(|c| match c {
                ' ' => Some('-'),
                c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
                _ => None,
            })
            .collect::<String>();
        let times = seen.entry(kept.clone()).or_default();
        *times += 1;
        if *times == 1 {
            kept
        } else {
            format!("{kept}-{}", *times - 1)
        }
    });
    slugs.collect()
}

#[test]
fn every_page_is_in_the_contents_once() {
    let text = fs::read_to_string(root("docs/README.md")).unwrap();
    let mut listed = links(&text);
    listed.retain(|link| link.ends_with(".md") && !link.contains('/'));
    let once: BTreeSet<String> = listed.iter().cloned().collect();
    assert_eq!(
        once.len(),
        listed.len(),
        "a page stands there twice: {listed:?}"
    );
    let mut pages = pages();
    assert!(pages.remove("README.md"));
    assert!(pages.len() > 15, "{pages:?}");
    assert_eq!(once, pages);
}

/// Of all pages: files that are there, headings that are there.
#[test]
fn links_lead_to_files_and_headings() {
    let mut all: Vec<PathBuf> = pages().iter().map(|name| root("docs").join(name)).collect();
    let others = [
        "README.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "fuzz/README.md",
        "host-tests/data/README.md",
        "docs/golden/README.md",
    ];
    all.extend(others.map(root));
    let (mut files, mut headings) = (0, 0);
    for page in &all {
        let text = fs::read_to_string(page).unwrap();
        for link in links(&text) {
            let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = match path {
                "" => page.clone(),
                path => page.parent().unwrap().join(path),
            };
            let told = || format!("{}: {link}", page.display());
            assert!(target.exists(), "{}", told());
            files += 1;
            if !anchor.is_empty() {
                let text = fs::read_to_string(&target).unwrap();
                assert!(anchors(&text).contains(anchor), "{}", told());
                headings += 1;
            }
        }
    }
    assert!(files > 80 && headings > 8, "{files} {headings}");
}

#[test]
fn anchors_are_those_of_github() {
    let text = "# `diagnosis.json`\n\n## What is it?\n\n```sh\n# no heading\n```\n## What is it?\n### A [link](x.md), an under_score\n";
    let expected = [
        "a-link-an-under_score",
        "diagnosisjson",
        "what-is-it",
        "what-is-it-1",
    ];
    assert_eq!(anchors(text), expected.map(str::to_owned).into());
    assert_eq!(
        links("[a](b.md#c) `x](y)`\n```\n[d](e)\n```\n"),
        ["b.md#c", "y"]
    );
}
