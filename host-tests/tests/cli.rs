//! The command line as a user meets it: files in, files out, one line and exit code 2 on bad input.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn hysteron(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts")
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(name)
}

/// A seed from the clock is lost with the run, unless the error tells it.
#[test]
fn a_demonstration_that_fails_tells_its_seed() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("out")).unwrap();
    fs::write(folder.path().join("out/data"), "in the way").unwrap();
    let said = |arguments: &[&str]| {
        let done = hysteron(arguments, folder.path());
        assert_eq!(done.status.code(), Some(2));
        String::from_utf8(done.stderr).unwrap()
    };
    let drawn = said(&["demo", "--out", "out"]);
    assert_eq!(drawn.lines().count(), 1, "{drawn}");
    let (_, after) = drawn.split_once("`hysteron demo --seed ").unwrap();
    let seed: u64 = after.split('`').next().unwrap().parse().unwrap();
    assert!(drawn.contains(&format!("the seed drawn was {seed}")));
    let named = said(&["demo", "--seed", "3", "--out", "out"]);
    assert!(
        named.contains("name a folder") && !named.contains("drawn"),
        "{named}"
    );
}

/// The columns of a CSV of numbers, by name.
fn columns(text: &str) -> Vec<(String, Vec<f64>)> {
    let mut lines = text.lines();
    let mut columns: Vec<(String, Vec<f64>)> = lines
        .next()
        .unwrap()
        .split(',')
        .map(|name| (name.to_owned(), Vec::new()))
        .collect();
    for line in lines {
        for ((_, values), field) in columns.iter_mut().zip(line.split(',')) {
            values.push(field.parse().unwrap());
        }
    }
    columns
}

fn column<'a>(columns: &'a [(String, Vec<f64>)], name: &str) -> &'a [f64] {
    &columns.iter().find(|(other, _)| other == name).unwrap().1
}

fn write_csv(path: &Path, names: [&str; 2], time: &[f64], values: &[f64]) {
    let rows = time.iter().zip(values).map(|(t, v)| format!("{t},{v}\n"));
    let text: String = std::iter::once(format!("{},{}\n", names[0], names[1]))
        .chain(rows)
        .collect();
    fs::write(path, text).unwrap();
}

/// `simulate` and `compensate` against the same operators in another language
/// (data/make_fixtures.py), from a first sample of zero and from one far from it.
#[test]
fn operators_agree_with_another_program() {
    let folder = tempfile::tempdir().unwrap();
    for model in ["p753", "example-f"] {
        for start in ["from-zero", "from-35"] {
            let text =
                fs::read_to_string(fixture(&format!("operators/{model}-{start}.csv"))).unwrap();
            let truth = columns(&text);
            let (time, signal) = (column(&truth, "time_s"), column(&truth, "signal"));
            let run = |arguments: &[&str], names: [&str; 2], result: &str, expected: &str| {
                write_csv(&folder.path().join("in.csv"), names, time, signal);
                let output = hysteron(arguments, folder.path());
                assert!(output.status.success(), "{output:?}");
                let written = fs::read_to_string(folder.path().join("out.csv")).unwrap();
                assert!(
                    written.starts_with(&format!("time_s,{result}\n")),
                    "{written}"
                );
                let written = columns(&written);
                assert_eq!(column(&written, "time_s"), time);
                for (value, truth) in column(&written, result)
                    .iter()
                    .zip(column(&truth, expected))
                {
                    assert!(
                        (value - truth).abs() < 1e-9,
                        "{model} {start}: {value} {truth}"
                    );
                }
            };
            run(
                &[
                    "simulate", "--model", model, "--input", "in.csv", "--out", "out.csv",
                ],
                ["time_s", "drive_v"],
                "displacement_um",
                "model",
            );
            let compensate = [
                "compensate",
                "--model",
                model,
                "--reference",
                "in.csv",
                "--out",
                "out.csv",
            ];
            let names = ["time_s", "reference_um"];
            run(&compensate, names, "drive_v", "inverse");
            let rate_independent = [&compensate[..], &["--inverse", "rate-independent"]].concat();
            run(
                &rate_independent,
                names,
                "drive_v",
                "rate_independent_inverse",
            );
        }
    }
}

