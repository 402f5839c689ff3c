//! Elements of Bouc and Wen beside the plays, for stages whose loops are no sum of plays.
//!
//! ```text
//! w = c (u - z),   z' = u' - g |u'| z - s u' |z|
//! ```
//!
//! (R. Bouc 1967; Y.-K. Wen, *Method for random vibration of hysteretic systems*, J. Eng. Mech. Div. 102,
//! 249, 1976; exponent 1.) `u - z` lags behind the drive as a play does, but forgets gradually, and its
//! small loops neither close nor agree. `g` and `s` are in 1/V, `c` is a weight as those of the plays.
//!
//! Along a drive that goes one way and while z keeps its sign, `dz/du = 1 - k z` with
//! `k = g sign(u') + s sign(z)`, so a sample is computed exactly, in two pieces where z crosses zero:
//!
//! ```text
//! z(u + d) = 1/k + (z - 1/k) exp(-k d)
//! ```
//!
//! A fast drive is followed late, as by a play whose threshold is the rate term alone: from `beta |u'|`
//! behind.

use crate::error::{Field, ParameterError};
use crate::math::{Real, max, min};
use crate::play::Envelope;

/// Least `grow`, and least sum of `grow` and `shape`, over the magnitude of `shape`.
const LEAST_GROW: f64 = 1e-4;

/// An element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoucWen<T> {
    weight: T,
    grow: T,
    shape: T,
    /// What z stays within, in V.
    bound: T,
}

/// State of an element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoucWenState<T> {
    /// z in V.
    pub z: T,
    /// The drive that it has followed, in V.
    pub followed: T,
}

impl<T: Real> BoucWen<T> {
    /// An element of `weight` (V/V) with `grow` and `shape` in 1/V.
    ///
    /// # Errors
    /// Numbers that are not finite, a weight below zero, a `grow` that is not positive, hardly larger than
    /// `-shape` or vanishes beside it: z would not stay bounded.
    pub fn new(weight: T, grow: T, shape: T) -> Result<Self, ParameterError> {
        let numbers = [
            (weight, Field::Weights),
            (grow, Field::Grow),
            (shape, Field::Shape),
        ];
        for (number, field) in numbers {
            if !number.is_finite() {
                return Err(ParameterError::NotFinite(field, 0));
            }
        }
        if weight < T::ZERO {
            return Err(ParameterError::Negative(Field::Weights));
        }
        let least = T::from_f64(LEAST_GROW) * shape.abs();
        if grow <= least || grow + shape <= least {
            return Err(ParameterError::TooSmall(Field::Grow));
        }
        let bound = T::ONE / (grow + shape);
        if bound <= T::ZERO || !bound.is_finite() {
            return Err(ParameterError::NotFinite(Field::Grow, 0));
        }
        Ok(Self {
            weight,
            grow,
            shape,
            bound,
        })
    }

    /// Before anything moved it: z = 0 at 0 V.
    pub fn start(&self) -> BoucWenState<T> {
        BoucWenState {
            z: T::ZERO,
            followed: T::ZERO,
        }
    }

    /// What it adds to the output of the plays (V) at the next drive sample within its `envelope`, from
    /// `lo` to `hi`.
    #[inline(always)]
    pub fn step(&self, state: &mut BoucWenState<T>, input: T, envelope: Envelope<T>) -> T {
        let followed = min(max(state.followed, envelope.lo), envelope.hi);
        state.z = self.advance(state.z, followed - state.followed);
        state.followed = followed;
        self.weight * (input - state.z)
    }

    /// z after the drive has gone on by `way`.
    pub fn advance(&self, z: T, way: T) -> T {
        let z = self.followed(z, way);
        max(min(z, self.bound), -self.bound)
    }

