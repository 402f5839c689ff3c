//! What a pass over a file tells of it, in memory that does not grow with the file.

use std::ops::Range;

use super::{Rows, Source};
use crate::dataset::MIN_SAMPLES;
use crate::error::{Error, Place};
use crate::time_grid::{is_uneven, not_after, uneven};

/// Scales of time: means of 1, 2, 4, ... samples.
const SCALES: usize = 28;
/// Stretches of equal length whose extremes of the drive are kept.
const STRETCHES: usize = 1 << 13;
/// Share of the drive's range by which means may bend between neighbours.
const DRIVE_BEND: f64 = 2e-3;
/// The same of the displacement, beyond what noise without memory does.
const DISPLACEMENT_BEND: f64 = 5e-4;
/// How much more than halving from scale to scale may still be such noise.
const NOISE_MARGIN: f64 = 1.2;
/// Share of the drive's range so far that a reversal must exceed to count.
const SIGNIFICANT: f64 = 0.05;

/// A surveyed file.
pub struct Survey {
    /// Rows of numbers.
    pub rows: u64,
    /// Time of the first row in s.
    pub first_s: f64,
    /// Time of the last row in s.
    pub last_s: f64,
    /// Times that the drive turned.
    pub turns: u64,
    extremes: Extremes,
    displacement: (f64, f64),
    /// Sums of squared bends and their number, of drive and displacement, by scale.
    bends: Vec<([f64; 2], u64)>,
}

impl Survey {
    /// Reads a file through.
    pub fn of(source: &Source, progress: &dyn Fn(&str)) -> Result<Self, Error> {
        let mut rows = Rows::open(source, "surveying", progress)?;
        let place = || Place::file(&source.file);
        let column = rows.table.headers()[source.layout.time.0].clone();
        let mut survey = Self {
            rows: 0,
            first_s: 0.0,
            last_s: 0.0,
            turns: 0,
            extremes: Extremes::default(),
            displacement: (f64::INFINITY, f64::NEG_INFINITY),
            bends: Vec::new(),
        };
        let mut pyramid = Pyramid::default();
        let mut turns = Turns::default();
        // Shortest and longest step, and the line they lead to.
        let mut steps = [(f64::INFINITY, 0), (f64::NEG_INFINITY, 0)];
        while let Some((line, [time, drive, displacement])) = rows.next()? {
            if survey.rows == 0 {
                survey.first_s = time;
            } else {
                let step = time - survey.last_s;
                if step <= 0.0 {
                    let place = place().line(line).column(column);
                    return Err(place.error(not_after(survey.last_s, time)));
                }
                if step < steps[0].0 {
                    steps[0] = (step, line);
                }
                if step > steps[1].0 {
                    steps[1] = (step, line);
                }
            }
            survey.last_s = time;
            survey.rows += 1;
            survey.extremes.push(drive);
            let (low, high) = survey.displacement;
            survey.displacement = (low.min(displacement), high.max(displacement));
            pyramid.push([drive, displacement]);
            turns.push(drive);
        }
        if survey.rows < MIN_SAMPLES as u64 {
            return Err(place().error(format!(
                "there are {} samples under the column names and at least {MIN_SAMPLES} are needed; \
                 record more",
                survey.rows
            )));
        }
        let mean = survey.sample_time_s();
        for (step, line) in steps {
            if is_uneven(step, mean) {
                let place = place().line(line).column(column);
                return Err(place.error(uneven(step, mean)));
            }
        }
        survey.turns = turns.count;
        survey.bends = pyramid.bends.to_vec();
        Ok(survey)
    }

    /// The mean step in s.
    pub fn sample_time_s(&self) -> f64 {
        (self.last_s - self.first_s) / (self.rows.max(2) - 1) as f64
    }

    /// Lowest and highest drive in V.
    pub fn drive_v(&self) -> (f64, f64) {
        self.extremes.within(0..self.rows)
    }

    /// Lowest and highest drive in V among at least the rows asked for.
    pub fn drive_within(&self, rows: Range<u64>) -> (f64, f64) {
        self.extremes.within(rows)
    }

    /// Rows near to where the drive is lowest and highest among those asked for.
    pub fn extremes_within(&self, rows: Range<u64>) -> [u64; 2] {
        self.extremes.places(rows)
    }