#[test]
fn identify_writes_a_model_that_the_other_commands_take() {
    let folder = tempfile::tempdir().unwrap();
    let data = fixture("paper-j-loops");
    let output = hysteron(
        &["identify", data.to_str().unwrap(), "--out", "stage"],
        folder.path(),
    );
    assert!(output.status.success(), "{output:?}");
    assert!(
        output.stderr.is_empty(),
        "no progress bar without a terminal: {output:?}"
    );

    let out = folder.path().join("stage");
    let json: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("identification.json")).unwrap())
            .unwrap();
    assert_eq!(json["unit"], "um");
    for key in ["fit", "select", "report"] {
        let rms = json["rms"][key].as_f64().unwrap();
        assert!((0.04..0.06).contains(&rms), "{key}: {rms}");
    }
    assert!(json["noise_floor"].as_f64().unwrap() > 0.0);
    let parameters = &json["parameters"];
    assert_eq!(parameters["thresholds_v"].as_array().unwrap().len(), 3);
    assert_eq!(parameters["weights"].as_array().unwrap().len(), 4);
    assert!(parameters["beta_s"].is_f64() && parameters["gain_um_per_v"].is_f64());

    // The page shows the figures of the JSON.
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    for key in ["fit", "select", "report"] {
        let cell = format!(
            "data-key=\"rms.{key}\" data-value=\"{}\"",
            json["rms"][key].as_f64().unwrap()
        );
        assert!(page.contains(&cell), "{cell}");
    }

    // Compensated and simulated with the identified model, a slow reference comes back.
    let time: Vec<f64> = (0..4000).map(|k| k as f64 * 1e-3).collect();
    let reference: Vec<f64> = time.iter().map(|t| 30.0 * (3.0 * t).sin()).collect();
    write_csv(
        &folder.path().join("ref.csv"),
        ["time_s", "reference_um"],
        &time,
        &reference,
    );
    let model = ["--model", "stage/model.toml"];
    let steps = [
        [
            &["compensate"],
            &model[..],
            &["--reference", "ref.csv", "--out", "drive.csv"],
        ]
        .concat(),
        [
            &["simulate"],
            &model[..],
            &["--input", "drive.csv", "--out", "came.csv"],
        ]
        .concat(),
    ];
    for step in &steps {
        let output = hysteron(step, folder.path());
        assert!(output.status.success(), "{output:?}");
    }
    let came = columns(&fs::read_to_string(folder.path().join("came.csv")).unwrap());
    for (came, wanted) in column(&came, "displacement_um").iter().zip(&reference) {
        assert!((came - wanted).abs() < 0.1, "{came} {wanted}");
    }
}

/// The published stage at a drive that is joined by straight lines and stepped `fine` times finer: a
/// plain loop. Its thresholds widen with the step that led to a sample, or with the one to come.
fn published_stage(drive: &[f64], sample_time: f64, fine: usize, forward: bool) -> Vec<f64> {
    let line = |k: usize| {
        let (whole, part) = (k / fine, (k % fine) as f64 / fine as f64);
        let next = drive[(whole + 1).min(drive.len() - 1)];
        drive[whole] + (next - drive[whole]) * part
    };
    let last = fine * (drive.len() - 1);
    let mut plays = [0.0f64; 3];
    let mut out = Vec::new();
    for k in 0..=last {
        let step = if forward {
            line((k + 1).min(last)) - line(k)
        } else {
            line(k) - line(k.saturating_sub(1))
        };
        let widening = 8.572e-4 * step.abs() * fine as f64 / sample_time;
        for (i, z) in plays.iter_mut().enumerate() {
            let r = 9.715 * (i + 1) as f64 + widening;
            *z = z.min(line(k) + r).max(line(k) - r);
        }
        if k % fine == 0 {
            let weighted = 0.2906 * plays[0] + 0.0416 * plays[1] + 0.1512 * plays[2];
            out.push(0.7236 * line(k) + weighted);
        }
    }
    out
}

