//! Everything random of a campaign: the same seed, the same throws.

use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// A generator with the throws that faults need.
#[derive(Clone, Debug)]
pub struct Dice(Pcg64);

impl Dice {
    /// Throws of this seed.
    pub fn new(seed: u64) -> Self {
        Self(Pcg64::seed_from_u64(seed))
    }

    /// Any 64 bits.
    pub fn bits(&mut self) -> u64 {
        StandardUniform.sample(&mut self.0)
    }

    /// From 0 to below `end`; 0 for an `end` of 0.
    pub fn below(&mut self, end: usize) -> usize {
        (self.bits() % end.max(1) as u64) as usize
    }

    /// True once in `count` times, in the mean.
    pub fn one_in(&mut self, count: usize) -> bool {
        self.below(count) == 0
    }

    /// From `low` to below `high`.
    pub fn real(&mut self, low: f32, high: f32) -> f32 {
        let unit: f64 = StandardUniform.sample(&mut self.0);
        (f64::from(low) + unit * (f64::from(high) - f64::from(low))) as f32
    }

    /// As many bytes of any value.
    pub fn bytes(&mut self, count: usize) -> Vec<u8> {
        (0..count).map(|_| self.bits() as u8).collect()
    }

    /// The places of a list in any order.
    pub fn order(&mut self, len: usize) -> Vec<usize> {
        let mut places: Vec<usize> = (0..len).collect();
        for last in (1..len).rev() {
            places.swap(last, self.below(last + 1));
        }
        places
    }
}