    /// The largest scale (means of two to the power of it) within which neither signal bends.
    pub fn scale(&self) -> u32 {
        let (low, high) = self.drive_v();
        let most_drive = (DRIVE_BEND * (high - low)).powi(2);
        let (low, high) = self.displacement;
        let most_displacement = (DISPLACEMENT_BEND * (high - low)).powi(2);
        let mean = |&([drive, displacement], count): &([f64; 2], u64)| {
            let count = count.max(1) as f64;
            [drive / count, displacement / count]
        };
        let Some([_, finest]) = self.bends.first().map(mean) else {
            return 0;
        };
        let smooth = |(scale, bends): (usize, &([f64; 2], u64))| {
            let [drive, displacement] = mean(bends);
            let noise = NOISE_MARGIN * finest / (1u64 << scale) as f64;
            bends.1 >= MIN_SAMPLES as u64
                && drive <= most_drive
                && displacement <= noise + most_displacement
        };
        let scales = self.bends.iter().enumerate().skip(1);
        scales.take_while(|scale| smooth(*scale)).count() as u32
    }
}

/// Means of 1, 2, 4, ... samples, and how they bend: the middle one of three against the mean of the
/// others.
struct Pyramid {
    waiting: [Option<[f64; 2]>; SCALES],
    before: [[[f64; 2]; 2]; SCALES],
    seen: [u64; SCALES],
    bends: [([f64; 2], u64); SCALES],
}

impl Default for Pyramid {
    fn default() -> Self {
        Self {
            waiting: [None; SCALES],
            before: [[[0.0; 2]; 2]; SCALES],
            seen: [0; SCALES],
            bends: [([0.0; 2], 0); SCALES],
        }
    }
}

impl Pyramid {
    fn push(&mut self, sample: [f64; 2]) {
        let mut value = sample;
        for scale in 0..SCALES {
            let [first, middle] = self.before[scale];
            if self.seen[scale] >= 2 {
                let (sums, count) = &mut self.bends[scale];
                for i in 0..2 {
                    sums[i] += (middle[i] - 0.5 * (first[i] + value[i])).powi(2);
                }
                *count += 1;
            }
            self.before[scale] = [middle, value];
            self.seen[scale] += 1;
            match self.waiting[scale].take() {
                None => {
                    self.waiting[scale] = Some(value);
                    return;
                }
                Some(other) => value = [0, 1].map(|i| 0.5 * (other[i] + value[i])),
            }
        }
    }
}

/// Extremes of stretches of equal length, which doubles when they become too many.
#[derive(Default)]
struct Extremes {
    length: u64,
    filled: u64,
    stretches: Vec<(f64, f64)>,
}

impl Extremes {
    fn push(&mut self, value: f64) {
        if self.length == 0 {
            self.length = 64;
        }
        if self.filled.is_multiple_of(self.length) {
            if self.stretches.len() == STRETCHES {
                self.stretches = self
                    .stretches
                    .chunks(2)
                    .map(|pair| pair.iter().copied().reduce(joined).unwrap_or_default())
                    .collect();
                self.length *= 2;
                self.filled = self.stretches.len() as u64 * self.length;
            }
            self.stretches.push((value, value));
        } else if let Some(last) = self.stretches.last_mut() {
            *last = joined(*last, (value, value));
        }
        self.filled += 1;
    }

    fn part(&self, rows: &Range<u64>) -> Range<usize> {
        let length = self.length.max(1);
        let to = rows.end.div_ceil(length).min(self.stretches.len() as u64);
        (rows.start / length).min(to) as usize..to as usize
    }

    fn within(&self, rows: Range<u64>) -> (f64, f64) {
        let part = self.stretches[self.part(&rows)].iter().copied();
        part.reduce(joined).unwrap_or((0.0, 0.0))
    }

    fn places(&self, rows: Range<u64>) -> [u64; 2] {
        let (low, high) = self.within(rows.clone());
        let part = self.part(&rows);
        let row = |found: Option<usize>| {
            let stretch = part.start + found.unwrap_or(0);
            stretch as u64 * self.length + self.length / 2
        };
        let part = &self.stretches[part.clone()];
        [
            row(part.iter().position(|stretch| stretch.0 <= low)),
            row(part.iter().position(|stretch| stretch.1 >= high)),
        ]
    }
}

fn joined(a: (f64, f64), b: (f64, f64)) -> (f64, f64) {
    (a.0.min(b.0), a.1.max(b.1))
}

/// Counts reversals by more than a share of the range so far.
#[derive(Default)]
struct Turns {
    range: Option<(f64, f64)>,
    rising: bool,
    /// Furthest in the present direction.
    tip: f64,
    count: u64,
}

impl Turns {
    fn push(&mut self, u: f64) {
        let (low, high) = self.range.unwrap_or((u, u));
        self.range = Some((low.min(u), high.max(u)));
        if self.count == 0 && low == high {
            self.tip = u;
            self.rising = u >= low;
        }
        let least = SIGNIFICANT * (high - low);
        let ahead = if self.rising {
            u - self.tip
        } else {
            self.tip - u
        };
        if ahead >= 0.0 {
            self.tip = u;
        } else if -ahead > least && least > 0.0 {
            (self.rising, self.tip) = (!self.rising, u);
            self.count += 1;
        }
    }
}
