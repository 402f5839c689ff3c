//! What a good data set gives.

use std::fmt::Write as _;
use std::path::Path;

use hysteron_host::dataset::{Dataset, LengthUnit, Role, Zero};
use proptest::prelude::*;

use crate::support::Folder;

#[test]
fn units_are_converted_and_roles_kept() {
    let toml = br#"
name = "stage A"
[signals]
time   = { column = "t", unit = "ms" }
input  = { column = "u", unit = "mV", zero = "per-record" }
output = { column = "y", unit = "nm", zero = "per-record" }
[[record]]
file = "fit/x.csv"
role = "fit"
[[record]]
file = "x.csv"
role = "report"
"#;
    let mut csv = String::from("\u{feff}# measured\r\n y ,extra, t,u\r\n");
    for row in 0..10 {
        write!(
            csv,
            "{}, text,{}, {}\r\n",
            62.5 * f64::from(row),
            1000.5 + 0.25 * f64::from(row),
            -1500
        )
        .unwrap();
    }
    let files: [(&str, &[u8]); 3] = [
        ("dataset.toml", toml),
        ("fit/x.csv", csv.as_bytes()),
        ("x.csv", csv.as_bytes()),
    ];
    let folder = Folder::new(&files);
    let dataset = Dataset::load(folder.path("")).unwrap();
    assert_eq!(dataset, Dataset::load(folder.path("dataset.toml")).unwrap());
    assert_eq!(dataset.name, "stage A");
    assert_eq!(dataset.output_unit, LengthUnit::Nanometre);
    assert_eq!(
        (dataset.zero, dataset.input_zero),
        (Zero::PerRecord, Zero::PerRecord)
    );
    let names: Vec<_> = dataset
        .records
        .iter()
        .map(|record| record.name.as_str())
        .collect();
    // Equal stems: the files as listed.
    assert_eq!(names, ["fit/x.csv", "x.csv"]);
    assert_eq!(dataset.with_role(Role::Report).count(), 1);
    assert_eq!(dataset.with_role(Role::Select).count(), 0);

    let record = &dataset.records[0];
    assert_eq!(record.role, Role::Fit);
    assert_eq!(record.continues, None);
    assert_eq!(record.start_s, 1.0005);
    assert!((record.sample_time_s - 0.000_25).abs() < 1e-15);
    assert_eq!(record.time_s[9], 1.002_75);
    assert_eq!(record.drive_v, [-1.5; 10]);
    assert_eq!(record.displacement_um[3], 0.1875);
}

#[test]
fn a_csv_alone_is_three_records_that_continue_each_other() {
    let mut csv = String::from("T_ms,Input_V,Position_mm\n");
    for row in 0..50 {
        writeln!(csv, "{row},{},{}", 2 * row, f64::from(row) * 0.125).unwrap();
    }
    let folder = Folder::new(&[("scan 1.csv", csv.as_bytes())]);
    let dataset = Dataset::load(folder.path("scan 1.csv")).unwrap();
    assert_eq!(dataset.name, "scan 1");
    assert_eq!(dataset.output_unit, LengthUnit::Millimetre);
    assert_eq!(
        (dataset.zero, dataset.input_zero),
        (Zero::Shared, Zero::Shared)
    );
    let shape: Vec<_> = dataset
        .records
        .iter()
        .map(|record| {
            (
                record.name.as_str(),
                record.role,
                record.drive_v.len(),
                record.continues,
            )
        })
        .collect();
    assert_eq!(
        shape,
        [
            ("scan 1 (fit)", Role::Fit, 30, None),
            ("scan 1 (select)", Role::Select, 10, Some(0)),
            ("scan 1 (report)", Role::Report, 10, Some(1)),
        ]
    );
    let drive: Vec<_> = dataset
        .records
        .iter()
        .flat_map(|record| &record.drive_v)
        .collect();
    assert!(
        drive
            .iter()
            .enumerate()
            .all(|(row, &&drive)| drive == 2.0 * row as f64)
    );
    assert_eq!(dataset.records[1].start_s, 0.030);
    assert_eq!(dataset.records[2].displacement_um[0], 5000.0);
    for record in &dataset.records {
        assert!((record.sample_time_s - 1e-3).abs() < 1e-15);
        assert_eq!(record.start_s, record.time_s[0]);
    }
}

proptest! {
    /// Rounding the times of a uniform record to the resolution of the file is no reason to refuse it,
    /// as long as that is a small part of the step; the step comes out to within the rounding of the
    /// two ends.
    #[test]
    fn rounded_times_are_uniform(
        rate_hz in 1_000.0_f64..40_000.0,
        start_s in 0.0_f64..1000.0,
        samples in 8_usize..400,
    ) {
        let mut csv = String::from("time_s,input_v,displacement_um\n");
        for row in 0..samples {
            writeln!(csv, "{:.6},0,0", start_s + row as f64 / rate_hz).unwrap();
        }
        let toml = br#"name = "x"
[signals]
time = { column = "time_s", unit = "s" }
input = { column = "input_v", unit = "V" }
output = { column = "displacement_um", unit = "um" }
[[record]]
file = "a.csv"
role = "fit"
"#;
        let folder = Folder::new(&[("dataset.toml", toml), ("a.csv", csv.as_bytes())]);
        let dataset = Dataset::load(folder.path("")).unwrap();
        let error = (dataset.records[0].sample_time_s - 1.0 / rate_hz).abs();
        prop_assert!(error <= 1.01e-6 / (samples - 1) as f64, "{}", error);
    }
}

/// The measured stack, where its folder is given.
#[test]
fn the_measured_stack_loads() {
    let Some(data) = std::env::var_os("HYSTERON_DATA") else {
        eprintln!("SKIPPED the_measured_stack_loads: HYSTERON_DATA is not set");
        return;
    };
    let dataset = Dataset::load(Path::new(&data).join("piezo-stack-1hz")).unwrap();
    assert_eq!(dataset.output_unit, LengthUnit::Micrometre);
    assert_eq!(
        (dataset.zero, dataset.input_zero),
        (Zero::PerRecord, Zero::Shared)
    );
    let shape: Vec<_> = dataset
        .records
        .iter()
        .map(|record| {
            (
                record.name.as_str(),
                record.role,
                record.time_s.len(),
                record.start_s,
            )
        })
        .collect();
    // Lengths are the files' line counts less the header.
    assert_eq!(
        shape,
        [
            ("open_loop_1hz", Role::Fit, 8027, 0.0),
            ("ramp_down", Role::Fit, 4400, 0.0),
            ("ramp_up_down", Role::Select, 6300, 22.0),
            ("ramp_up", Role::Report, 3455, 53.5),
        ]
    );
    for record in &dataset.records {
        assert!(
            (record.sample_time_s - 0.005).abs() < 1e-9,
            "{}",
            record.sample_time_s
        );
    }
    assert_eq!(dataset.records[0].drive_v[..3], [1.8, 1.856_539, 1.913_023]);
    assert_eq!(dataset.records[3].displacement_um[1], -95.828_729);
}
