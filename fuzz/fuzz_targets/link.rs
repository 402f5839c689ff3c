//! `cargo fuzz run link`, see `README.md`.
#![no_main]

use std::sync::atomic::{AtomicU64, Ordering};

use libfuzzer_sys::fuzz_target;

#[path = "../targets/link.rs"]
mod link;

static FRAMES: AtomicU64 = AtomicU64::new(0);

fuzz_target!(|script: &[u8]| {
    let new = link::run(script);
    let before = FRAMES.fetch_add(new, Ordering::Relaxed);
    if before / 1_000_000 != (before + new) / 1_000_000 {
        eprintln!("{} frames", before + new);
    }
});
