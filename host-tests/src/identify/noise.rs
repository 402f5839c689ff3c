//! The noise floor of a data set: what no model can explain.

use serde::Serialize;

use super::cycles::{range, turning_points};
use super::run::Run;

/// Where a noise floor was estimated from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Source {
    /// Differences between repeated cycles of the drive.
    Repeats,
    /// Displacement while the drive rests.
    Rest,
    /// Differences between whole periods of a drive that has no like cycles, as a multisine.
    Periods,
    /// What is left of the displacement above the band of its motion.
    HighPass,
}

impl Source {
    /// For the report.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Repeats => "from repeated cycles",
            Self::Rest => "from rests of the drive",
            Self::Periods => "from repeated periods",
            Self::HighPass => "from the residue above the band of motion",
        }
    }
}

/// Where rests are this much quieter than repeated cycles, over these, the cycles do not repeat: a mode
/// rings on, or a line of the mains runs along. Much less is a reading that stands still on a step.
const QUIETER: std::ops::Range<f64> = 0.02..0.5;

/// How far from their lower quartile estimates may lie to count, as a factor: the scatter of a few hundred
/// samples.
const ALIKE: f64 = 1.1;

/// What one run says of the noise.
struct Estimate {
    /// In um.
    rms: f64,
    /// From so many samples.
    samples: usize,
    source: Source,
}

/// Rms noise of the displacement in micrometres, from the best source that any of the runs offers, and
/// that source: of those runs together whose estimates lie near the lower quartile. Zero runs give `None`.
pub fn floor(runs: &[Run]) -> Option<(f64, Source)> {
    let estimates: Vec<Estimate> = runs.iter().map(of_run).collect();
    let best = estimates.iter().map(|one| one.source).min()?;
    let found = together(&estimates, best)?;
    let rest = together(&estimates, Source::Rest).filter(|rest| QUIETER.contains(&(rest / found)));
    Some(match rest {
        Some(rest) => (rest, Source::Rest),
        None => (found, best),
    })
}

/// What the estimates from one source near their lower quartile come to: creep, drift or hum tell repeated
/// cycles of some runs apart; noise is in all of them.
fn together(estimates: &[Estimate], wanted: Source) -> Option<f64> {
    let of_source = || estimates.iter().filter(|one| one.source == wanted);
    let mut sizes: Vec<f64> = of_source().map(|one| one.rms).collect();
    sizes.sort_by(f64::total_cmp);
    let quartile = *sizes.get(sizes.len() / 4)?;
    let near = quartile / ALIKE..=quartile * ALIKE;
    let alike = of_source().filter(|one| near.contains(&one.rms));
    let (squares, samples) = alike.fold((0.0, 0), |(squares, samples), one| {
        let count = one.samples as f64;
        (squares + count * one.rms * one.rms, samples + one.samples)
    });
    Some((squares / samples as f64).sqrt())
}

fn of_run(run: &Run) -> Estimate {
    let (drive, displacement) = (&run.drive[..], &run.displacement[..]);
    let known = [
        (repeats(drive, displacement), Source::Repeats),
        (rest(drive, displacement), Source::Rest),
        (periods(drive, displacement), Source::Periods),
    ];
    let known = known
        .into_iter()
        .find_map(|(found, source)| found.map(|found| (found, source)));
    let ((rms, samples), source) =
        known.unwrap_or_else(|| (high_pass(displacement), Source::HighPass));
    Estimate {
        rms,
        samples,
        source,
    }
}

/// Rms of what one cycle differs from the next where the drive repeats itself, over the root of two, and
/// from how many samples; so in the functions below.
fn repeats(drive: &[f64], displacement: &[f64]) -> Option<(f64, usize)> {
    let span = range(drive);
    let turns = turning_points(drive, span);
    let [first, second, ..] = turns[..] else {
        return None;
    };
    let skip = usize::from(drive[first] < drive[second]);
    let tops: Vec<usize> = turns.into_iter().skip(skip).step_by(2).collect();
    let mut squares = 0.0;
    let mut count = 0usize;
    for cycle in tops.windows(3) {
        // The cycle before must be the same, too: it sets the state that this one starts from.
        let (first, second) = (cycle[1] - cycle[0], cycle[2] - cycle[1]);
        if first != second || first < 8 {
            continue;
        }
        let largest = (cycle[1]..cycle[2])
            .map(|k| (drive[k] - drive[k - first]).abs())
            .fold(0.0, f64::max);
        if largest > 0.002 * span {
            continue;
        }
        // A period that is no whole number of samples moves the drive a little from cycle to cycle, and
        // the displacement with it.
        let moved = |k: usize| drive[k] - drive[k - first];
        let differs = |k: usize| displacement[k] - displacement[k - first];
        let (mut along, mut size) = (0.0, 0.0);
        for k in cycle[1]..cycle[2] {
            along += moved(k) * differs(k);
            size += moved(k) * moved(k);
        }
        let slope = if size > 0.0 { along / size } else { 0.0 };
        squares += (cycle[1]..cycle[2])
            .map(|k| 0.5 * (differs(k) - slope * moved(k)).powi(2))
            .sum::<f64>();
        count += second;
    }
    (count >= 16).then(|| ((squares / count as f64).sqrt(), count))
}

