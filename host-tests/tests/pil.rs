//! `hysteron pil` on the firmware in its emulator.

mod browser;
mod page_figures;

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use hysteron::hysteresis::preview::PlantRate;
use hysteron_host::link::model::Choice;
use hysteron_host::model_file::{AmplifierLag, Hysteresis, ModelFile, Saturation, Stage};
use hysteron_host::pil::{Comparison, Hardware, Plant, compare, sizes};
use serde_json::Value;

fn firmware() -> PathBuf {
    std::env::var_os("HYSTERON_FIRMWARE")
        .expect("HYSTERON_FIRMWARE names the ELF; scripts/check-firmware.sh builds and runs")
        .into()
}

/// The columns of binutils' size: text, data, bss.
fn binutils(elf: &Path) -> [u64; 3] {
    let output = Command::new("arm-none-eabi-size")
        .arg(elf)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let mut numbers = text.lines().nth(1).unwrap().split_whitespace();
    std::array::from_fn(|_| numbers.next().unwrap().parse().unwrap())
}

/// At port 0 the system chooses: what is printed has to lead there.
#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn a_served_bench_tells_its_address_in_json() {
    let hysteron = || Command::new(env!("CARGO_BIN_EXE_hysteron"));
    let mut bench = hysteron()
        .args(["pil", "--serve", "tcp:127.0.0.1:0", "--json", "--firmware"])
        .arg(firmware())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    let mut said = BufReader::new(bench.stdout.take().unwrap());
    said.read_line(&mut line).unwrap();
    let told: Value = serde_json::from_str(&line).unwrap();
    let address = told["address"].as_str().unwrap();
    assert!(!address.ends_with(":0"), "{address}");
    let info = hysteron()
        .args(["link", "--port", address, "info"])
        .output()
        .unwrap();
    let interrupt = Command::new("kill")
        .args(["-INT", &bench.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupt.success() && bench.wait().unwrap().success());
    let text = String::from_utf8_lossy(&info.stdout);
    assert!(info.status.success() && text.contains("16 plays"), "{text}");
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn the_firmware_follows_paper_j_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("pil");
    let output = Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(["pil", "--firmware"])
        .arg(firmware())
        .arg("--out")
        .arg(&out)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    print!("{}", String::from_utf8_lossy(&output.stdout));

    let text = std::fs::read_to_string(out.join("pil.json")).unwrap();
    let json: Value = serde_json::from_str(&text).unwrap();
    let mut keys: Vec<_> = json
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    keys.sort_unstable();
    let expected = [
        "bit_exact",
        "error_um",
        "flash_bytes",
        "instructions_per_tick",
        "ram_bytes",
        "samples",
    ];
    assert_eq!(keys, expected);
    assert_eq!(json["bit_exact"], true);
    assert!(json["samples"].as_u64().unwrap() > 50_000);

    // The paper measured 5.9 to 10.6 um without its compensator and 1.0 to 2.0 um with it.
    for (name, errors) in json["error_um"].as_object().unwrap() {
        let (without, with) = (
            errors["without"].as_f64().unwrap(),
            errors["with"].as_f64().unwrap(),
        );
        assert!(
            (4.0..16.0).contains(&without),
            "{name}: {without} um without"
        );
        assert!(with < 0.5 * without && with < 5.0, "{name}: {with} um with");
    }
    let per_tick = |which: &str| json["instructions_per_tick"][which].as_u64().unwrap();
    assert!(per_tick("min") <= per_tick("median") && per_tick("median") <= per_tick("max"));
    assert!(per_tick("max") <= 520, "{}", per_tick("max"));

    let [text, data, bss] = binutils(&firmware());
    assert_eq!(json["flash_bytes"], text + data);
    let static_ram = data + bss;
    let ram = json["ram_bytes"].as_u64().unwrap();
    assert_eq!(sizes(&firmware()).unwrap().ram_bytes, static_ram);
    assert!(ram > static_ram && ram <= 48 * 1024, "{ram}");

    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("agree bit for bit") && !page.contains("class=\"verdict bad\""));
    browser::assert_renders(&page, &json);
}

#[test]
fn what_is_missing_is_told_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str], path: Option<&str>| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hysteron"));
        command.arg("pil").args(arguments).current_dir(&folder);
        if let Some(path) = path {
            command.env("PATH", path);
        }
        let output = command.output().unwrap();
        assert_eq!(output.status.code(), Some(2));
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(said.lines().count(), 1, "{said}");
        said
    };
    // Not in the project's folder, no such file, no ELF.
    assert!(run(&[], None).contains("--firmware"));
    assert!(run(&["--firmware", "none"], None).contains("none: cannot read"));
    std::fs::write(
        folder.path().join("text"),
        "no ELF at all, but long enough to have a header",
    )
    .unwrap();
    assert!(run(&["--firmware", "text"], None).contains("not an ELF"));
    // No emulator: this test's own program is an ELF as well.
    let own = env!("CARGO_BIN_EXE_hysteron");
    if cfg!(target_os = "linux") {
        assert!(run(&["--firmware", own], Some("")).contains("apt-get install qemu-system-arm"));
    }
    assert!(!folder.path().join("out").exists());
}

