//! Turning points of a drive and what follows from them: where its first cycle ends, and over which
//! frequencies it moves.

/// Share of the drive's range that a reversal must exceed to count as a turning point.
const SIGNIFICANT: f64 = 0.05;

/// Highest less lowest value; zero for an empty slice.
pub fn range(values: &[f64]) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &v| {
            (low.min(v), high.max(v))
        });
    (high - low).max(0.0)
}

/// Finds the samples at which a drive turns by more than [`SIGNIFICANT`] of its range, one after the other.
#[derive(Clone, Copy, Debug)]
pub struct Turns {
    least: f64,
    /// Samples so far.
    count: u64,
    /// Extremes since the last turn, with their indices.
    highest: (u64, f64),
    lowest: (u64, f64),
    /// Unknown until one of the extremes is left by `least`.
    rising: Option<bool>,
}

impl Turns {
    /// For a drive of the given range (V).
    pub fn new(range: f64) -> Self {
        Self {
            least: SIGNIFICANT * range,
            count: 0,
            highest: (0, f64::NEG_INFINITY),
            lowest: (0, f64::INFINITY),
            rising: None,
        }
    }

    /// Takes the next value; the index of the turning point that it makes certain.
    pub fn push(&mut self, u: f64) -> Option<u64> {
        let here = (self.count, u);
        self.count += 1;
        if self.least <= 0.0 {
            return None;
        }
        if u > self.highest.1 {
            self.highest = here;
        }
        if u < self.lowest.1 {
            self.lowest = here;
        }
        let before = self.rising;
        if before != Some(false) && self.highest.1 - u > self.least {
            (self.rising, self.lowest) = (Some(false), here);
            return before.map(|_| self.highest.0);
        }
        if before != Some(true) && u - self.lowest.1 > self.least {
            (self.rising, self.highest) = (Some(true), here);
            return before.map(|_| self.lowest.0);
        }
        None
    }

    /// The index of the next turning point, if the drive turns now.
    pub fn next(&self) -> Option<u64> {
        self.rising.map(|rising| match rising {
            true => self.highest.0,
            false => self.lowest.0,
        })
    }
}

/// Indices of the samples at which the drive turns by more than [`SIGNIFICANT`] of `range` (V).
pub fn turning_points(drive: &[f64], range: f64) -> Vec<usize> {
    let mut turns = Turns::new(range);
    let found = drive.iter().filter_map(|&u| turns.push(u));
    found.map(|index| index as usize).collect()
}

/// Where the first cycle ends: the second turning point, when more than one cycle follows it.
///
/// By then both directions have pushed the plays. A record of fewer cycles is kept whole.
pub fn first_cycle(turns: &[usize]) -> usize {
    if turns.len() >= 4 { turns[1] } else { 0 }
}

/// Whether the drive ends a step before it began, as one or more whole periods do.
pub fn is_closed(drive: &[f64]) -> bool {
    let largest = drive
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .fold(0.0, f64::max);
    drive.len() > 1 && (drive[0] - drive[drive.len() - 1]).abs() <= 1.5 * largest
}

/// Frequency (Hz) of each half cycle between two turning points, rests left out: mean speed while
/// moving over twice the swing. For a sine, a triangle and a sine with holds it is the frequency.
pub fn half_cycle_frequencies(drive: &[f64], turns: &[usize], sample_time_s: f64) -> Vec<f64> {
    turns
        .windows(2)
        .filter_map(|pair| {
            let piece = &drive[pair[0]..=pair[1]];
            let swing = (piece[piece.len() - 1] - piece[0]).abs();
            // A sample that moves less than a hundredth of the mean step is at rest.
            let still = 0.01 * swing / (piece.len() - 1) as f64;
            let moving = piece
                .windows(2)
                .filter(|w| (w[1] - w[0]).abs() > still)
                .count();
            (moving > 0).then(|| 0.5 / (moving as f64 * sample_time_s))
        })
        .collect()
}

/// Highest over lowest of the frequencies, outliers (a twentieth on each side) left out; 1 when
/// there are fewer than two.
pub fn span(mut frequencies: Vec<f64>) -> f64 {
    frequencies.sort_by(f64::total_cmp);
    let cut = frequencies.len() / 20;
    match &frequencies[cut..frequencies.len() - cut] {
        [low, .., high] if *low > 0.0 => high / low,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn sine(frequency: f64, seconds: f64, h: f64) -> Vec<f64> {
        (0..(seconds / h) as usize)
            .map(|k| (TAU * frequency * k as f64 * h).sin())
            .collect()
    }

    #[test]
    fn turning_points_of_a_sine() {
        let drive = sine(2.0, 2.0, 1e-3);
        let turns = turning_points(&drive, range(&drive));
        assert_eq!(turns, [125, 375, 625, 875, 1125, 1375, 1625, 1875]);
        assert_eq!(first_cycle(&turns), 375);
        assert_eq!(first_cycle(&turns[..3]), 0);
    }

    #[test]
    fn frequencies_ignore_rests() {
        let moving = sine(5.0, 1.0, 1e-3);
        let mut with_rest = moving.clone();
        let top = moving[50];
        with_rest.splice(50..50, std::iter::repeat_n(top, 700));
        for drive in [moving, with_rest] {
            let turns = turning_points(&drive, 2.0);
            let frequencies = half_cycle_frequencies(&drive, &turns, 1e-3);
            assert!(
                frequencies.iter().all(|f| (f - 5.0).abs() < 0.2),
                "{frequencies:?}"
            );
        }
    }

    #[test]
    fn span_of_records() {
        assert_eq!(span(vec![1.0, 100.0, 50.0]), 100.0);
        assert_eq!(span(vec![]), 1.0);
        // One odd half cycle in forty does not make a decade.
        let mut mostly_one = vec![1.0; 39];
        mostly_one.push(50.0);
        assert_eq!(span(mostly_one), 1.0);
    }
}
