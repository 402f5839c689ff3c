//! `hysteron pil` on the firmware in its emulator.

use std::path::{Path, PathBuf};
use std::process::Command;

use hysteron_host::pil::sizes;
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
    assert!(per_tick("max") <= 470, "{}", per_tick("max"));

    let [text, data, bss] = binutils(&firmware());
    assert_eq!(json["flash_bytes"], text + data);
    let static_ram = data + bss;
    let ram = json["ram_bytes"].as_u64().unwrap();
    assert_eq!(sizes(&firmware()).unwrap().ram_bytes, static_ram);
    assert!(ram > static_ram && ram <= 24 * 1024, "{ram}");

    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("agree bit for bit") && !page.contains("class=\"verdict bad\""));
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
