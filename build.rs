//! Linking for the target; nothing to do for a host.

use std::env;
use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    if env::var("CARGO_CFG_TARGET_OS")? != "none" {
        return Ok(());
    }
    let out = PathBuf::from(env::var("OUT_DIR")?);
    fs::copy("memory.x", out.join("memory.x"))?;
    println!("cargo:rerun-if-changed=memory.x");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg-bins=--nmagic");
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    if env::var_os("CARGO_FEATURE_BENCH_BOARD").is_some() {
        println!("cargo:rustc-link-arg-bin=cycles=-Tdefmt.x");
    }
    if env::var_os("CARGO_FEATURE_BENCH").is_some() {
        compare_with_c(&out)?;
    }
    Ok(())
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
