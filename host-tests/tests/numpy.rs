//! NumPy's files: what NumPy itself wrote (`data/make_numpy.py`) is read, what is written is what NumPy
//! writes, and spoilt bytes end in one line.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::RngSeed;

use hysteron_host::dataset::{Dataset, Record, long};
use hysteron_host::output::AtomicFile;
use hysteron_host::signals::{Quantity, read};

const N: usize = 40;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data/numpy")
        .join(name)
}

fn times() -> Vec<f64> {
    (0..N).map(|k| k as f64 / 512.0).collect()
}

fn drives() -> Vec<f64> {
    (0..N).map(|k| (k * k) as f64 / 8.0 - 3.0).collect()
}

fn lengths() -> Vec<f64> {
    let y = |k: usize| (k % 5) as f64 / 4.0 - k as f64 / 16.0;
    (0..N).map(y).collect()
}

/// A column of all records in a row.
fn joined(dataset: &Dataset, column: impl Fn(&Record) -> &Vec<f64>) -> Vec<f64> {
    let records = dataset.records.iter();
    records.flat_map(|record| column(record).clone()).collect()
}

#[test]
fn one_file_alone() {
    for name in ["named.npz", "plain.npy"] {
        let dataset = Dataset::load(data(name)).unwrap();
        assert_eq!(dataset.records.len(), 3, "{name}");
        assert_eq!(joined(&dataset, |r| &r.time_s), times(), "{name}");
        assert_eq!(joined(&dataset, |r| &r.drive_v), drives(), "{name}");
        assert_eq!(
            joined(&dataset, |r| &r.displacement_um),
            lengths(),
            "{name}"
        );
    }
    let dataset = Dataset::load(data("packed.npz")).unwrap();
    let ms: Vec<f64> = (0..N).map(|k| (2 * k) as f64 / 1000.0).collect();
    let volts: Vec<f64> = (0..N)
        .map(|k| (125.0 * k as f64 - 2000.0) / 1000.0)
        .collect();
    assert_eq!(joined(&dataset, |r| &r.time_s), ms);
    assert_eq!(joined(&dataset, |r| &r.drive_v), volts);
    assert_eq!(joined(&dataset, |r| &r.displacement_um), lengths());
}

fn folder(file: &str, columns: [&str; 3], input_unit: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::copy(data(file), folder.path().join(file)).unwrap();
    let [time, input, output] = columns;
    let text = format!(
        "name = \"numpy\"\n[signals]\ntime = {{ column = \"{time}\", unit = \"s\" }}\n\
         input = {{ column = \"{input}\", unit = \"{input_unit}\" }}\n\
         output = {{ column = \"{output}\", unit = \"um\" }}\n\
         [[record]]\nfile = \"{file}\"\nrole = \"fit\"\n"
    );
    fs::write(folder.path().join("dataset.toml"), text).unwrap();
    folder
}

#[test]
fn columns_named_in_a_description() {
    let described = folder("fields.npy", ["t", "u", "y"], "mV");
    let dataset = Dataset::load(described.path()).unwrap();
    let volts: Vec<f64> = (0..N)
        .map(|k| (125.0 * k as f64 - 2000.0) / 1000.0)
        .collect();
    assert_eq!(dataset.records[0].time_s, times());
    assert_eq!(dataset.records[0].drive_v, volts);
    assert_eq!(dataset.records[0].displacement_um, lengths());

    let described = folder("plain.npy", ["0", "1", "2"], "V");
    let dataset = Dataset::load(described.path()).unwrap();
    assert_eq!(dataset.records[0].drive_v, drives());
}

