//! `simulate` and `compensate` with a model file that holds a modified play model.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

const MODEL: &str = r#"format = "hysteron-model"
version = 1
name = "bimorph at 25 Hz"

[units]
time = "s"
drive = "V"
displacement = "um"

[[stage]]
name = "modified-play"
sample_time_s = 0.0002
u_max_v = 5.0
slopes_um_per_v = [4.0, 0.5, 0.4, 0.3]
offset_um = 0.5
alpha_s = 0.0
beta_s = 0.0
interleaving_per_v = 0.001
feedback = [0.3, 0.1, 0.0]
frequency_hz = 25.0
harmonics = "corrected"
sine = [0.1, 0.01, 0.0]
cosine = [0.0, 0.0, 0.001]
law = "exact"
"#;

fn hysteron(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn compensate(model: &str, folder: &Path) -> Output {
    let arguments = [
        "compensate",
        "--model",
        model,
        "--reference",
        "ref.csv",
        "--out",
        "drive.csv",
    ];
    hysteron(&arguments, folder)
}

/// The second column.
fn values(csv: &str) -> Vec<f64> {
    let numbers = csv.lines().skip(1);
    numbers
        .map(|line| line.split(',').nth(1).unwrap().parse().unwrap())
        .collect()
}

#[test]
fn what_was_compensated_comes_back_in_the_simulation() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("m.toml"), MODEL).unwrap();
    let reference: Vec<f64> = (0..2000)
        .map(|k| 12.0 * (std::f64::consts::TAU * 25.0 * f64::from(k) * 2e-4).sin())
        .collect();
    let csv = |step: f64| {
        let rows = reference.iter().enumerate();
        let rows: String = rows
            .map(|(k, y)| format!("{},{y}\n", k as f64 * step))
            .collect();
        format!("time_s,reference_um\n{rows}")
    };
    fs::write(folder.join("ref.csv"), csv(2e-4)).unwrap();
    let output = compensate("m.toml", folder);
    assert!(output.status.success(), "{output:?}");
    let simulate = [
        "simulate",
        "--model",
        "m.toml",
        "--input",
        "drive.csv",
        "--out",
        "came.csv",
    ];
    let output = hysteron(&simulate, folder);
    assert!(output.status.success(), "{output:?}");
    let came = values(&fs::read_to_string(folder.join("came.csv")).unwrap());
    assert_eq!(came.len(), reference.len());
    for (came, wanted) in came.iter().zip(&reference) {
        assert!((came - wanted).abs() < 1e-9, "{came} {wanted}");
    }

    // The printed law takes the plays one sample late: it follows, but not to rounding.
    fs::write(
        folder.join("printed.toml"),
        MODEL.replace("exact", "printed"),
    )
    .unwrap();
    let drive = values(&fs::read_to_string(folder.join("drive.csv")).unwrap());
    assert!(compensate("printed.toml", folder).status.success());
    let late = values(&fs::read_to_string(folder.join("drive.csv")).unwrap());
    let apart = drive.iter().zip(&late).map(|(a, b)| (a - b).abs());
    let apart = apart.fold(0.0, f64::max);
    assert!((1e-4..0.2).contains(&apart), "{apart}");

    // Refused in one line each: data of another sample time, a map that is not monotone.
    fs::write(
        folder.join("bent.toml"),
        MODEL.replace("0.4, 0.3]", "-4.6, 0.3]"),
    )
    .unwrap();
    let refused = |model: &str, says: &str| {
        let output = compensate(model, folder);
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(
            error.contains(says) && error.lines().count() == 1,
            "{error}"
        );
    };
    refused("bent.toml", "slopes_um_per_v[2]");
    fs::write(folder.join("ref.csv"), csv(1e-4)).unwrap();
    refused("m.toml", "holds for samples 0.0002 s apart");
}