    fn followed(&self, z: T, way: T) -> T {
        let k = self.rate(z, way);
        if z * way < T::ZERO {
            // Where z arrives at zero: (1 - k z) exp(k d) = 1.
            let kz = k * z;
            let zero = if kz.abs() < T::EPSILON {
                -z
            } else {
                (-kz).ln_1p() / k
            };
            if zero.abs() < way.abs() {
                return along(self.rate(T::ZERO, way), T::ZERO, way - zero);
            }
        }
        along(k, z, way)
    }

    /// Steepest fall of the output against the drive: what the other weights must exceed where a stage is
    /// to be inverted.
    pub fn fall(&self) -> T {
        self.weight * max(self.grow - self.shape, T::ZERO) / (self.grow + self.shape)
    }

    /// c, the weight of the element.
    pub fn weight(&self) -> T {
        self.weight
    }

    fn rate(&self, z: T, way: T) -> T {
        let forwards = way >= T::ZERO;
        let grow = if forwards { self.grow } else { -self.grow };
        let positive = z > T::ZERO || (z == T::ZERO && forwards);
        grow + if positive { self.shape } else { -self.shape }
    }
}

/// Solution of `dz/du = 1 - k z` after `way`.
fn along<T: Real>(k: T, z: T, way: T) -> T {
    let x = k * way;
    if x.abs() < T::EPSILON {
        return z + (T::ONE - k * z) * way;
    }
    z - (T::ONE / k - z) * (-x).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the equation in a million small steps a stretch.
    #[test]
    fn steps_solve_the_equation() {
        for (grow, shape) in [(0.3, 0.15), (0.3, -0.2), (1.1, 1.8), (0.05, 0.0)] {
            let element = BoucWen::new(1.0_f64, grow, shape).unwrap();
            let (mut z, mut fine) = (0.0, 0.0_f64);
            for way in [5.0, -0.3, -9.0, 4.0, 12.0, -20.0, 1e-7, 0.0] {
                z = element.advance(z, way);
                let step: f64 = way / 1e6;
                for _ in 0..1_000_000 {
                    fine += step - grow * step.abs() * fine - shape * step * fine.abs();
                }
                assert!((z - fine).abs() < 1e-4 * (1.0 + fine.abs()), "{z} {fine}");
            }
            // Bounded by where both terms hold the growth.
            let top = element.advance(z, 1e6);
            assert!((top * (grow + shape) - 1.0).abs() < 1e-9, "{top}");
        }
    }

    #[test]
    fn single_precision_is_close() {
        let (double, single) = (
            BoucWen::new(1.0_f64, 0.4, 0.1).unwrap(),
            BoucWen::new(1.0_f32, 0.4, 0.1).unwrap(),
        );
        let (mut z, mut z32) = (0.0, 0.0_f32);
        for k in 0..10_000 {
            let way = 0.05 * f64::sin(f64::from(k) * 0.01);
            z = double.advance(z, way);
            z32 = single.advance(z32, way as f32);
            assert!((z - f64::from(z32)).abs() < 1e-4, "{k}: {z} {z32}");
        }
    }

    #[test]
    fn what_would_run_away_is_refused() {
        for (weight, grow, shape) in [
            (-1.0, 1.0, 0.0),
            (1.0, 0.0, 0.5),
            (1.0, 0.5, -0.5),
            (f64::NAN, 1.0, 0.0),
            (1.0, f64::INFINITY, 0.0),
            (1.0, 1e308, 1e308),
            (1.0, 1e-17, 100.0),
            (1.0, 1e-310, 0.0),
        ] {
            assert!(BoucWen::new(weight, grow, shape).is_err());
        }
    }

    /// The steepest fall is that right after the drive turns, with z at its bound.
    #[test]
    fn the_fall_is_found_at_a_turning_point() {
        let element = BoucWen::new(0.5_f64, 0.4, 0.1).unwrap();
        let top = element.advance(0.0, 1e6);
        let step = -1e-6;
        let slope = 0.5 * (1.0 - (element.advance(top, step) - top) / step);
        assert!((slope + element.fall()).abs() < 1e-6, "{slope}");
    }
}
