//! Signals read and written.

use hysteron_host::error::Place;
use hysteron_host::signals::{self, Quantity};
use proptest::prelude::*;

use crate::support::Folder;

fn refused(csv: &str, quantity: Quantity) -> String {
    let folder = Folder::new(&[("in.csv", csv.as_bytes())]);
    folder.message(&signals::read(folder.path("in.csv"), quantity).unwrap_err())
}

#[test]
fn units_come_from_the_column_names() {
    let folder = Folder::new(&[
        ("drive.csv", b"note,drive_mv,time_us\nx,1500,0\ny,-250,50\n"),
        (
            "reference.csv",
            b"time_s,reference_nm,drive_v\n1,62.5,0\n1.5,125,0\n2,0,0\n",
        ),
        (
            "displacement.csv",
            b"time_ms,displacement_m\n0,1e-6\n1,2e-6",
        ),
    ]);
    let read = |name: &str, quantity| signals::read(folder.path(name), quantity).unwrap();
    let drive = read("drive.csv", Quantity::Drive);
    assert_eq!(
        (drive.sample_time_s, drive.values),
        (50e-6, vec![1.5, -0.25])
    );
    let reference = read("reference.csv", Quantity::Reference);
    assert_eq!(reference.time_s, [1.0, 1.5, 2.0]);
    assert_eq!(
        (reference.sample_time_s, reference.values),
        (0.5, vec![0.0625, 0.125, 0.0])
    );
    let displacement = read("displacement.csv", Quantity::Displacement);
    assert_eq!(
        (displacement.sample_time_s, displacement.values),
        (0.001, vec![1.0, 2.0])
    );
}

#[test]
fn refusals() {
    let cases = [
        (
            "time_s,volts\n0,0\n1,0\n",
            Quantity::Drive,
            "in.csv:1: no column drive_v or drive_mv, found \"time_s\", \"volts\"; rename or add the column",
        ),
        (
            "seconds,drive_v\n0,0\n1,0\n",
            Quantity::Drive,
            "in.csv:1: no column time_s, time_ms or time_us, found \"seconds\", \"drive_v\"; rename or add the column",
        ),
        (
            "time_s,drive_v,drive_mv\n0,0,0\n1,0,0\n",
            Quantity::Drive,
            "in.csv:1: columns drive_v and drive_mv both hold the drive; keep one",
        ),
        (
            "time_s,drive_v\n0,0\n1,0\n",
            Quantity::Reference,
            "in.csv:1: no column reference_um, reference_nm, reference_mm or reference_m, found \"time_s\", \"drive_v\"; rename or add the column",
        ),
        (
            "time_s,drive_v\n0,0\n",
            Quantity::Drive,
            "in.csv: fewer than two samples under the column names; the sample time cannot be told, add rows",
        ),
        (
            "time_s,drive_v\n0,0\n1,NaN\n",
            Quantity::Drive,
            "in.csv:3: column drive_v: \"NaN\" is not a finite number; remove or repair the row",
        ),
        (
            "time_s,reference_m\n0,0\n1,1e305\n",
            Quantity::Reference,
            "in.csv:3: column reference_m: \"1e305\" is not a finite number; remove or repair the row",
        ),
        (
            "time_s,drive_v\n0,0\n1,0\n3,0\n4,0\n",
            Quantity::Drive,
            "in.csv:4: column time_s: the time steps by 2 s here and by 1 s elsewhere; the samples must be uniform: split the record at the gap or resample it",
        ),
    ];
    for (csv, quantity, message) in cases {
        assert_eq!(refused(csv, quantity), message);
    }
    let folder = Folder::new(&[]);
    let message = |name: &str| {
        folder.message(&signals::read(folder.path(name), Quantity::Drive).unwrap_err())
    };
    assert_eq!(
        message("none.csv"),
        "none.csv: cannot read: No such file or directory (os error 2); check the path and its permissions"
    );
    assert_eq!(
        message("."),
        ".: is a folder; name a CSV, .npz or .npy file"
    );
}

#[test]
fn unwritable_columns_write_nothing() {
    let mut written = Vec::new();
    let mut message = |columns: &[signals::Column<'_>]| {
        signals::write(&mut written, &Place::file("out.csv"), columns)
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        message(&[("time_s", &[0.0, 1.0]), ("drive_v", &[1.0])]),
        "out.csv: column drive_v: 1 numbers where \"time_s\" has 2; nothing is written"
    );
    assert_eq!(
        message(&[("time_s", &[0.0, 1.0]), ("drive_v", &[1.0, f64::NAN])]),
        "out.csv: column drive_v: sample 1 came out as NaN; nothing is written"
    );
    assert!(written.is_empty());
}

#[test]
fn the_written_form_is_plain() {
    let mut written = Vec::new();
    let columns: [signals::Column<'_>; 2] = [
        ("time_s", &[0.0, 1e-4, 0.1]),
        ("drive_v", &[-0.0, 1e300, 5e-324]),
    ];
    signals::write(&mut written, &Place::file("out.csv"), &columns).unwrap();
    assert_eq!(
        String::from_utf8(written).unwrap(),
        "time_s,drive_v\n0.0,-0.0\n0.0001,1e+300\n0.1,5e-324\n"
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told() {
    let full = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let columns: [signals::Column<'_>; 1] = [("time_s", &[0.0])];
    let error = signals::write(full, &Place::file("out.csv"), &columns).unwrap_err();
    assert_eq!(
        error.to_string(),
        "out.csv: cannot write: No space left on device (os error 28); free some space or write elsewhere"
    );
}

proptest! {
    /// Every finite number, subnormal ones and the sign of zero included, comes back bit for bit.
    #[test]
    fn a_round_trip_is_exact(
        values in prop::collection::vec(
            any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |value| value.is_finite()),
            2..50,
        ),
        step in 1e-7_f64..10.0,
    ) {
        let times: Vec<_> = (0..values.len()).map(|row| row as f64 * step).collect();
        let folder = Folder::new(&[]);
        let path = folder.path("out.csv");
        let mut file = hysteron_host::output::AtomicFile::create(&path).unwrap();
        file.write_columns(&[("drive_v", &values), ("time_s", &times)]).unwrap();
        file.commit().unwrap();
        let signal = signals::read(&path, Quantity::Drive).unwrap();
        let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
        prop_assert_eq!(bits(&signal.values), bits(&values));
        prop_assert_eq!(bits(&signal.time_s), bits(&times));
    }
}