#[test]
fn the_preview_inverse_follows_where_the_explicit_one_lags() {
    let folder = tempfile::tempdir().unwrap();
    let time: Vec<f64> = (0..400).map(|k| f64::from(k) * 1e-4).collect();
    let phase = |t: &f64| 200.0 * std::f64::consts::PI * (t + 3e-5);
    let reference: Vec<f64> = time.iter().map(|t| 40.0 * phase(t).sin()).collect();
    let names = ["time_s", "reference_um"];
    write_csv(&folder.path().join("ref.csv"), names, &time, &reference);
    let run = |command: &str, options: &[&str], result: &str| {
        let (model, file) = (["--model", "p753"], ["--out", "out.csv"]);
        let arguments = [&[command], &model[..], &file, options].concat();
        let output = hysteron(&arguments, folder.path());
        assert!(
            output.status.success() && output.stderr.is_empty(),
            "{output:?}"
        );
        let written = columns(&fs::read_to_string(folder.path().join("out.csv")).unwrap());
        assert_eq!(column(&written, "time_s"), time);
        column(&written, result).to_vec()
    };
    // Largest and rms error with the rate of the step to come, and twenty times finer.
    let errors = |options: &[&str]| {
        let input = ["--reference", "ref.csv"];
        let drive = run("compensate", &[&input, options].concat(), "drive_v");
        write_csv(
            &folder.path().join("drive.csv"),
            ["time_s", "drive_v"],
            &time,
            &drive,
        );
        let simulate = |options: &[&str], fine, forward| {
            let options = [&["--input", "drive.csv"], options].concat();
            let came = run("simulate", &options, "displacement_um");
            let truth = published_stage(&drive, 1e-4, fine, forward);
            let (mut largest, mut squares) = (0.0f64, 0.0);
            for (k, (came, truth)) in came.iter().zip(&truth).enumerate() {
                assert!(k == 0 || (came - truth).abs() < 1e-9, "{k}: {came} {truth}");
                if (100..350).contains(&k) {
                    largest = largest.max((came - reference[k]).abs());
                    squares += (came - reference[k]).powi(2);
                }
            }
            (largest, (squares / 250.0).sqrt())
        };
        (
            simulate(&["--rate", "forward"], 1, true),
            simulate(&["--oversample", "20"], 20, false),
        )
    };
    let (forward, fine) = errors(&[]);
    assert!(forward.0 > 2.0 && fine.0 > 2.0, "{forward:?} {fine:?}");
    let (forward, fine) = errors(&["--inverse", "preview"]);
    assert!(
        forward.0 < 0.2 && fine.0 < 0.5 && fine.1 < 0.17,
        "{forward:?} {fine:?}"
    );
    let (forward, _) = errors(&["--inverse", "preview", "--plant-rate", "forward"]);
    assert!(forward.0 < 0.001, "{forward:?}");
    let (_, fine) = errors(&["--inverse", "preview", "--plant-rate", "backward"]);
    assert!(fine.0 < 0.5 && fine.1 < 0.1, "{fine:?}");
}

#[test]
fn bad_input_is_one_line_and_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    let rows: String = (0..10)
        .map(|k| format!("{},{}\n", k as f64 * 1e-3, k))
        .collect();
    write("good.csv", &format!("time_s,drive_v\n{rows}"));
    write("no_column.csv", &format!("time_s,volts\n{rows}"));
    write("nan.csv", "time_s,drive_v\n0,1\n0.001,nan\n0.002,2\n");
    write(
        "uneven.csv",
        "time_s,drive_v\n0,1\n0.001,2\n0.005,3\n0.006,4\n",
    );
    write("empty.csv", "time_s,drive_v\n");
    write(
        "stage.csv",
        &format!(
            "time_s,drive_v,displacement_parsec\n{}",
            rows.replace('\n', ",1\n")
        ),
    );
    write(
        "bad.toml",
        "format = \"hysteron-model\"\nversion = 1\nname = \"m\"\n\
         [units]\ntime = \"s\"\ndrive = \"V\"\ndisplacement = \"um\"\n\
         [[stage]]\nname = \"hysteresis\"\nthresholds_v = [1.0]\nweights = [0.5, -0.6]\nbeta_s = 0.0\n",
    );
    let sharp = "format = \"hysteron-model\"\nversion = 1\nname = \"slow\"\n\
         [units]\ntime = \"s\"\ndrive = \"V\"\ndisplacement = \"um\"\n\
         [[stage]]\nname = \"hysteresis\"\nthresholds_v = [1.0]\nweights = [0.5, 0.6]\nbeta_s = 0.2\n";
    write("slow.toml", sharp);
    write("ref.csv", &format!("time_s,reference_um\n{rows}"));
    let compensate = |model: &str, options: &[&str]| {
        let arguments = [
            "compensate",
            "--model",
            model,
            "--reference",
            "ref.csv",
            "--out",
            "out.csv",
        ];
        let all = arguments.iter().chain(options);
        all.map(|&argument| argument.to_owned()).collect::<Vec<_>>()
    };
    let simulate = |model: &str, input: &str| {
        [
            "simulate", "--model", model, "--input", input, "--out", "out.csv",
        ]
        .map(str::to_owned)
    };
    let identify = |data: &str| {
        ["identify", data, "--out", "out"]
            .map(str::to_owned)
            .to_vec()
    };
    let cases: Vec<(Vec<String>, &str)> = vec![
        (
            simulate("p753", "no_column.csv").to_vec(),
            "no_column.csv:1",
        ),
        (
            simulate("p753", "nan.csv").to_vec(),
            "nan.csv:3: column drive_v",
        ),
        (
            simulate("p753", "uneven.csv").to_vec(),
            "uneven.csv:4: column time_s",
        ),
        (simulate("p753", "empty.csv").to_vec(), "empty.csv"),
        (simulate("p753", "missing.csv").to_vec(), "missing.csv"),
        (
            simulate("p754", "good.csv").to_vec(),
            "p753, p753-printed, example-f",
        ),
        (simulate("bad.toml", "good.csv").to_vec(), "weights[1]"),
        (
            compensate("slow.toml", &["--inverse", "preview"]),
            "samples ahead",
        ),
        (
            compensate("p753", &["--plant-rate", "forward"]),
            "--inverse preview",
        ),
        (identify("stage.csv"), "stage.csv:1"),
        (identify("nowhere"), "nowhere"),
        (identify("good.csv"), "good.csv:1"),
    ];
    for (arguments, place) in cases {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let output = hysteron(&arguments, folder.path());
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(
            error.starts_with("error: ") && error.contains(place),
            "{arguments:?}: {error}"
        );
        assert_eq!(error.lines().count(), 1, "{error}");
        assert!(output.stdout.is_empty());
        assert!(!folder.path().join("out.csv").exists() && !folder.path().join("out").exists());
    }
}

