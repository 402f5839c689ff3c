//! Sums of a residual over classes of its samples, with block bootstrap bands.

use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

/// Blocks that a record is cut into.
pub(super) const BLOCKS: usize = 24;
/// Resamplings.
const DRAWS: usize = 200;
/// Lower end of a band; the upper one is as far from the other end.
const TAIL: f64 = 0.05;
const SEED: u64 = 0x6a70;

/// What one class holds.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    weight: f64,
    square: f64,
    reference: f64,
}

/// Sums by record, block and class. Every record has the same weight, its blocks are resampled among
/// themselves.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    classes: usize,
    /// Record, block, class.
    sums: Vec<Vec<Vec<Sum>>>,
}

/// A class with the band that nine of ten resamplings lie in.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Class {
    /// Root of the mean square in um.
    pub rms_um: f64,
    /// Its band.
    pub band_um: (f64, f64),
    /// Share of the gap, 0 to 1.
    pub share: f64,
    /// The share that a gap without any preference would have.
    pub expected: f64,
}

impl Tally {
    pub fn new(classes: usize) -> Self {
        Self {
            classes,
            sums: Vec::new(),
        }
    }

    /// Begins the next record; all that is added belongs to it.
    pub fn record(&mut self) {
        self.sums
            .push(vec![vec![Sum::default(); self.classes]; BLOCKS]);
    }

    /// Adds to item `k` of `count` of the record: its weight, square (um^2), and what it would hold of
    /// a gap without preference.
    pub fn add(&mut self, (k, count): (usize, usize), class: usize, sum: (f64, f64, f64)) {
        let block = (k * BLOCKS / count.max(1)).min(BLOCKS - 1);
        if let Some(record) = self.sums.last_mut() {
            let at = &mut record[block][class.min(self.classes - 1)];
            at.weight += sum.0;
            at.square += sum.1;
            at.reference += sum.2;
        }
    }

    fn total(&self) -> Vec<Sum> {
        let mut total = vec![Sum::default(); self.classes];
        self.sums.iter().flatten().for_each(|b| join(&mut total, b));
        total
    }

    /// The classes; `spread` takes the rms over all samples instead of those of the class.
    pub fn classes(&self, noise_um: f64, spread: bool) -> Vec<Class> {
        let records = self.sums.len().max(1) as f64;
        let rms = |sum: &Sum| {
            let over = if spread { records } else { sum.weight };
            (sum.square.max(0.0) / over.max(f64::MIN_POSITIVE)).sqrt()
        };
        let total = self.total();
        let shares = shares(&total, noise_um);
        let reference: f64 = total.iter().map(|s| s.reference).sum();
        let mut drawn: Vec<Vec<f64>> = vec![Vec::new(); self.classes];
        self.resample(|sums| {
            for (class, sum) in drawn.iter_mut().zip(sums) {
                if sum.weight > 0.0 {
                    class.push(rms(sum));
                }
            }
        });
        total
            .iter()
            .zip(shares)
            .zip(&mut drawn)
            .map(|((sum, share), drawn)| Class {
                rms_um: if sum.weight > 0.0 { rms(sum) } else { f64::NAN },
                band_um: band(drawn),
                share,
                expected: sum.reference / reference.max(f64::MIN_POSITIVE),
            })
            .collect()
    }

    /// The band of the share of the gap that the classes `of` have together.
    pub fn share_band(&self, noise_um: f64, of: impl Fn(usize) -> bool) -> (f64, f64) {
        let mut drawn = Vec::with_capacity(DRAWS);
        self.resample(|sums| {
            let shares = shares(sums, noise_um);
            let held = shares.iter().enumerate().filter(|(i, _)| of(*i));
            drawn.push(held.map(|(_, share)| share).sum());
        });
        band(&mut drawn)
    }

    fn resample(&self, mut each: impl FnMut(&[Sum])) {
        let mut random = Pcg64::seed_from_u64(SEED);
        for _ in 0..DRAWS {
            let mut total = vec![Sum::default(); self.classes];
            for record in &self.sums {
                for _ in 0..BLOCKS {
                    let share: f64 = StandardUniform.sample(&mut random);
                    let block = (share * BLOCKS as f64) as usize;
                    join(&mut total, &record[block.min(BLOCKS - 1)]);
                }
            }
            each(&total);
        }
    }
}

fn join(total: &mut [Sum], block: &[Sum]) {
    for (total, sum) in total.iter_mut().zip(block) {
        total.weight += sum.weight;
        total.square += sum.square;
        total.reference += sum.reference;
    }
}

/// What each class holds beyond the noise, over what all that hold any do.
fn shares(sums: &[Sum], noise_um: f64) -> Vec<f64> {
    let beyond = |s: &Sum| (s.square - noise_um * noise_um * s.weight).max(0.0);
    let total: f64 = sums.iter().map(beyond).sum();
    sums.iter()
        .map(|s| beyond(s) / total.max(f64::MIN_POSITIVE))
        .collect()
}

fn band(drawn: &mut [f64]) -> (f64, f64) {
    drawn.sort_by(f64::total_cmp);
    let Some(last) = drawn.len().checked_sub(1) else {
        return (f64::NAN, f64::NAN);
    };
    let at = |share: f64| drawn[((share * last as f64).round() as usize).min(last)];
    (at(TAIL), at(1.0 - TAIL))
}

/// The run of neighbouring classes that holds the most beyond what a gap without preference would:
/// first and last class, and by how much; `None` where there are no classes.
pub(super) fn richest(classes: &[Class]) -> Option<(usize, usize, f64)> {
    let mut best: Option<(usize, usize, f64)> = None;
    let (mut from, mut sum) = (0, 0.0);
    for (i, class) in classes.iter().enumerate() {
        if sum <= 0.0 {
            (from, sum) = (i, 0.0);
        }
        sum += class.share - class.expected;
        if best.is_none_or(|(_, _, most)| sum > most) {
            best = Some((from, i, sum));
        }
    }
    best
}
