//! Every refusal of a data set, as the exact line that the user sees.

use std::fmt::Write as _;

use hysteron_host::dataset::Dataset;

use crate::support::Folder;

pub const TOML: &str = r#"name = "stage A"
[signals]
time   = { column = "time_s", unit = "s" }
input  = { column = "input_v", unit = "V" }
output = { column = "displacement_um", unit = "um" }
[[record]]
file = "a.csv"
role = "fit"
"#;

const ROWS: &str = "time_s,input_v,displacement_um
0.000,0.0,0.0
0.005,0.1,0.2
0.010,0.2,0.4
0.015,0.3,0.6
0.020,0.4,0.8
0.025,0.5,1.0
0.030,0.6,1.2
0.035,0.7,1.4
";

/// The message for a description and the one CSV it lists.
pub fn refused(toml: &str, csv: impl AsRef<[u8]>) -> String {
    let folder = Folder::new(&[("dataset.toml", toml.as_bytes()), ("a.csv", csv.as_ref())]);
    folder.message(&Dataset::load(folder.path("")).unwrap_err())
}

/// The good data set with one piece of the CSV replaced.
fn csv_case(from: &str, to: &str) -> String {
    assert_eq!(
        ROWS.matches(from).count(),
        1,
        "{from:?} must stand in the rows once"
    );
    refused(TOML, ROWS.replace(from, to))
}

/// The good data set with one piece of the TOML replaced.
fn toml_case(from: &str, to: &str) -> String {
    assert_eq!(
        TOML.matches(from).count(),
        1,
        "{from:?} must stand in the TOML once"
    );
    refused(&TOML.replace(from, to), ROWS)
}

#[test]
fn the_unchanged_data_set_loads() {
    let folder = Folder::new(&[
        ("dataset.toml", TOML.as_bytes()),
        ("a.csv", ROWS.as_bytes()),
    ]);
    assert_eq!(
        Dataset::load(folder.path("")).unwrap().records[0]
            .time_s
            .len(),
        8
    );
}

#[test]
fn bad_cells() {
    let cases = [
        (
            "0.2,0.4",
            "nan,0.4",
            "a.csv:4: column input_v: \"nan\" is not a finite number; remove or repair the row",
        ),
        (
            "0.6,1.2",
            "0.6,-inf",
            "a.csv:8: column displacement_um: \"-inf\" is not a finite number; remove or repair the row",
        ),
        (
            "0.6,1.2",
            "0.6,1e999",
            "a.csv:8: column displacement_um: \"1e999\" is not a finite number; remove or repair the row",
        ),
        (
            "0.1,0.2",
            " ,0.2",
            "a.csv:3: column input_v: the cell is empty; remove or repair the row",
        ),
        (
            "0.015",
            "",
            "a.csv:5: column time_s: the cell is empty; remove or repair the row",
        ),
        (
            "0.1,0.2",
            "0.1 V,0.2",
            "a.csv:3: column input_v: \"0.1 V\" is not a number; remove or repair the row",
        ),
        (
            "0.1,0.2",
            "0.1",
            "a.csv:3: the row has 2 cells and the header 3; give every row one number a column, with a decimal point",
        ),
        (
            "0.1,0.2",
            "0,1,0,2",
            "a.csv:3: the row has 5 cells and the header 3; give every row one number a column, with a decimal point",
        ),
        (
            "0.3,0.6",
            "\"0.3,0.6",
            "a.csv:5: a quoted cell runs on past the end of the line; close the quote",
        ),
    ];
    for (from, to, message) in cases {
        assert_eq!(csv_case(from, to), message);
    }
}

#[test]
fn bad_headers() {
    let cases = [
        (
            "input_v",
            "drive",
            "a.csv:1: no column \"input_v\", found \"time_s\", \"drive\", \"displacement_um\"; name a column of the file in dataset.toml",
        ),
        (
            "input_v",
            "time_s",
            "a.csv:1: column time_s is there twice; give every column its own name",
        ),
        (
            "time_s,input_v,displacement_um",
            "time_s;input_v;displacement_um",
            "a.csv:1: no column \"time_s\", found \"time_s;input_v;displacement_um\" (cells must be separated by commas); name a column of the file in dataset.toml",
        ),
        (
            "time_s,input_v,displacement_um\n",
            "",
            "a.csv:1: the first line holds numbers; put a line of column names before it",
        ),
    ];
    for (from, to, message) in cases {
        assert_eq!(csv_case(from, to), message);
    }
}

