//! Asymmetry: what each dead zone adds to the slope of its side, the slope of the negative side at zero
//! less one, and the corners over the reach of their side.
//!
//! A side that is hardly reached has no corners.

use crate::model_file::{self, Stage, TwoSided};

use super::{Seen, Template};

/// Dead zones of a side.
const ZONES: usize = 3;
/// Share of the whole range that a side must reach to have a say.
const REACHED: f64 = 0.1;
/// Least and largest corner over the reach of its side.
const CORNERS: (f64, f64) = (0.01, 0.99);

/// Least distance of two corners over the reach.
const APART: f64 = 1e-3;

/// See the [module](self).
pub struct Asymmetry;

/// Dead zones of a side that reaches to `end` um.
fn zones(end: f64, seen: &Seen) -> usize {
    if end < REACHED * 2.0 * seen.displacement_um {
        0
    } else {
        ZONES
    }
}

/// How many numbers there are of each kind.
struct Layout {
    positive: usize,
    negative: usize,
    /// Whether the sides have slopes of their own at zero.
    both: usize,
}

impl Layout {
    fn new(seen: &Seen) -> Self {
        let positive = zones(seen.line_um.1, seen);
        let negative = zones(-seen.line_um.0, seen);
        Self {
            positive,
            negative,
            both: usize::from(positive > 0 && negative > 0),
        }
    }

    fn slopes(&self) -> usize {
        self.positive + self.negative + self.both
    }
}

/// Corners in volts, rising, and slopes of a side.
fn side(first: f64, slopes: &[f64], corners: &[f64], reach_v: f64) -> (Vec<f64>, Vec<f64>) {
    let mut zones: Vec<(f64, f64)> = corners
        .iter()
        .copied()
        .zip(slopes.iter().copied())
        .collect();
    zones.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut least = 0.0;
    for (corner, _) in &mut zones {
        *corner = corner.max(least);
        least = *corner + APART;
    }
    let slopes = std::iter::once(first).chain(zones.iter().map(|zone| zone.1));
    let corners = zones.iter().map(|zone| zone.0 * reach_v);
    (corners.collect(), slopes.collect())
}

impl Template for Asymmetry {
    fn name(&self) -> &'static str {
        "asymmetry"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        let layout = Layout::new(seen);
        let even = |zones: usize| (1..=zones).map(move |i| i as f64 / (zones + 1) as f64);
        let mut numbers = vec![0.0; layout.slopes()];
        numbers.extend(even(layout.positive).chain(even(layout.negative)));
        vec![numbers]
    }

    fn bounds(&self, seen: &Seen, numbers: &[f64]) -> Vec<(f64, f64)> {
        let slopes = Layout::new(seen).slopes();
        let bound = |i| if i < slopes { (-0.9, 1.5) } else { CORNERS };
        (0..numbers.len()).map(bound).collect()
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, gain: f64) -> Option<Stage> {
        let layout = Layout::new(seen);
        let (more, rest) = numbers.split_at_checked(layout.positive)?;
        let (less, rest) = rest.split_at_checked(layout.negative)?;
        let (base, rest) = rest.split_at_checked(layout.both)?;
        let (above, below) = rest.split_at_checked(layout.positive)?;
        let positive = side(1.0, more, above, seen.line_um.1 / gain);
        let first = 1.0 + base.first().copied().unwrap_or(0.0);
        let negative = side(first, less, below, -seen.line_um.0 / gain);
        Some(Stage::Asymmetry(model_file::Asymmetry {
            thresholds: TwoSided {
                positive: positive.0,
                negative: negative.0,
            },
            slopes: TwoSided {
                positive: positive.1,
                negative: negative.1,
            },
        }))
    }
}
