//! What the side-by-side benches share: inputs, quantiles, the name of the machine.
//!
//! Criterion and divan run one benchmark after the other and time only their own process. On a
//! machine that others use, too, a ratio needs both sides in the same breath, so these benches
//! alternate between the sides and report the ratio of each round.

#![allow(dead_code, reason = "each bench uses its part")]

use std::f64::consts::PI;
use std::process::Command;

/// Smallest, middle and largest of some figures.
#[derive(Clone, Copy)]
pub struct Spread {
    pub min: f64,
    pub median: f64,
    pub max: f64,
}

pub fn spread(figures: impl IntoIterator<Item = f64>) -> Spread {
    let mut figures: Vec<f64> = figures.into_iter().collect();
    figures.sort_by(f64::total_cmp);
    Spread {
        min: figures[0],
        median: figures[figures.len() / 2],
        max: figures[figures.len() - 1],
    }
}

/// Two tones within -40..40 V at 10 kHz: turning points at many heights.
pub fn two_tone(samples: usize) -> Vec<f64> {
    let tone = |hz: f64, k: usize| (2.0 * PI * hz * k as f64 * 1e-4).sin();
    (0..samples)
        .map(|k| 25.0 * tone(5.0, k) + 15.0 * tone(12.3, k))
        .collect()
}

/// White noise, uniform in -40..40 V, the same in each run (a 64-bit linear congruential generator).
pub fn white_noise(samples: usize) -> Vec<f64> {
    let mut state = 1u64;
    (0..samples)
        .map(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            80.0 * ((state >> 11) as f64 / (1u64 << 53) as f64 - 0.5)
        })
        .collect()
}

/// Prints what the figures were taken with: processor, compilers, whether the target is native.
pub fn print_machine(programs: &[&str]) {
    let cpu = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split(": ").nth(1))
        .unwrap_or("unknown processor");
    println!("{model}");
    for program in programs {
        let version = Command::new(program).arg("--version").output();
        let version = version.map(|output| String::from_utf8_lossy(&output.stdout).into_owned());
        if let Some(line) = version.as_deref().unwrap_or("").lines().next() {
            println!("{line}");
        }
    }
}