#[test]
fn bad_times() {
    let cases = [
        (
            "0.020,",
            "0.015,",
            "a.csv:6: column time_s: the time 0.015 s is that of the row before; remove the repeated row",
        ),
        (
            "0.020,",
            "0.012,",
            "a.csv:6: column time_s: the time goes back from 0.015 s to 0.012 s; put the rows in order of time",
        ),
        (
            "0.020,0.4,0.8\n",
            "",
            "a.csv: there are 7 samples under the column names and at least 8 are needed; record more",
        ),
        (
            "0.035,",
            "0.040,",
            "a.csv:9: column time_s: the time steps by 0.01 s here and by 0.005 s elsewhere; the samples must be uniform: split the record at the gap or resample it",
        ),
        (
            "0.035,",
            "0.0355,",
            "a.csv:9: column time_s: the time steps by 0.0055 s here and by 0.00507143 s elsewhere; the samples must be uniform: split the record at the gap or resample it",
        ),
    ];
    for (from, to, message) in cases {
        assert_eq!(csv_case(from, to), message);
    }
}

#[test]
fn a_dropped_sample_is_found_in_a_short_record() {
    let csv = ROWS.replace("0.020,0.4,0.8\n", "# lost\n\n") + "0.040,0.8,1.6\n";
    assert_eq!(
        refused(TOML, csv),
        "a.csv:8: column time_s: the time steps by 0.01 s here and by 0.005 s elsewhere; the \
         samples must be uniform: split the record at the gap or resample it"
    );
}

#[test]
fn a_dropped_sample_is_found_in_a_long_record() {
    let mut csv = String::from("time_s,input_v,displacement_um\n");
    for row in (0..100_000).filter(|&row| row != 70_000) {
        writeln!(csv, "{:.6},0.5,1.5", f64::from(row) * 1e-4).unwrap();
    }
    assert_eq!(
        refused(TOML, csv),
        "a.csv:70002: column time_s: the time steps by 0.0002 s here and by 0.0001 s elsewhere; \
         the samples must be uniform: split the record at the gap or resample it"
    );
}

#[test]
fn a_slow_change_of_the_sample_rate_is_found() {
    // 1 ms for the first half, 1.04 ms for the second: every single step is within tolerance. The
    // kink at row 1000 lies furthest off the line from first to last: 1000 * 0.02 ms.
    let mut csv = String::from("time_s,input_v,displacement_um\n");
    for row in 0..=2000 {
        let time = if row <= 1000 {
            row * 100
        } else {
            100_000 + (row - 1000) * 104
        };
        writeln!(csv, "{:.5},0.5,1.5", f64::from(time) * 1e-5).unwrap();
    }
    assert_eq!(
        refused(TOML, csv),
        "a.csv:1002: column time_s: the time is 0.02 s off a uniform grid of 0.00102 s; the sample \
         rate changes within the record: split it there or resample it"
    );
}

#[test]
fn bad_files() {
    let cases: [(&[u8], &str); 5] = [
        (
            b"",
            "a.csv: the file holds no rows; it needs a line of column names and rows of numbers",
        ),
        (
            b"# only\n\n  \n",
            "a.csv: the file holds no rows; it needs a line of column names and rows of numbers",
        ),
        (
            b"time_s,input_v,displacement_um\n",
            "a.csv: there are no samples under the column names; record the file again or take it out of the data set",
        ),
        (
            b"time_s,input_v,displacement_um\n0,0,0\n",
            "a.csv: there is 1 sample under the column names and at least 8 are needed; record more",
        ),
        (
            b"time_s,input_v,displacement_um\n0,0,\xb5\n",
            "a.csv:2: the row is not UTF-8 text; save the file as UTF-8",
        ),
    ];
    for (csv, message) in cases {
        assert_eq!(refused(TOML, csv), message);
    }
}

