//! What the two lags share: the number is the logarithm of the time constant in samples.

use super::{Seen, spread};

pub(super) fn starts(seen: &Seen) -> Vec<Vec<f64>> {
    spread(1.0, 0.01 * seen.duration_s / seen.sample_time_s, 3)
        .map(|samples| vec![samples.max(1.0).ln()])
        .collect()
}

pub(super) fn bounds(seen: &Seen) -> Vec<(f64, f64)> {
    let longest = 0.2 * seen.duration_s / seen.sample_time_s;
    vec![(0.03f64.ln(), longest.max(1.0).ln())]
}

/// The time constant in seconds.
pub(super) fn tau_s(numbers: &[f64], seen: &Seen) -> Option<f64> {
    let &[x] = numbers else { return None };
    Some(x.exp() * seen.sample_time_s)
}

/// The number of a time constant.
pub(super) fn numbers(tau_s: f64, seen: &Seen) -> Vec<f64> {
    vec![(tau_s / seen.sample_time_s).ln()]
}
