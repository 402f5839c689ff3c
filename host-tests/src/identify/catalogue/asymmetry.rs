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

/// How many numbers there are of each kind.
struct Layout {
    positive: usize,
    negative: usize,
    /// Whether the sides have slopes of their own at zero.
    both: usize,
}

impl Layout {
    /// Of so many zones on each of the sides wanted.
    fn of(zones: usize, positive: bool, negative: bool) -> Self {
        Self {
            positive: if positive { zones } else { 0 },
            negative: if negative { zones } else { 0 },
            both: usize::from(positive && negative),
        }
    }

    /// That of a fit: of the sides that are reached.
    fn new(seen: &Seen) -> Self {
        let (positive, negative) = reached(seen);
        Self::of(ZONES, positive, negative)
    }

    /// That of `count` numbers: four for a zone and one more where there are two sides, else two for
    /// one of the side that is reached.
    fn counted(count: usize, seen: &Seen) -> Self {
        let (positive, negative) = reached(seen);
        if count % 2 == 1 {
            Self::of(count / 4, true, true)
        } else if positive {
            Self::of(count / 2, true, false)
        } else {
            Self::of(count / 2, false, negative)
        }
    }

    fn slopes(&self) -> usize {
        self.positive + self.negative + self.both
    }
}

/// Whether the sides are reached, positive and negative.
fn reached(seen: &Seen) -> (bool, bool) {
    let least = REACHED * 2.0 * seen.displacement_um;
    (seen.line_um.1 >= least, -seen.line_um.0 >= least)
}

/// How far the sides reach in um; one that is hardly reached, as far as it would have to.
fn reach(seen: &Seen) -> (f64, f64) {
    let least = REACHED * 2.0 * seen.displacement_um;
    (seen.line_um.1.max(least), (-seen.line_um.0).max(least))
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
        let slopes = Layout::counted(numbers.len(), seen).slopes();
        let bound = |i| if i < slopes { (-0.9, 1.5) } else { CORNERS };
        (0..numbers.len()).map(bound).collect()
    }

    fn stage(&self, numbers: &[f64], seen: &Seen, gain: f64) -> Option<Stage> {
        let layout = Layout::counted(numbers.len(), seen);
        let (more, rest) = numbers.split_at_checked(layout.positive)?;
        let (less, rest) = rest.split_at_checked(layout.negative)?;
        let (base, rest) = rest.split_at_checked(layout.both)?;
        let (above, below) = rest.split_at_checked(layout.positive)?;
        let reach = reach(seen);
        let positive = side(1.0, more, above, reach.0 / gain);
        let first = 1.0 + base.first().copied().unwrap_or(0.0);
        let negative = side(first, less, below, reach.1 / gain);
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

    fn numbers(&self, stage: &Stage, seen: &Seen, gain: f64) -> Option<Vec<f64>> {
        let Stage::Asymmetry(map) = stage else {
            return None;
        };
        let (corners, slopes) = (&map.thresholds, &map.slopes);
        let zones = corners.positive.len().max(corners.negative.len());
        let (positive, negative) = reached(seen);
        // The slope of the positive side at zero is one: the gain has it.
        let first = *slopes.positive.first()?;
        let below = *slopes.negative.first()? / first - 1.0;
        // A side that is not reached is kept where it is not straight.
        let bent = |corners: &[f64]| !corners.is_empty() || below != 0.0;
        let layout = Layout::of(
            zones.max(ZONES),
            positive || bent(&corners.positive),
            negative || bent(&corners.negative),
        );
        let reach = reach(seen);
        let padded = |numbers: &[f64], scale: f64, zones: usize, idle: fn(f64) -> f64| {
            let more = numbers.len()..zones.max(numbers.len());
            let more = more.map(|i| idle((i + 1) as f64 / (zones + 1) as f64));
            let own = numbers.iter().map(|x| x * scale);
            own.chain(more).collect::<Vec<f64>>()
        };
        let mut numbers = padded(
            slopes.positive.get(1..)?,
            1.0 / first,
            layout.positive,
            |_| 0.0,
        );
        let less = slopes.negative.get(1..)?;
        numbers.extend(padded(less, 1.0 / first, layout.negative, |_| 0.0));
        if layout.both == 1 {
            numbers.push(below);
        }
        let above = gain / reach.0;
        numbers.extend(padded(&corners.positive, above, layout.positive, |at| at));
        let beneath = gain / reach.1;
        numbers.extend(padded(&corners.negative, beneath, layout.negative, |at| at));
        Some(numbers)
    }
}
