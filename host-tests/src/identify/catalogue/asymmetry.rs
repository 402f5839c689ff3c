//! Asymmetry: what each dead zone adds to the slope of its side, and the slope of the negative side at
//! zero less one.
//!
//! Corners lie at even shares of each side's range; a side that is hardly reached has none.

use crate::model_file::{self, Stage, TwoSided};

use super::{Seen, Template};

/// Dead zones of a side.
const ZONES: usize = 4;
/// Share of the whole range that a side must reach to have a say.
const REACHED: f64 = 0.1;

/// See the [module](self).
pub struct Asymmetry;

/// Corners of a side that reaches to `end` um.
fn corners(end: f64, seen: &Seen) -> Vec<f64> {
    if end < REACHED * 2.0 * seen.displacement_um {
        return Vec::new();
    }
    (1..=ZONES)
        .map(|i| end * i as f64 / (ZONES + 1) as f64)
        .collect()
}

/// Corners of both sides, in um.
fn sides(seen: &Seen) -> (Vec<f64>, Vec<f64>) {
    (
        corners(seen.line_um.1, seen),
        corners(-seen.line_um.0, seen),
    )
}

impl Template for Asymmetry {
    fn name(&self) -> &'static str {
        "asymmetry"
    }

    fn starts(&self, seen: &Seen) -> Vec<Vec<f64>> {
        let (positive, negative) = sides(seen);
        let both = usize::from(!positive.is_empty() && !negative.is_empty());
        vec![vec![0.0; positive.len() + negative.len() + both]]
    }

    fn bounds(&self, _seen: &Seen, numbers: &[f64]) -> Vec<(f64, f64)> {
        vec![(-0.6, 1.5); numbers.len()]
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, gain: f64) -> Option<Stage> {
        let (positive, negative) = sides(seen);
        let in_volts = |corners: &[f64]| corners.iter().map(|um| um / gain).collect();
        let (more, rest) = numbers.split_at_checked(positive.len())?;
        let (less, base) = rest.split_at_checked(negative.len())?;
        let slopes = |first: f64, more: &[f64]| {
            let mut slopes = vec![first];
            slopes.extend_from_slice(more);
            slopes
        };
        Some(Stage::Asymmetry(model_file::Asymmetry {
            thresholds: TwoSided {
                positive: in_volts(&positive),
                negative: in_volts(&negative),
            },
            slopes: TwoSided {
                positive: slopes(1.0, more),
                negative: slopes(1.0 + base.first().copied().unwrap_or(0.0), less),
            },
        }))
    }
}
