//! Exported code, compiled as a user would and run over a drive and a reference, against the core.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use hysteron::hysteresis::Parameters;
use hysteron_host::export::{Language, Options, Precision, export};
use hysteron_host::model_file::{self, ModelFile, Stage};
use hysteron_host::stage;

const SAMPLE_RATE_HZ: f64 = 10_000.0;
const SAMPLES: usize = 4000;

const C_MAIN: &str = "#include <stdio.h>
#include \"stage.h\"
int main(void) {
    double u, r;
    stage_state model, inverse, both;
    if (scanf(\"%lf %lf\", &u, &r) != 2) return 1;
    stage_model_start(&model, (REAL)u);
    stage_inverse_start(&inverse, (REAL)r);
    both = inverse;
    stage_model_start(&both, stage_inverse_step(&both, (REAL)r));
    do {
        const REAL drive = stage_inverse_step(&inverse, (REAL)r);
        printf(\"%.17g %.17g %.17g\\n\", (double)stage_model_step(&model, (REAL)u),
               (double)drive, (double)stage_model_step(&both, drive));
    } while (scanf(\"%lf %lf\", &u, &r) == 2);
    return 0;
}
";

const RUST_MAIN: &str = "use std::io::Read;
fn main() {
    let mut text = String::new();
    std::io::stdin().read_to_string(&mut text).unwrap();
    let mut states = None;
    for line in text.lines() {
        let (u, r) = line.split_once(' ').unwrap();
        let (u, r) = (u.parse::<f64>().unwrap() as REAL, r.parse::<f64>().unwrap() as REAL);
        let (model, inverse, both) = states.get_or_insert_with(|| {
            let mut first = stage::Inverse::start(r);
            let both = stage::Model::start(first.step(r));
            (stage::Model::start(u), stage::Inverse::start(r), both)
        });
        let drive = inverse.step(r);
        println!(\"{:?} {:?} {:?}\", model.step(u) as f64, drive as f64, both.step(drive) as f64);
    }
}
";

/// Displacement, drive for the reference, and displacement for that drive.
#[derive(Debug, PartialEq)]
struct Outputs {
    model: Vec<f64>,
    inverse: Vec<f64>,
    both: Vec<f64>,
}

/// A drive in V with minor loops of falling size, and the share of it that serves as a reference.
fn drive(amplitude: f64) -> Vec<f64> {
    let at = |k: usize| {
        let t = k as f64 / SAMPLE_RATE_HZ;
        let slow = (31.0 * t + 0.3).sin() * (1.0 - 0.5 * k as f64 / SAMPLES as f64);
        amplitude * (0.8 * slow + 0.2 * (420.0 * t).sin())
    };
    (0..SAMPLES).map(at).collect()
}

fn run(program: &Path, input: &str) -> Outputs {
    let mut child = Command::new(program)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let text = input.to_owned();
    let writer = std::thread::spawn(move || stdin.write_all(text.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let column = |index: usize| {
        let cell = |line: &str| line.split(' ').nth(index).unwrap().parse().unwrap();
        text.lines().map(cell).collect::<Vec<f64>>()
    };
    Outputs {
        model: column(0),
        inverse: column(1),
        both: column(2),
    }
}

fn compile(command: &mut Command) {
    let output = command.output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && told.is_empty(), "{told}");
}

fn options(language: Language, precision: Precision) -> Options {
    Options {
        language,
        sample_time_s: 1.0 / SAMPLE_RATE_HZ,
        precision,
        prefix: "stage".to_owned(),
        as_constants: Vec::new(),
    }
}

/// Compiles what is exported, every warning an error.
fn build(folder: &Path, file: &ModelFile, language: Language, precision: Precision) -> PathBuf {
    let code = export(file, &options(language, precision)).unwrap();
    let at = |name: &str| folder.join(name);
    match language {
        Language::C => {
            let real = match precision {
                Precision::Single => "float",
                Precision::Double => "double",
            };
            fs::write(at("stage.h"), code).unwrap();
            fs::write(at("main.c"), C_MAIN.replace("REAL", real)).unwrap();
            let flags = [
                "-std=c99",
                "-pedantic",
                "-Wall",
                "-Wextra",
                "-Werror",
                "-O2",
            ];
            compile(
                Command::new("gcc")
                    .args(flags)
                    .args(["main.c", "-o", "program"])
                    .current_dir(folder),
            );
        }
        Language::Rust => {
            let real = match precision {
                Precision::Single => "f32",
                Precision::Double => "f64",
            };
            fs::write(at("stage.rs"), code).unwrap();
            let library = "#![no_std]\n#![forbid(unsafe_code)]\nmod stage;\npub use stage::{Inverse, Model};\n";
            fs::write(at("lib.rs"), library).unwrap();
            fs::write(at("main.rs"), RUST_MAIN.replace("REAL", real)).unwrap();
            let rustc = || {
                let mut rustc = Command::new("rustc");
                let flags = ["--edition", "2024", "-D", "warnings", "-O"];
                rustc.args(flags).current_dir(folder);
                rustc
            };
            compile(rustc().args(["--crate-type", "rlib", "--crate-name", "stage", "lib.rs"]));
            compile(rustc().args([
                "--extern",
                "stage=libstage.rlib",
                "main.rs",
                "-o",
                "program",
            ]));
        }
    }
    at("program")
}

/// What the core makes of the same drive and reference in double precision.
fn core(file: &ModelFile, drive: &[f64], reference: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let h = 1.0 / SAMPLE_RATE_HZ;
    let chain = stage::chain(file, h).unwrap();
    let mut state = chain.start(drive[0]);
    let model = drive.iter().map(|&u| chain.step(&mut state, u)).collect();
    let cascade = Box::new(stage::Cascade::new(&chain, None).unwrap());
    let mut state = Box::new(cascade.start(reference[0]).unwrap());
    let inverse = reference
        .iter()
        .map(|&r| cascade.step(&mut state, r).unwrap())
        .collect();
    (model, inverse)
}

/// The largest difference, over the largest number.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    let size = b.iter().fold(0.0, |most: f64, b| most.max(b.abs()));
    off.fold(0.0, f64::max) / size
}

fn parsed(stages: &str) -> ModelFile {
    let head = "format = \"hysteron-model\"\nversion = 1\nname = \"test\"\n[units]\ntime = \"s\"\n\
                drive = \"V\"\ndisplacement = \"um\"\n";
    model_file::parse(&format!("{head}{stages}"), Path::new("test.toml")).unwrap()
}

/// Seven plays, every stage that is written as code, a gain that falls.
fn with_maps() -> ModelFile {
    parsed(
        "[[stage]]\nname = \"saturation\"\nlimit_v = 33.0\n\
         [[stage]]\nname = \"hysteresis\"\nthresholds_v = [1.0, 2.5, 4.0, 6.0, 9.0, 12.0, 16.0]\n\
         weights = [0.6, 0.1, 0.05, 0.08, 0.02, 0.07, 0.03, 0.05]\nbeta_s = 3e-4\n\
         [[stage]]\nname = \"asymmetry\"\n\
         thresholds = { positive = [5.0, 12.0], negative = [7.0] }\n\
         slopes = { positive = [1.0, 0.1, -0.2], negative = [0.9, 0.15] }\n\
         [[stage]]\nname = \"quadratic\"\nq = 0.004\n\
         [[stage]]\nname = \"cubic\"\nc = -2e-5\n\
         [[stage]]\nname = \"output-quadratic\"\nq = -0.003\n\
         [[stage]]\nname = \"output\"\ngain_um_per_v = -0.31\noffset_um = 4.0\n",
    )
}

/// Curvatures so strong that the drive leads onto their tangents, behind an asymmetry with an empty list.
fn with_tangents() -> ModelFile {
    parsed(
        "[[stage]]\nname = \"hysteresis\"\nthresholds_v = [3.0, 8.0]\nweights = [0.7, 0.2, 0.1]\n\
         beta_s = 2e-4\n\
         [[stage]]\nname = \"asymmetry\"\nthresholds = { positive = [], negative = [7.0] }\n\
         slopes = { positive = [1.0], negative = [0.9, 0.15] }\n\
         [[stage]]\nname = \"quadratic\"\nq = 0.02\n\
         [[stage]]\nname = \"cubic\"\nc = -1e-3\n",
    )
}

/// Twelve plays, which the core sums in another order, and a curvature without a tangent.
fn with_many_plays() -> ModelFile {
    let list = |of: fn(usize) -> f64, count| {
        let numbers: Vec<_> = (0..count).map(|i| format!("{:?}", of(i))).collect();
        numbers.join(", ")
    };
    parsed(&format!(
        "[[stage]]\nname = \"hysteresis\"\nthresholds_v = [{}]\nweights = [{}]\nbeta_s = 0.0\n\
         [[stage]]\nname = \"cubic\"\nc = 1e-4\n",
        list(|i| 2.0 * (i + 1) as f64, 12),
        list(|i| if i == 0 { 0.5 } else { 0.05 / i as f64 }, 13),
    ))
}

#[test]
fn double_precision_is_the_core() {
    // In units of the rounding of the largest output: twelve plays are summed in another order, and
    // curvatures undone by other steps.
    for (name, file, model_ulps, inverse_ulps) in [
        ("p753", model_file::builtin("p753").unwrap(), 0.0, 0.0),
        ("maps", with_maps(), 0.0, 8.0),
        ("plays", with_many_plays(), 8.0, 8.0),
        ("tangents", with_tangents(), 0.0, 8.0),
    ] {
        let u = drive(40.0);
        let (model, _) = core(&file, &u, &u);
        let reference: Vec<f64> = model.iter().map(|y| 0.7 * y).collect();
        let (model, inverse) = core(&file, &u, &reference);
        let input = u
            .iter()
            .zip(&reference)
            .fold(String::new(), |mut text, (u, r)| {
                writeln!(text, "{u:?} {r:?}").unwrap();
                text
            });
        let folder = tempfile::tempdir().unwrap();
        let [c, rust] = [Language::C, Language::Rust].map(|language| {
            run(
                &build(folder.path(), &file, language, Precision::Double),
                &input,
            )
        });
        assert_eq!(c, rust, "{name}");
        let (model_off, inverse_off) = (apart(&c.model, &model), apart(&c.inverse, &inverse));
        println!(
            "{name}: {model_off:e} {inverse_off:e} {:e}",
            apart(&c.both, &reference)
        );
        assert!(
            model_off <= model_ulps * f64::EPSILON,
            "{name}: {model_off:e}"
        );
        let most = inverse_ulps * f64::EPSILON;
        assert!(inverse_off <= most, "{name}: {inverse_off:e}");
    }
}

/// The same numbers as with the sample before in its place, through every map and the limit.
#[test]
fn a_sample_that_is_not_finite_is_the_one_before() {
    let file = with_maps();
    let folder = tempfile::tempdir().unwrap();
    let good = drive(40.0);
    let held = |k: usize| if k % 50 == 17 { good[k - 1] } else { good[k] };
    let bad = |k: usize| match k % 150 {
        17 => f64::NAN,
        67 => f64::INFINITY,
        117 => f64::NEG_INFINITY,
        _ => good[k],
    };
    let input = |of: &dyn Fn(usize) -> f64| {
        let lines = (0..good.len()).map(|k| format!("{:?} {:?}\n", of(k), 0.7 * of(k)));
        lines.collect::<String>()
    };
    for language in [Language::C, Language::Rust] {
        let program = build(folder.path(), &file, language, Precision::Double);
        let [held, bad] = [run(&program, &input(&held)), run(&program, &input(&bad))];
        assert_eq!(held.model, bad.model, "{language:?}");
        assert_eq!(held.inverse, bad.inverse, "{language:?}");
    }
}

/// Without a rate term model and inverse undo each other: no word of the core in it.
#[test]
fn the_inverse_undoes_the_model() {
    for (name, file) in [
        (
            "p753",
            model_file::builtin("p753").unwrap().rate_independent(),
        ),
        ("maps", with_maps().rate_independent()),
        ("plays", with_many_plays()),
        ("tangents", with_tangents().rate_independent()),
    ] {
        let (low, high) = (-25.0, 25.0);
        let reference: Vec<f64> = drive(1.0)
            .iter()
            .map(|u| 0.5 * (low + high) + 0.5 * (high - low) * u * 0.8)
            .map(|w| file.output().1 + file.output().0 * w)
            .collect();
        let input: String = reference.iter().map(|r| format!("0 {r:?}\n")).collect();
        let folder = tempfile::tempdir().unwrap();
        for (precision, bound) in [(Precision::Double, 2e-15), (Precision::Single, 1e-6)] {
            let program = build(folder.path(), &file, Language::C, precision);
            let off = apart(&run(&program, &input).both, &reference);
            println!("{name} {precision:?}: {off:e}");
            assert!(off < bound, "{name} {precision:?}: {off:e}");
        }
    }
}

#[test]
fn single_precision() {
    let file = model_file::builtin("p753").unwrap();
    let hysteresis = file.hysteresis().unwrap();
    let single = |list: &[f64]| list.iter().map(|&x| x as f32).collect::<Vec<_>>();
    let (weights, thresholds) = (
        single(&hysteresis.weights),
        single(&hysteresis.thresholds_v),
    );
    let operator = Parameters {
        weights: &weights,
        thresholds: &thresholds,
        beta: hysteresis.beta_s as f32,
    }
    .build::<4>(1e-4)
    .unwrap();
    let u = drive(40.0);
    let mut state = operator.start(u[0] as f32);
    let in_single: Vec<f64> = u
        .iter()
        .map(|&u| operator.step(&mut state, u as f32).into())
        .collect();
    let (in_double, drive_double) = core(&file, &u, &u);
    let input: String = u.iter().map(|u| format!("{u:?} {u:?}\n")).collect();
    let folder = tempfile::tempdir().unwrap();
    let [c, rust] = [Language::C, Language::Rust].map(|language| {
        run(
            &build(folder.path(), &file, language, Precision::Single),
            &input,
        )
    });
    assert_eq!(c, rust);
    let off = [
        apart(&c.model, &in_single),
        apart(&c.model, &in_double),
        apart(&c.inverse, &drive_double),
    ];
    println!("{off:?}");
    assert!(off[0] <= f64::from(f32::EPSILON), "{off:?}");
    assert!(off[1] < 4e-7 && off[2] < 4e-7, "{off:?}");
}

#[test]
fn what_is_not_written_is_refused_by_name() {
    let creep =
        "[[stage]]\nname = \"creep\"\ngain_per_decade = 0.02\ntau_min_s = 0.1\ntau_max_s = 10.0\n";
    let stage = "[[stage]]\nname = \"hysteresis\"\nthresholds_v = [1.0]\nweights = [0.6, 0.1]\nbeta_s = 0.0\n";
    let creeping = parsed(&format!("{stage}{creep}"));
    let mut options = options(Language::C, Precision::Single);
    let told = export(&creeping, &options).unwrap_err().to_string();
    assert!(
        told.contains("no code is written for creep; --as-constants creep"),
        "{told}"
    );
    options.as_constants = vec!["creep".to_owned()];
    let text = export(&creeping, &options).unwrap();
    assert!(
        text.contains("#define STAGE_CREEP_GAIN_PER_DECADE (0.02f)"),
        "{text}"
    );
    assert!(
        text.contains("Not computed, numbers alone: creep."),
        "{text}"
    );
    options.as_constants = vec!["resonance".to_owned()];
    let told = export(&creeping, &options).unwrap_err().to_string();
    assert!(told.contains("no stage resonance"), "{told}");

    options.as_constants.clear();
    let law = parsed(&format!(
        "{stage}[[stage]]\nname = \"rate-law\"\nexponent = 0.5\n"
    ));
    let told = export(&law, &options).unwrap_err().to_string();
    assert!(
        told.contains("stage rate-law changes what the hysteresis"),
        "{told}"
    );
    // An array of no entries, which C forbids, is never written: there is no such operator.
    let no_plays = parsed(
        "[[stage]]\nname = \"hysteresis\"\nthresholds_v = []\nweights = [0.8]\nbeta_s = 0.0\n",
    );
    for language in [Language::C, Language::Rust] {
        options.language = language;
        let told = export(&no_plays, &options).unwrap_err().to_string();
        assert!(told.contains("thresholds_v: wrong number"), "{told}");
    }
    options.prefix = "7up".to_owned();
    let told = export(&parsed(stage), &options).unwrap_err().to_string();
    assert!(told.contains("\"7up\" is no prefix"), "{told}");
    let mut tiny = parsed(stage);
    let Stage::Hysteresis(hysteresis) = &mut tiny.stages[0] else {
        panic!("{tiny:?}");
    };
    hysteresis.beta_s = 1e-50;
    options.prefix = "stage".to_owned();
    let told = export(&tiny, &options).unwrap_err().to_string();
    assert!(told.contains("use --precision double"), "{told}");
}

/// A name cannot end the comment that it stands in.
#[test]
fn names_stay_in_their_comment() {
    let mut file = model_file::builtin("p753").unwrap();
    file.name = "*/ #error \\\n//! ??/ \u{202e}x".to_owned();
    let folder = tempfile::tempdir().unwrap();
    for language in [Language::C, Language::Rust] {
        build(folder.path(), &file, language, Precision::Single);
    }
}

#[test]
fn the_command() {
    let folder = tempfile::tempdir().unwrap();
    for (format, name, wanted) in [
        ("c", "stage.h", "static inline float hysteron_inverse_step("),
        (
            "rust",
            "stage.rs",
            "pub const THRESHOLDS_V: [f32; 3] = [9.715, 19.43, 29.145];",
        ),
    ] {
        let done = Command::new(env!("CARGO_BIN_EXE_hysteron"))
            .args(["export", "--model", "p753", "--format", format])
            .args(["--sample-rate", "10000", "--out", name])
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        let text = fs::read_to_string(folder.path().join(name)).unwrap();
        assert!(text.contains(wanted), "{text}");
    }
    let refused = Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args([
            "export",
            "--model",
            "p753",
            "--format",
            "c",
            "--sample-rate",
            "0",
        ])
        .args(["--out", "no.h"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert!(!folder.path().join("no.h").exists());
}