/// Each refusal in one line: the file, the array, what is wrong and what to do.
#[test]
fn refusals() {
    let said = |file: &str, columns: [&str; 3]| {
        let folder = folder(file, columns, "V");
        let told = Dataset::load(folder.path()).unwrap_err().to_string();
        assert_eq!(told.lines().count(), 1, "{told}");
        assert!(told.contains(file) && told.contains("; "), "{told}");
        told
    };
    let with = |input| said("named.npz", ["time_s", input, "displacement_um"]);
    for (told, wanted) in [
        (with("drive"), "no column \"drive\", found \"time_s\""),
        (with("short"), "holds 39 samples where time_s holds 40"),
        (
            with("plane"),
            "column plane: the array has the shape (2, 3)",
        ),
        (with("scalar"), "the shape ()"),
        (with("phasor"), "the type \"<c16\""),
        (with("note"), "the type \"<U7\""),
        (said("fields.npy", ["t", "label", "y"]), "the type \"|S3\""),
        (said("fields.npy", ["t", "pair", "y"]), "the type \"<f4\""),
        (said("fortran.npy", ["0", "1", "2"]), "Fortran order"),
        (said("lying.npy", ["0", "1", "2"]), "the shape (40,)"),
        (said("objects.npy", ["0", "1", "2"]), "the type \"|O\""),
        (said("plain.npy", ["0", "1", "3"]), "no column \"3\""),
    ] {
        assert!(told.contains(wanted), "{told}");
    }
    let told = read(data("plain.npy"), Quantity::Drive)
        .unwrap_err()
        .to_string();
    assert!(told.contains("3 columns without names"), "{told}");
    let told = Dataset::load(data("drive.npy")).unwrap_err().to_string();
    assert!(told.contains("2 columns without names"), "{told}");
}

/// A number that is none is told with its index, a lost one with the bytes that are missing.
#[test]
fn spoilt_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("drive.npy");
    let whole = fs::read(data("drive.npy")).unwrap();
    let start = whole.len() - 16 * N;
    let told = |bytes: &[u8]| {
        fs::write(&file, bytes).unwrap();
        read(&file, Quantity::Drive).unwrap_err().to_string()
    };
    let mut bytes = whole.clone();
    bytes[start + 16 * 7 + 8..][..8].copy_from_slice(&f64::NAN.to_le_bytes());
    let nan = told(&bytes);
    assert!(
        nan.contains("drive.npy:7: column 1: NaN is not a finite number"),
        "{nan}"
    );
    let cut = told(&whole[..whole.len() - 1]);
    assert!(cut.contains("cut off") && cut.contains("(40, 2)"), "{cut}");
    let more = told(&[&whole[..], &[0]].concat());
    assert!(more.contains("followed by 1 bytes more"), "{more}");
    let text = told(b"time_s,drive_v\n0,0\n");
    assert!(text.contains("not in NumPy's format"), "{text}");

    let packed = fs::read(data("named.npz")).unwrap();
    let file = folder.path().join("named.npz");
    // In the numbers of the drive: only the checksum can tell.
    let at = packed
        .windows(11)
        .position(|w| w == b"drive_v.npy")
        .unwrap()
        + 200;
    let mut bytes = packed.clone();
    bytes[at] ^= 1;
    fs::write(&file, bytes).unwrap();
    let sum = Dataset::load(&file).unwrap_err().to_string();
    assert!(sum.contains("its checksum is wrong"), "{sum}");
    fs::write(&file, &packed[..packed.len() / 2]).unwrap();
    let half = Dataset::load(&file).unwrap_err().to_string();
    assert!(half.contains("not a whole zip archive"), "{half}");
}

/// Byte for byte what `numpy.save` and `numpy.savez` wrote for the same numbers.
#[test]
fn written_as_numpy_writes() {
    let folder = tempfile::tempdir().unwrap();
    let (time, drive) = (times(), drives());
    for name in ["out.npy", "out.npz"] {
        let file = folder.path().join(name);
        let mut out = AtomicFile::create(&file).unwrap();
        out.write_columns(&[("time_s", &time), ("drive_v", &drive)])
            .unwrap();
        out.commit().unwrap();
        let back = read(&file, Quantity::Drive).unwrap();
        assert_eq!((&back.time_s, &back.values), (&time, &drive), "{name}");
    }
    let both = |name: &str| {
        [folder.path().join(name), data(name)].map(|path| fs::File::open(path).unwrap())
    };
    let [ours, theirs] = both("out.npy").map(|file| std::io::read_to_string(bytes(file)).unwrap());
    assert_eq!(ours, theirs);
    let [mut ours, mut theirs] = both("out.npz").map(|file| zip::ZipArchive::new(file).unwrap());
    assert_eq!(ours.len(), theirs.len());
    for index in 0..theirs.len() {
        let (ours, theirs) = (
            ours.by_index(index).unwrap(),
            theirs.by_index(index).unwrap(),
        );
        assert_eq!(ours.name().unwrap(), theirs.name().unwrap());
        let [ours, theirs] =
            [ours, theirs].map(|entry| std::io::read_to_string(bytes(entry)).unwrap());
        assert_eq!(ours, theirs);
    }
}

