//! Checks that a column of times is a uniform grid, and measures its step.
//!
//! Times printed with few digits jitter by a part of the step, and a clock may be off by some parts
//! in a million; both are let through. Lost, doubled and reordered samples are not.

use crate::error::{Error, Place};
use crate::table::LineMap;

/// A step may differ from the mean step by this share of it.
const STEP_TOLERANCE: f64 = 0.05;
/// A step that differs from the median step by more than this share is a lost or extra sample. It is
/// looked for first, because a lost sample also shifts the mean of a short record.
const GAP_TOLERANCE: f64 = 0.25;
/// A time may stray from the straight line through the first and the last by this many steps ...
const STRAY_STEPS: f64 = 0.5;
/// ... plus this share of the record's duration, so that long records may have a drifting clock.
const CLOCK_TOLERANCE: f64 = 1e-4;

/// The mean step in seconds of strictly increasing, uniform times; at least two are needed.
///
/// `place` is the file and `column` the time column's name, for messages; `lines` gives each row's
/// line.
pub(crate) fn uniform_step(
    time_s: &[f64],
    lines: &LineMap,
    place: &Place,
    column: &str,
) -> Result<f64, Error> {
    let refuse = |row: usize, problem: String| {
        Err(place
            .clone()
            .line(lines.line(row))
            .column(column)
            .error(problem))
    };
    let steps = || time_s.windows(2).map(|pair| pair[1] - pair[0]);

    if let Some(at) = steps().position(|step| step <= 0.0) {
        let (before, after) = (time_s[at], time_s[at + 1]);
        return refuse(at + 1, not_after(before, after));
    }

    let (Some(&first), Some(&last)) = (time_s.first(), time_s.last()) else {
        return Err(place
            .clone()
            .error("there is no row of numbers; add at least two"));
    };
    let mean = (last - first) / (time_s.len().max(2) - 1) as f64;
    if !(mean > 0.0 && mean.is_finite()) {
        return Err(place.clone().column(column).error(format!(
            "no step can be told from the times {first} s to {last} s; record at least two rows"
        )));
    }
    let mut sorted: Vec<f64> = steps().collect();
    let middle = sorted.len() / 2;
    let median = *sorted.select_nth_unstable_by(middle, f64::total_cmp).1;
    drop(sorted);

    for (expected, tolerance) in [(median, GAP_TOLERANCE), (mean, STEP_TOLERANCE)] {
        if let Some(at) = steps().position(|step| (step - expected).abs() > tolerance * expected) {
            let step = time_s[at + 1] - time_s[at];
            return refuse(at + 1, uneven(step, expected));
        }
    }

    let stray = |row: usize| time_s[row] - (first + mean * row as f64);
    let worst = (0..time_s.len()).max_by(|&a, &b| stray(a).abs().total_cmp(&stray(b).abs()));
    match worst.map(|row| (row, stray(row).abs())) {
        Some((row, off)) if off > most_stray(mean, last - first) => {
            refuse(row, off_grid(off, mean))
        }
        _ => Ok(mean),
    }
}

/// Whether a step is too far off the mean step.
pub(crate) fn is_uneven(step: f64, mean: f64) -> bool {
    (step - mean).abs() > STEP_TOLERANCE * mean
}

/// How far a time may stray from the grid of a record of so many seconds, in s.
pub(crate) fn most_stray(mean: f64, duration: f64) -> f64 {
    STRAY_STEPS * mean + CLOCK_TOLERANCE * duration
}

/// What is wrong with a time that is not later than the one before.
pub(crate) fn not_after(before: f64, after: f64) -> String {
    if after == before {
        format!("the time {after} s is that of the row before; remove the repeated row")
    } else {
        format!("the time goes back from {before} s to {after} s; put the rows in order of time")
    }
}

/// What is wrong with a step.
pub(crate) fn uneven(step: f64, expected: f64) -> String {
    format!(
        "the time steps by {} s here and by {} s elsewhere; the samples must be uniform: split the \
         record at the gap or resample it",
        short(step),
        short(expected),
    )
}

/// What is wrong with a time that strays.
pub(crate) fn off_grid(off: f64, mean: f64) -> String {
    format!(
        "the time is {} s off a uniform grid of {} s; the sample rate changes within the record: \
         split it there or resample it",
        short(off),
        short(mean),
    )
}

/// Six significant digits, without the noise of a difference of two times.
fn short(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
