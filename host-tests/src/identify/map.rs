//! The asymmetry map while it is fitted: piecewise linear between fixed corners, its slopes free.

/// Smallest slope of a segment, relative to the slope at zero: the map must stay invertible.
const LEAST_SLOPE: f64 = 0.05;

/// A piecewise linear increasing map through zero, one slope a segment.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Segments for arguments above zero.
    pub positive: Half,
    /// Segments for arguments below zero, as distances.
    pub negative: Half,
}

/// One side of a [`Map`].
#[derive(Clone, Debug, PartialEq)]
pub struct Half {
    /// Corners as distances from zero, increasing; may be empty.
    pub corners: Vec<f64>,
    /// Slope of each segment; one more than there are corners.
    pub slopes: Vec<f64>,
    /// Index of the first slope that is fitted; those before it keep their value.
    pub free_from: usize,
}

impl Half {
    fn new(extent: f64, corners: usize, free_from: usize) -> Self {
        let corners = if extent > 0.0 { corners } else { 0 };
        Self {
            corners: (1..=corners)
                .map(|j| extent * j as f64 / (corners + 1) as f64)
                .collect(),
            slopes: vec![1.0; corners + 1],
            free_from: if extent > 0.0 { free_from } else { 1 },
        }
    }

    /// Length of segment `k` that lies below the distance `w >= 0`.
    fn part(&self, k: usize, w: f64) -> f64 {
        let from = if k == 0 { 0.0 } else { self.corners[k - 1] };
        let to = self.corners.get(k).copied().unwrap_or(f64::INFINITY);
        (w.min(to) - from).max(0.0)
    }

    fn slope(&self, w: f64) -> f64 {
        self.slopes[self.corners.partition_point(|&corner| corner <= w)]
    }

    fn free(&self) -> impl Iterator<Item = usize> {
        self.free_from..self.slopes.len()
    }

    /// `(g_0..g_m, rho_1..rho_m)` of the dead-zone form (J 29), thresholds divided by `scale`.
    pub fn dead_zones(&self, scale: f64) -> (Vec<f64>, Vec<f64>) {
        let steps = self.slopes.windows(2).map(|pair| pair[1] - pair[0]);
        (
            std::iter::once(self.slopes[0]).chain(steps).collect(),
            self.corners.iter().map(|corner| corner / scale).collect(),
        )
    }
}

impl Map {
    /// A straight map with the given number of corners on each side that arguments reach, for
    /// arguments from `low` to `high`.
    ///
    /// The scale of the map is that of the weights before it, so the slope at zero of one side is
    /// fixed at one. A side that is reached by less than a tenth of the range has no say.
    pub fn straight(low: f64, high: f64, corners: usize) -> Self {
        let least = 0.1 * (high - low);
        let reach = |extent: f64| if extent > least { extent } else { 0.0 };
        let (above, below) = (reach(high), reach(-low));
        let both = above > 0.0 && below > 0.0;
        Self {
            positive: Half::new(above, corners, 1),
            negative: Half::new(below, corners, if both { 0 } else { 1 }),
        }
    }

    /// The value at `w`.
    pub fn value(&self, w: f64) -> f64 {
        let (half, distance, sign) = self.side(w);
        sign * (0..half.slopes.len())
            .map(|k| half.slopes[k] * half.part(k, distance))
            .sum::<f64>()
    }

    /// The slope at `w`.
    pub fn slope(&self, w: f64) -> f64 {
        let (half, distance, _) = self.side(w);
        half.slope(distance)
    }

    fn side(&self, w: f64) -> (&Half, f64, f64) {
        if w < 0.0 {
            (&self.negative, -w, -1.0)
        } else {
            (&self.positive, w, 1.0)
        }
    }

    /// How many slopes are fitted.
    pub fn free_slopes(&self) -> usize {
        self.positive.free().count() + self.negative.free().count()
    }

    /// Derivative of the value at `w` by each fitted slope.
    pub fn by_slope(&self, w: f64) -> impl Iterator<Item = f64> {
        let (above, below) = (w.max(0.0), (-w).max(0.0));
        let positive = self
            .positive
            .free()
            .map(move |k| self.positive.part(k, above));
        let negative = self
            .negative
            .free()
            .map(move |k| -self.negative.part(k, below));
        positive.chain(negative)
    }

    /// What the value at `w` would be with every fitted slope at its least value.
    pub fn floor(&self, w: f64) -> f64 {
        let mut floor = self.clone();
        floor.set_slopes(&vec![0.0; self.free_slopes()]);
        floor.value(w)
    }

    /// Sets the fitted slopes, given by what they exceed their least value.
    pub fn set_slopes(&mut self, above_least: &[f64]) {
        let mut values = above_least.iter().map(|v| LEAST_SLOPE + v);
        for half in [&mut self.positive, &mut self.negative] {
            for k in half.free_from..half.slopes.len() {
                if let Some(value) = values.next() {
                    half.slopes[k] = value;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hysteron::effect::asymmetry::{Asymmetry, Side};

    /// The dead-zone form of the core and the segments here are the same function.
    #[test]
    fn dead_zones_are_the_same_map() {
        let mut map = Map::straight(-3.0, 5.0, 2);
        map.set_slopes(&[0.4, 1.7, 0.9, 0.2, 1.1]);
        let (positive, negative) = (map.positive.dead_zones(1.0), map.negative.dead_zones(1.0));
        let core = Asymmetry::<f64, 2>::new(
            Side {
                slopes: &positive.0,
                thresholds: &positive.1,
            },
            Side {
                slopes: &negative.0,
                thresholds: &negative.1,
            },
        )
        .unwrap();
        for k in -80..=80 {
            let w = k as f64 * 0.1;
            assert!((core.step(w) - map.value(w)).abs() < 1e-12);
            let sum = map.floor(w)
                + map
                    .by_slope(w)
                    .zip([0.4, 1.7, 0.9, 0.2, 1.1])
                    .map(|(d, s)| d * s)
                    .sum::<f64>();
            assert!((sum - map.value(w)).abs() < 1e-12);
        }
    }
}