/// A stage of the baseline's hysteresis behind an amplifier that lags, in steps of its own: the lag by
/// its equation, twenty to a sample.
fn lagging(tau_s: f64) -> Plant {
    let (mut before, mut lagged, mut play) = (0.0, 0.0, 0.0f64);
    Box::new(move |drive_v| {
        for i in 1..=20 {
            let target = before + (drive_v - before) * f64::from(i) / 20.0;
            lagged += (target - lagged) * (1.0 - (-1e-4 / 20.0 / tau_s).exp());
        }
        before = drive_v;
        play = lagged - (lagged - play).clamp(-8.0, 8.0);
        Ok(0.8 * lagged + 0.3 * play)
    })
}

/// The hysteresis of [`lagging`], and the same behind its lag, in an amplifier that saturates elsewhere.
fn models() -> [ModelFile; 2] {
    let hysteresis = Stage::Hysteresis(Hysteresis {
        thresholds_v: vec![8.0],
        weights: vec![0.8, 0.3],
        beta_s: 0.0,
    });
    let saturation = Stage::Saturation(Saturation { limit_v: 90.0 });
    let lag = Stage::AmplifierLag(AmplifierLag { tau_s: 4e-4 });
    [
        ModelFile::new("hysteresis", vec![hysteresis.clone()]),
        ModelFile::new("with its lag", vec![saturation, lag, hysteresis]),
    ]
}

/// 30 Hz at 10 kHz with an amplitude of 30 um, from rest, in um.
fn reference() -> Vec<f64> {
    (0..4_000)
        .map(|k| {
            let t = f64::from(k) * 1e-4;
            30.0 * (t * 20.0).min(1.0).powi(2) * (std::f64::consts::TAU * 30.0 * t).sin()
        })
        .collect()
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn an_extended_model_beats_the_baseline_on_a_stage_with_the_hidden_effect() {
    let [baseline, extended] = models();
    let reference = reference();
    let compared = compare(
        &firmware(),
        &Comparison {
            name: "amplifier lag",
            baseline: (&baseline, Choice::Explicit),
            extended: (&extended, Choice::Cascade(PlantRate::Midpoint)),
            hardware: Hardware::paper_j().unwrap(),
            reference_um: &reference,
            skipped: 500,
        },
        &|| Ok(lagging(4e-4)),
    )
    .unwrap();
    let json = compared.to_json();
    println!("{json:#}");
    assert_eq!(json["bit_exact"], true);
    assert!(json["samples"].as_u64().unwrap() > 8_000);
    let rms = |which: &str| json[which]["error_um"]["rms"].as_f64().unwrap();
    // 0.4 ms of 30 Hz and 30 um: 1.6 um rms. The sensor's code is 29 nm.
    assert!((1.2..2.0).contains(&rms("baseline")), "{}", rms("baseline"));
    assert!(rms("extended") < 0.05, "{}", rms("extended"));
    assert_eq!(json["baseline"]["latency_samples"], 0);
    assert_eq!(json["extended"]["latency_samples"], 2);
}

#[test]
#[ignore = "needs QEMU and the firmware: scripts/check-firmware.sh"]
fn two_models_side_by_side_get_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let [baseline, extended] = models();
    std::fs::write(path("a.toml"), baseline.to_toml_string()).unwrap();
    std::fs::write(path("b.toml"), extended.to_toml_string()).unwrap();
    let mut rows = "time_s,reference_um\n".to_owned();
    for (k, v) in reference().iter().enumerate() {
        rows += &format!("{:.4},{v}\n", k as f64 * 1e-4);
    }
    std::fs::write(path("reference.csv"), rows).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_hysteron"))
        .args(["pil", "--model", "a.toml", "--extended", "b.toml"])
        .args(["--reference", "reference.csv", "--out", "out", "--firmware"])
        .arg(firmware())
        .current_dir(&folder)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("saturation of model \"with its lag\" left out"));
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(told.contains("pil.json, report.html"), "{told}");

    let text = std::fs::read_to_string(path("out/pil.json")).unwrap();
    let json: Value = serde_json::from_str(&text).unwrap();
    let page = std::fs::read_to_string(path("out/report.html")).unwrap();
    page_figures::assert_equal_json(&page, &json, 5);
    browser::assert_renders(&page, &json);
    assert_eq!(json["extended"]["left_out"][0], "saturation");
    assert_eq!(json["extended"]["inverse"], "cascade");
    // 0.4 ms of 30 Hz and 30 um: 1.6 um rms.
    let rms = |which: &str| json[which]["error_um"]["rms"].as_f64().unwrap();
    assert!((1.2..2.0).contains(&rms("baseline")), "{}", rms("baseline"));
    assert!(rms("extended") < 0.05, "{}", rms("extended"));
    assert!(page.contains("class=\"verdict good\"") && page.contains("agree bit for bit"));
    // Displacements and the reference, then both errors.
    for title in ["Displacement", "Error"] {
        assert!(page.contains(&format!(">{title}<")), "{title}");
    }
    assert!(page.contains("Left out of the extended model") && page.contains("saturation."));
}