/// Rms of what the last whole period of the drive differs from the one before, over the root of two.
///
/// Of two periods only the later halves count: the first one may have started in another state.
fn periods(drive: &[f64], displacement: &[f64]) -> Option<(f64, usize)> {
    const LEAST: usize = 64;
    let same = 0.002 * range(drive);
    let count = drive.len();
    let period = (LEAST..=count / 2).find(|&period| {
        let pairs = drive[period..].iter().zip(drive);
        same > 0.0 && pairs.into_iter().all(|(a, b)| (a - b).abs() <= same)
    })?;
    let settled = if count >= 3 * period {
        count - period
    } else {
        count - period / 2
    };
    let squares: f64 = (settled..count)
        .map(|k| 0.5 * (displacement[k] - displacement[k - period]).powi(2))
        .sum();
    let looked_at = count - settled;
    Some(((squares / looked_at as f64).sqrt(), looked_at))
}

/// Rms about a straight line while the drive stands still for at least 50 samples.
fn rest(drive: &[f64], displacement: &[f64]) -> Option<(f64, usize)> {
    const LEAST: usize = 50;
    let still = 1e-6 * range(drive);
    let (mut squares, mut count) = (0.0, 0usize);
    let mut from = 0;
    for k in 1..=drive.len() {
        if k < drive.len() && (drive[k] - drive[from]).abs() <= still {
            continue;
        }
        // What moves just after a stop is creep, not noise.
        let settled = from + (k - from) / 2;
        if k - settled >= LEAST {
            let piece = &displacement[settled..k];
            squares += about_line(piece);
            count += piece.len() - 2;
        }
        from = k;
    }
    (count > 0).then(|| ((squares / count as f64).sqrt(), count))
}

/// Sum of squares about the best straight line.
fn about_line(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let middle = 0.5 * (n - 1.0);
    let (mut sxy, mut sxx, mut syy) = (0.0, 0.0, 0.0);
    for (k, v) in values.iter().enumerate() {
        let (x, y) = (k as f64 - middle, v - mean);
        sxy += x * y;
        sxx += x * x;
        syy += y * y;
    }
    (syy - sxy * sxy / sxx).max(0.0)
}

/// Rms of fourth differences over that of white noise of size one.
fn high_pass(displacement: &[f64]) -> (f64, usize) {
    let squares: f64 = displacement
        .windows(5)
        .map(|w| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).powi(2))
        .sum();
    let count = displacement.len().saturating_sub(4).max(1);
    ((squares / count as f64 / 70.0).sqrt(), count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// The two in the middle; one stands on a step of the reading, one hums.
    #[test]
    fn runs_near_the_lower_quartile_count_by_their_samples() {
        let estimates: Vec<Estimate> = [(0.1, 50), (1.0, 300), (1.05, 100), (2.0, 900)]
            .map(|(rms, samples)| Estimate {
                rms,
                samples,
                source: Source::Rest,
            })
            .into();
        let wanted: f64 = (300.0 + 100.0 * 1.05 * 1.05) / 400.0;
        let found = together(&estimates, Source::Rest).unwrap();
        assert!((found - wanted.sqrt()).abs() < 1e-12, "{found}");
        assert_eq!(together(&estimates, Source::Repeats), None);
    }

    /// Three tones that never come to two like cycles, and white noise of a known size.
    #[test]
    fn noise_of_a_drive_that_repeats_as_a_whole() {
        let tones = [(3.0, 0.1), (7.0, 2.0), (16.0, 4.0)];
        let drive: Vec<f64> = (0..2048)
            .map(|k| {
                let at = TAU * f64::from(k % 1024) / 1024.0;
                tones
                    .iter()
                    .map(|(line, phase)| (line * at + phase).sin())
                    .sum()
            })
            .collect();
        let mut state = 1u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let noisy: Vec<f64> = drive.iter().map(|u| 5.0 * u + uniform()).collect();
        // Uniform noise of width one.
        let truth = (1.0f64 / 12.0).sqrt();
        let (found, samples) = periods(&drive, &noisy).unwrap();
        assert!((found / truth - 1.0).abs() < 0.15, "{found}");
        assert_eq!(samples, 512);
        assert_eq!(periods(&drive[..2040], &noisy[..2040]), None);
        assert_eq!(periods(&[1.0; 500], &[0.0; 500]), None);
    }
}
