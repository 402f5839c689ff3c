//! The fuzzers' targets on a fixed draw of inputs: their seeds, each as it is and spoilt.

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{RngSeed, TestRunner};

#[path = "../../fuzz/targets/csv.rs"]
mod csv;
#[path = "../../fuzz/targets/link.rs"]
mod link;
#[path = "../../fuzz/targets/numpy.rs"]
mod numpy;
#[path = "../../fuzz/targets/toml.rs"]
mod toml;

fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../fuzz/seeds");
    let mut files: Vec<PathBuf> = fs::read_dir(folder.join(target))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort();
    assert!(files.len() >= 4, "{files:?}");
    files.iter().map(|file| fs::read(file).unwrap()).collect()
}

/// One way to spoil an input.
#[derive(Clone, Debug)]
enum Spoil {
    Set(Index, u8),
    Cut(Index),
    Remove(Index),
    Repeat(Index, u8),
    Append(Vec<u8>),
}

impl Spoil {
    fn apply(&self, bytes: &mut Vec<u8>) {
        match self {
            Self::Append(more) => bytes.extend(more),
            _ if bytes.is_empty() => {}
            Self::Set(at, byte) => {
                let at = at.index(bytes.len());
                bytes[at] = *byte;
            }
            Self::Cut(at) => bytes.truncate(at.index(bytes.len())),
            Self::Remove(at) => {
                bytes.remove(at.index(bytes.len()));
            }
            Self::Repeat(at, count) => {
                let at = at.index(bytes.len());
                let piece = bytes[at..].to_vec();
                for _ in 0..count % 4 {
                    bytes.extend(&piece);
                }
            }
        }
    }
}

fn spoil() -> impl Strategy<Value = Spoil> {
    prop_oneof![
        4 => (any::<Index>(), any::<u8>()).prop_map(|(at, byte)| Spoil::Set(at, byte)),
        1 => any::<Index>().prop_map(Spoil::Cut),
        2 => any::<Index>().prop_map(Spoil::Remove),
        1 => (any::<Index>(), any::<u8>()).prop_map(|(at, count)| Spoil::Repeat(at, count)),
        2 => prop::collection::vec(any::<u8>(), 1..60).prop_map(Spoil::Append),
    ]
}

fn all(target: &str, cases: u32, run: impl Fn(&[u8])) {
    let seeds = seeds(target);
    seeds.iter().for_each(|seed| run(seed));
    run(b"");
    let config = ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let inputs = (
        prop::sample::select(seeds),
        prop::collection::vec(spoil(), 1..6),
    );
    let drawn = TestRunner::new(config).run(&inputs, |(mut bytes, spoils)| {
        spoils.iter().for_each(|spoil| spoil.apply(&mut bytes));
        run(&bytes);
        Ok(())
    });
    if let Err(found) = drawn {
        panic!("{found}");
    }
}

#[test]
fn link_frames_and_state_machine() {
    all("link", 20_000, |script| {
        link::run(script);
    });
}

#[test]
fn csv_files() {
    let folder = tempfile::tempdir().unwrap();
    all("csv", 6_000, |bytes| csv::run(folder.path(), bytes));
}

/// A header may say that there are more numbers than any memory holds.
#[test]
fn numpy_files() {
    let folder = tempfile::tempdir().unwrap();
    all("numpy", 6_000, |bytes| numpy::run(folder.path(), bytes));
    #[cfg(target_os = "linux")]
    {
        let status = fs::read_to_string("/proc/self/status").unwrap();
        let peak = status.lines().find_map(|line| line.strip_prefix("VmPeak:"));
        let kib: u64 = peak
            .and_then(|peak| peak.split_whitespace().next()?.parse().ok())
            .unwrap();
        // The threads of the other tests reserve some of it.
        assert!(kib < 1 << 20, "{kib} KiB");
    }
}

#[test]
fn toml_files() {
    let folder = tempfile::tempdir().unwrap();
    all("toml", 6_000, |bytes| toml::run(folder.path(), bytes));
}
