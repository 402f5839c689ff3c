//! The firmware's ELF: built where it is missing, measured.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use elf::ElfBytes;
use elf::abi::{SHF_ALLOC, SHF_WRITE, SHT_NOBITS};
use elf::endian::AnyEndian;

use crate::error::{Error, Place};

const SCRIPT: &str = "scripts/thumb-cargo.sh";
const OUTPUT: &str = "thumbv7em-none-eabihf/firmware/firmware";

/// Memory that a program takes before it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sizes {
    /// Bytes of flash: code, constants and the initial values of variables.
    pub flash_bytes: u64,
    /// Bytes of RAM for variables, the stack not counted.
    pub ram_bytes: u64,
}

/// Builds the firmware for the emulator and gives the path of its ELF; quick when nothing changed.
///
/// The sources are those of the workspace around the current folder. `HYSTERON_THUMB_DIR` names
/// another target folder than `target/thumb`.
///
/// # Errors
/// No sources here, no compiler for the target and what to install, or a build that fails.
pub fn build() -> Result<PathBuf, Error> {
    let here = std::env::current_dir()
        .map_err(|error| Error::request(format!("the current folder: {error}; choose another")))?;
    let Some(root) = here
        .ancestors()
        .find(|folder| folder.join(SCRIPT).is_file())
    else {
        return Err(Error::request(
            "the firmware's sources are not here; go to the project's folder, or name an ELF \
             built with the feature qemu by --firmware",
        ));
    };
    let target = match std::env::var_os("HYSTERON_THUMB_DIR") {
        Some(folder) => PathBuf::from(folder),
        None => root.join("target").join("thumb"),
    };
    let output = Command::new("bash")
        .arg(SCRIPT)
        .args(["build", "--quiet", "--locked", "--package", "hysteron"])
        .args(["--profile", "firmware", "--bin", "firmware"])
        .args(["--features", "qemu"])
        .current_dir(root)
        .env("CARGO_TARGET_DIR", &target)
        .output()
        .map_err(|error| Error::request(format!("bash: {error}; install it, or use --firmware")))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        // A missing compiler takes two lines; the rest of a failed build is for its own command.
        let first: Vec<_> = said.lines().take(2).collect();
        return Err(Error::request(format!(
            "the firmware cannot be built: {}",
            first.join(" ")
        )));
    }
    Ok(target.join(OUTPUT))
}

/// Sizes from an ELF's sections.
///
/// # Errors
/// A file that cannot be read or is no ELF.
pub fn sizes(firmware: &Path) -> Result<Sizes, Error> {
    let place = Place::file(firmware);
    let bytes = fs::read(firmware).map_err(|source| {
        place
            .clone()
            .io_error("cannot read", "check the path", source)
    })?;
    let refuse = |what: &str| {
        place
            .clone()
            .error(format!("{what}; name the firmware's ELF"))
    };
    let file = ElfBytes::<AnyEndian>::minimal_parse(&bytes)
        .map_err(|error| refuse(&format!("not an ELF: {error}")))?;
    let sections = file
        .section_headers()
        .ok_or_else(|| refuse("an ELF without sections"))?;
    let mut sizes = Sizes {
        flash_bytes: 0,
        ram_bytes: 0,
    };
    for section in sections {
        let has = |flag: u32| section.sh_flags & u64::from(flag) != 0;
        if !has(SHF_ALLOC) {
            continue;
        }
        if section.sh_type != SHT_NOBITS {
            sizes.flash_bytes += section.sh_size;
        }
        if has(SHF_WRITE) {
            sizes.ram_bytes += section.sh_size;
        }
    }
    Ok(sizes)
}
