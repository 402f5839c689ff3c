//! Elements of Bouc and Wen while they are fitted: on a grid that grows finer around those with weight.

use hysteron::hysteresis::bouc_wen::{BoucWen, BoucWenState};
use hysteron::play::Envelope;

/// One element, but for its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element {
    /// `grow` in 1/V.
    pub grow_per_v: f64,
    /// `shape / grow`.
    pub ratio: f64,
    /// How far neighbours on the grid are: factor of `grow`, and in `ratio`.
    spacing: (f64, f64),
}

/// Products of `grow` and half the range of the drive in the first look, and the factor between them.
const GROWS: [f64; 6] = [0.7, 1.4, 2.8, 5.6, 11.0, 22.0];
const FACTOR: f64 = 2.0;
/// Values of `ratio` in the first look, and the distance between them.
const RATIOS: [f64; 5] = [-0.6, -0.2, 0.2, 0.6, 1.0];
const DISTANCE: f64 = 0.4;
/// Values of `ratio` at most either way.
const BOUND: (f64, f64) = (-0.95, 2.0);

impl Element {
    /// Elements for a first look at a drive of this range.
    pub fn menu(range_v: f64) -> Vec<Self> {
        let half = 0.5 * range_v;
        let of = |grow: f64| {
            RATIOS.map(|ratio| Self {
                grow_per_v: grow / half,
                ratio,
                spacing: (FACTOR, DISTANCE),
            })
        };
        GROWS.into_iter().flat_map(of).collect()
    }

    /// An element that is known already, for a close look.
    pub fn known(grow_per_v: f64, shape_per_v: f64) -> Self {
        Self {
            grow_per_v,
            ratio: shape_per_v / grow_per_v,
            spacing: (FACTOR.sqrt(), 0.5 * DISTANCE),
        }
    }

    /// `shape` in 1/V.
    pub fn shape_per_v(&self) -> f64 {
        self.ratio * self.grow_per_v
    }

    /// The element among neighbours at half the distance.
    pub fn closer(self) -> impl Iterator<Item = Self> {
        let (factor, distance) = (self.spacing.0.sqrt(), 0.5 * self.spacing.1);
        let steps = [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)];
        steps.into_iter().map(move |(grow, ratio)| Self {
            grow_per_v: self.grow_per_v * factor.powi(grow),
            ratio: (self.ratio + distance * f64::from(ratio)).clamp(BOUND.0, BOUND.1),
            spacing: (factor, distance),
        })
    }

    /// Whether two elements are the same on the finer one's grid.
    pub fn is_near(&self, other: &Self) -> bool {
        self.distance(other) < 0.5
    }

    /// Distance of two elements on the finer one's grid.
    fn distance(&self, other: &Self) -> f64 {
        let (factor, distance) = self.finer(other);
        let grow = (self.grow_per_v / other.grow_per_v).ln() / factor.ln();
        let ratio = (self.ratio - other.ratio) / distance;
        grow.abs().max(ratio.abs())
    }

    fn finer(&self, other: &Self) -> (f64, f64) {
        let (a, b) = (self.spacing, other.spacing);
        (a.0.min(b.0), a.1.min(b.1))
    }

    /// What stands for two elements with weights.
    fn between((a, weight_a): (Self, f64), (b, weight_b): (Self, f64)) -> (Self, f64) {
        let share = weight_b / (weight_a + weight_b);
        let element = Self {
            grow_per_v: a.grow_per_v * (b.grow_per_v / a.grow_per_v).powf(share),
            ratio: a.ratio + (b.ratio - a.ratio) * share,
            spacing: a.finer(&b),
        };
        (element, weight_a + weight_b)
    }

    /// At most so many elements in place of those given, with their weights: the nearest two are replaced
    /// by one between them, again and again.
    pub fn merged(mut all: Vec<(Self, f64)>, most: usize) -> Vec<Self> {
        while all.len() > most.max(1) {
            let mut nearest = (f64::INFINITY, 0, 1);
            for i in 0..all.len() {
                for j in i + 1..all.len() {
                    let distance = all[i].0.distance(&all[j].0);
                    if distance < nearest.0 {
                        nearest = (distance, i, j);
                    }
                }
            }
            let second = all.remove(nearest.2);
            all[nearest.1] = Self::between(all[nearest.1], second);
        }
        all.into_iter().map(|(element, _)| element).collect()
    }
}

/// Elements on their way along a drive.
pub struct Moving {
    elements: Vec<(BoucWen<f64>, BoucWenState<f64>, f64)>,
    drive_v: f64,
}

impl Moving {
    /// At rest where nothing has moved them, then led to the first sample.
    pub fn new(elements: &[Element], weights: &[f64], first_v: f64) -> Self {
        let moved = elements.iter().zip(weights).filter_map(|(element, &a)| {
            // The bounds of the grid keep it valid.
            let block = BoucWen::new(1.0, element.grow_per_v, element.shape_per_v()).ok()?;
            let mut state = block.start();
            block.step(&mut state, first_v, Envelope::closed(first_v));
            Some((block, state, a))
        });
        Self {
            elements: moved.collect(),
            drive_v: first_v,
        }
    }

    /// Where they stand, to go on from.
    pub fn state(&self) -> impl Iterator<Item = f64> {
        let states = self.elements.iter();
        states.flat_map(|(_, state, _)| [state.z, state.followed])
    }

    /// Goes on from there.
    pub fn set(&mut self, mut state: impl Iterator<Item = f64>) {
        for (_, at, _) in &mut self.elements {
            at.z = state.next().unwrap_or(at.z);
            at.followed = state.next().unwrap_or(at.followed);
        }
    }

    /// Follows the drive.
    pub fn step(&mut self, drive_v: f64, envelope: Envelope<f64>) {
        for (element, state, _) in &mut self.elements {
            element.step(state, drive_v, envelope);
        }
        self.drive_v = drive_v;
    }

    /// Their outputs in volts.
    pub fn outputs(&self) -> impl Iterator<Item = f64> {
        let states = self.elements.iter();
        states.map(|(_, state, _)| self.drive_v - state.z)
    }

    /// Sum of the outputs with their weights.
    pub fn sum(&self) -> f64 {
        let states = self.elements.iter();
        states
            .map(|(_, state, a)| a * (self.drive_v - state.z))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merging_keeps_what_lies_apart() {
        let at = |grow_per_v: f64, ratio: f64| Element::known(grow_per_v, ratio * grow_per_v);
        let all = vec![
            (at(1.0, 0.0), 1.0),
            (at(9.0, 0.5), 2.0),
            (at(1.2, 0.1), 3.0),
        ];
        let two = Element::merged(all, 2);
        assert_eq!(two.len(), 2);
        assert!((two[0].grow_per_v - 1.2_f64.powf(0.75)).abs() < 1e-12);
        assert!((two[0].ratio - 0.075).abs() < 1e-12);
        assert_eq!(two[1], at(9.0, 0.5));
    }
}
