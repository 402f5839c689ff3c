//! Seeded random numbers, one independent stream for each purpose.

use rand_distr::{Distribution, StandardNormal, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// What a stream of random numbers is for; streams of one seed do not touch each other, so that the
/// same stage is drawn whatever is hidden in it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stream {
    Stage = 1,
    Protocol,
    Choice,
    Effect,
    Noise,
}

/// Random numbers of one seed and purpose.
pub(super) struct Draw(Pcg64);

impl Draw {
    /// The stream; `part` tells apart several of one purpose.
    pub(super) fn new(seed: u64, stream: Stream, part: u64) -> Self {
        let words = [stream as u64, part];
        Self(Pcg64::seed_from_u64(
            words
                .into_iter()
                .fold(mixed(seed), |sum, word| mixed(sum ^ word)),
        ))
    }

    /// Uniform between two numbers.
    pub(super) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let share: f64 = StandardUniform.sample(&mut self.0);
        low + (high - low) * share
    }

    /// Uniform in the logarithm between two positive numbers.
    pub(super) fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    /// True with a probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.uniform(0.0, 1.0) < probability
    }

    /// 1 or -1.
    pub(super) fn sign(&mut self) -> f64 {
        if self.chance(0.5) { 1.0 } else { -1.0 }
    }

    /// A whole number from `least` to `most`.
    pub(super) fn whole(&mut self, least: usize, most: usize) -> usize {
        let count = (most - least + 1) as f64;
        (least + self.uniform(0.0, count) as usize).min(most)
    }

    /// One of several.
    pub(super) fn pick<T: Copy, const N: usize>(&mut self, from: [T; N]) -> T {
        from[self.whole(0, N - 1)]
    }

    /// Normal with unit variance.
    pub(super) fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }
}

/// Steele, Lea and Flood's SplitMix64: seeds that differ in a bit give streams that have nothing in
/// common.
fn mixed(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}