/// A stage with a mode, a lag and curvature: what `cascade` computes brings it back to the reference.
#[test]
fn the_cascade_undoes_every_stage_of_a_model() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let model = "format = \"hysteron-model\"\nversion = 1\nname = \"stage\"\n[units]\ntime = \"s\"\n\
        drive = \"V\"\ndisplacement = \"um\"\n\
        [[stage]]\nname = \"amplifier-lag\"\ntau_s = 0.0002\n\
        [[stage]]\nname = \"hysteresis\"\nthresholds_v = [3.0, 9.0]\nweights = [0.8, 0.1, 0.1]\n\
        beta_s = 1e-4\n\
        [[stage]]\nname = \"quadratic\"\nq = 0.002\n\
        [[stage]]\nname = \"resonance\"\nf_n_hz = 300.0\nzeta = 0.02\n\
        [[stage]]\nname = \"output\"\ngain_um_per_v = 1.5\noffset_um = 0.0\n";
    std::fs::write(path("model.toml"), model).unwrap();
    let reference: Vec<f64> = (0..4_000)
        .map(|k| {
            let t = f64::from(k) / 4_000.0;
            30.0 * (std::f64::consts::PI * t).sin().powi(4) * (60.0 * t).sin()
        })
        .collect();
    let mut text = "time_s,reference_um\n".to_owned();
    for (k, v) in reference.iter().enumerate() {
        text += &format!("{},{v}\n", k as f64 * 1e-4);
    }
    std::fs::write(path("reference.csv"), text).unwrap();
    let hysteron = |arguments: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_hysteron"))
            .current_dir(folder.path())
            .args(arguments)
            .output()
            .unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let mut errors = Vec::new();
    for inverse in ["explicit", "cascade"] {
        let note = hysteron(&[
            "compensate",
            "--model",
            "model.toml",
            "--reference",
            "reference.csv",
            "--out",
            "drive.csv",
            "--inverse",
            inverse,
        ]);
        assert_eq!(note.contains("resonance"), inverse == "explicit", "{note}");
        hysteron(&[
            "simulate",
            "--model",
            "model.toml",
            "--input",
            "drive.csv",
            "--out",
            "out.csv",
        ]);
        let out = std::fs::read_to_string(path("out.csv")).unwrap();
        let displacement: Vec<f64> = out
            .lines()
            .skip(1)
            .map(|line| line.split(',').nth(1).unwrap().parse().unwrap())
            .collect();
        let largest = displacement
            .iter()
            .zip(&reference)
            .map(|(y, v)| (y - v).abs())
            .fold(0.0, f64::max);
        errors.push(largest);
    }
    println!(
        "largest error in um: explicit {}, cascade {}",
        errors[0], errors[1]
    );
    assert!(errors[1] < 0.05 * errors[0], "{errors:?}");
}