#[test]
fn bad_descriptions() {
    let cases = [
        (
            "\"s\" }",
            "\"min\" }",
            "dataset.toml:3: signals.time.unit: unknown variant `min`, expected one of `s`, `ms`, `us`",
        ),
        (
            "\"V\"",
            "\"kV\"",
            "dataset.toml:4: signals.input.unit: unknown variant `kV`, expected `V` or `mV`",
        ),
        (
            "\"um\" }",
            "\"pm\" }",
            "dataset.toml:5: signals.output.unit: unknown variant `pm`, expected one of `um`, `nm`, `mm`, `m`",
        ),
        (
            "\"um\" }",
            "\"um\", zero = \"often\" }",
            "dataset.toml:5: signals.output.zero: unknown variant `often`, expected `shared` or `per-record`",
        ),
        (
            "\"s\" }",
            "\"s\", zero = \"per-record\" }",
            "dataset.toml:3: signals.time: unknown field `zero`, expected `column` or `unit`",
        ),
        (
            "\"fit\"",
            "\"train\"",
            "dataset.toml:8: record[0].role: unknown variant `train`, expected one of `fit`, `select`, `report`",
        ),
        (
            "role = \"fit\"\n",
            "",
            "dataset.toml:6: record[0]: missing field `role`",
        ),
        (
            "role = \"fit\"",
            "roll = \"fit\"",
            "dataset.toml:8: record[0]: unknown field `roll`, expected `file` or `role`",
        ),
        (
            "role = \"fit\"",
            "role = \"select\"",
            "dataset.toml:6: no record has the role \"fit\"; give it to at least one",
        ),
        (
            "name = \"stage A\"",
            "title = \"stage A\"",
            "dataset.toml:1: unknown field `title`, expected one of `name`, `signals`, `record`",
        ),
        (
            "name = \"stage A\"",
            "name = 7",
            "dataset.toml:1: name: invalid type: integer `7`, expected a string",
        ),
        (
            "\"input_v\"",
            "\"time_s\"",
            "dataset.toml:4: signals.input.column: \"time_s\" is the column of time already; name another",
        ),
        (
            "file = \"a.csv\"",
            "file = \"b.csv\"",
            "dataset.toml:7: record[0].file: \"b.csv\" is not there; name a CSV, .npz or .npy file in the data set's folder",
        ),
        (
            "file = \"a.csv\"",
            "file = \"./\"",
            "dataset.toml:7: record[0].file: \"./\" is a folder; name a CSV, .npz or .npy file in the data set's folder",
        ),
        (
            "file = \"a.csv\"",
            "file = \"../a.csv\"",
            "dataset.toml:7: record[0].file: \"../a.csv\" leads out of the data set's folder; put the file into the folder",
        ),
        (
            "file = \"a.csv\"",
            "file = \"x/../../a.csv\"",
            "dataset.toml:7: record[0].file: \"x/../../a.csv\" leads out of the data set's folder; put the file into the folder",
        ),
        (
            "file = \"a.csv\"",
            "file = \"/etc/hostname\"",
            "dataset.toml:7: record[0].file: \"/etc/hostname\" leads out of the data set's folder; put the file into the folder",
        ),
        (
            "role = \"fit\"\n",
            "role = \"fit\"\n[[record]]\nfile = \"./a.csv\"\nrole = \"report\"\n",
            "dataset.toml:10: record[1].file: \"./a.csv\" is the file of record[0] already; list it once",
        ),
        (
            "[signals]",
            "[signals",
            "dataset.toml:2: unclosed table, expected `]`",
        ),
        (
            "[[record]]\nfile = \"a.csv\"\nrole = \"fit\"\n",
            "",
            "dataset.toml:1: missing field `record`",
        ),
    ];
    for (from, to, message) in cases {
        assert_eq!(toml_case(from, to), message);
    }
    assert_eq!(
        refused("record = []\nname = \"none\"\n[signals]\n", ROWS),
        "dataset.toml:3: signals: missing field `time`"
    );
}

#[test]
fn bad_paths() {
    let folder = Folder::new(&[
        ("a.csv", ROWS.as_bytes()),
        ("latin.toml", b"name = 1\n# \xb5m\n"),
    ]);
    let load = |name: &str| folder.message(&Dataset::load(folder.path(name)).unwrap_err());
    assert_eq!(
        load("nowhere"),
        "nowhere: there is no such file or folder; name a folder with a dataset.toml, or one CSV, .npz or .npy file"
    );
    assert_eq!(
        load("."),
        ".: the folder holds no dataset.toml; write one (see docs/dataset.md) or name one CSV, .npz or .npy file"
    );
    assert_eq!(
        load("latin.toml"),
        "latin.toml:2: not UTF-8 text; save the file as UTF-8"
    );
    assert_eq!(
        load("a.csv"),
        "a.csv: there are 8 samples under the column names and at least 40 are needed; record more"
    );
}

#[test]
fn headers_of_a_csv_alone() {
    let load = |header: &str| {
        let folder = Folder::new(&[("a.csv", format!("{header}\n0,0,0\n").as_bytes())]);
        folder.message(&Dataset::load(folder.path("a.csv")).unwrap_err())
    };
    let cases = [
        (
            "time,drive_v,y_um",
            "a.csv:1: no time column, found \"time\", \"drive_v\", \"y_um\"; name it time_s, time_ms or time_us, or write a dataset.toml (see docs/dataset.md)",
        ),
        (
            "t_s,drive_kv,y_um",
            "a.csv:1: no drive column, found \"t_s\", \"drive_kv\", \"y_um\"; name it drive_v or drive_mv, or write a dataset.toml (see docs/dataset.md)",
        ),
        (
            "t_s,drive_v,angle_mrad",
            "a.csv:1: no displacement column, found \"t_s\", \"drive_v\", \"angle_mrad\"; name it displacement_um, displacement_nm, displacement_mm or displacement_m, or write a dataset.toml (see docs/dataset.md)",
        ),
        (
            "t_s,drive_v,y_um,position_nm",
            "a.csv:1: y_um and position_nm could both be the displacement; rename one, or write a dataset.toml (see docs/dataset.md)",
        ),
    ];
    for (header, message) in cases {
        assert_eq!(load(header), message);
    }
}
