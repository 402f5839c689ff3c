//! Places the program in the memory of an STM32F405.

use std::path::PathBuf;
use std::{env, fs};

fn main() {
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("set by cargo"));
    let memory = "MEMORY { FLASH : ORIGIN = 0x08000000, LENGTH = 1M\n\
                  RAM : ORIGIN = 0x20000000, LENGTH = 128K }\n";
    fs::write(out.join("memory.x"), memory).expect("the build directory is writable");
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg=--nmagic");
    println!("cargo:rustc-link-arg=-Tlink.x");
}