/// Bytes as hexadecimal text, which a failed comparison shows.
fn bytes(mut from: impl std::io::Read) -> std::io::Cursor<String> {
    let mut all = Vec::new();
    from.read_to_end(&mut all).unwrap();
    std::io::Cursor::new(all.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// The commands: arrays in, arrays out, and the same numbers as from and to CSV.
#[test]
fn through_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let run = |input: &Path, out: &Path| {
        let done = Command::new(env!("CARGO_BIN_EXE_hysteron"))
            .args(["simulate", "--model", "p753", "--input"])
            .arg(input)
            .arg("--out")
            .arg(out)
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        read(out, Quantity::Displacement).unwrap()
    };
    let rows = times().into_iter().zip(drives());
    let rows: String = rows.map(|(t, u)| format!("{t},{u}\n")).collect();
    fs::write(at("drive.csv"), format!("time_s,drive_v\n{rows}")).unwrap();
    let text = run(&at("drive.csv"), &at("y.csv"));
    assert_eq!(run(&data("drive.npy"), &at("y.npz")), text);
    assert_eq!(run(&data("out.npz"), &at("y.npy")), text);
}

/// A long archive, packed, is condensed as a long CSV is.
#[test]
fn long_archives_are_condensed() {
    let folder = tempfile::tempdir().unwrap();
    let rows = 40_000;
    let time: Vec<f64> = (0..rows).map(|k| k as f64 * 1e-4).collect();
    let drive: Vec<f64> = time.iter().map(|t| 30.0 * (6.25 * t).sin()).collect();
    let length: Vec<f64> = drive.iter().map(|u| 0.7 * u).collect();
    let load = |name: &str| {
        let file = folder.path().join(name);
        let mut out = AtomicFile::create(&file).unwrap();
        let columns: [(&str, &[f64]); 3] = [
            ("time_s", &time),
            ("drive_v", &drive),
            ("displacement_um", &length),
        ];
        out.write_columns(&columns).unwrap();
        out.commit().unwrap();
        let loaded = long::load(&file, 10_000, &|_| {}).unwrap();
        let long = loaded.long.unwrap();
        let mut sum = 0.0;
        for whole in long.files() {
            let add = |u, y| {
                sum += u - y;
                Ok(())
            };
            whole.each(&|_| {}, add).unwrap();
        }
        (loaded.dataset.records, sum)
    };
    let text = load("long.csv");
    assert_eq!(load("long.npz"), text);
    assert_eq!(load("long.npy"), text);
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 600,
        rng_seed: RngSeed::Fixed(11),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// Spoilt bytes give samples that are finite and of one length, or one line.
    #[test]
    fn spoilt_bytes(
        which in 0..4usize,
        changes in prop::collection::vec((any::<Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<Index>()),
        head in any::<bool>(),
    ) {
        let name = ["named.npz", "packed.npz", "fields.npy", "plain.npy"][which];
        let mut bytes = fs::read(data(name)).unwrap();
        for (at, byte) in changes {
            // Half of them where the headers are.
            let within = if head { bytes.len().min(200) } else { bytes.len() };
            let at = at.index(within);
            bytes[at] = byte;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(name);
        fs::write(&file, bytes).unwrap();
        match Dataset::load(&file) {
            Ok(dataset) => for record in &dataset.records {
                prop_assert_eq!(record.time_s.len(), record.drive_v.len());
                let columns = record.drive_v.iter().chain(&record.displacement_um);
                prop_assert!(columns.chain(&record.time_s).all(|x| x.is_finite()));
            },
            Err(told) => prop_assert_eq!(told.to_string().lines().count(), 1),
        }
    }
}
