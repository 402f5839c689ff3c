//! Linking for the target; nothing to do for a host.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// What every memory map is checked for.
const CHECKS: &str = "src/board/checks.x";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let Some(memory) = memory_map()? else {
        return Ok(());
    };
    for (from, to) in [
        (memory.as_path(), "memory.x"),
        (Path::new(CHECKS), "checks.x"),
    ] {
        fs::copy(from, out.join(to))?;
        println!("cargo:rerun-if-changed={}", from.display());
    }
    println!("cargo:rustc-link-search={}", out.display());
    for argument in ["--nmagic", "-Tlink.x", "-Tchecks.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    if env::var_os("CARGO_FEATURE_BENCH_BOARD").is_some() {
        println!("cargo:rustc-link-arg-bin=cycles=-Tdefmt.x");
    }
    if env::var_os("CARGO_FEATURE_BENCH").is_some() {
        compare_with_c(&out)?;
    }
    Ok(())
}

/// The memory map of the part whose feature is on: `memory.x` in the folder of its name.
fn memory_map() -> Result<Option<PathBuf>, Box<dyn Error>> {
    let mut chosen = None;
    for entry in fs::read_dir("src/board")? {
        let entry = entry?;
        let feature = entry.file_name().to_string_lossy().to_uppercase();
        if env::var_os(format!("CARGO_FEATURE_{feature}")).is_some()
            && chosen.replace(entry.path().join("memory.x")).is_some()
        {
            return Err("one part at a time: features board, board-h743, qemu".into());
        }
    }
    Ok(chosen)
}

/// Compiles the C that the benchmark compares with; it is linked into nothing else.
fn compare_with_c(out: &Path) -> Result<(), Box<dyn Error>> {
    let source = "benches-c/inverse.c";
    println!("cargo:rerun-if-changed={source}");
    let object = out.join("inverse.o");
    let status = Command::new("arm-none-eabi-gcc")
        .args(["-std=c11", "-O3", "-mcpu=cortex-m4", "-mthumb"])
        .args(["-mfpu=fpv4-sp-d16", "-mfloat-abi=hard", "-ffreestanding"])
        .args(["-Wall", "-Wextra", "-Werror", "-c", source, "-o"])
        .arg(&object)
        .status()
        .map_err(|error| format!("arm-none-eabi-gcc: {error}; the bench feature needs it"))?;
    if !status.success() {
        return Err(format!("arm-none-eabi-gcc refused {source}").into());
    }
    println!("cargo:rustc-link-arg-bin=bench={}", object.display());
    Ok(())
}
