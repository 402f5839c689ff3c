//! Even curvature behind the hysteresis (`quadratic`): `y = w + q w^2`.
//!
//! The map has an inverse while `1 + 2 q w > 0`; on that branch
//! `w = 2 y / (1 + sqrt(1 + 4 q y))`. The inverse here is Newton's iteration for it from `w = y`, of a
//! fixed number of steps, which needs no square root; its error after them, for a slope of the map
//! between a half and two, is below 1e-9 of `y`. Beyond the branch both directions go on along the
//! tangent at the slope [`SLOPE_LEAST`], so that they stay monotone and each other's inverse.

use crate::error::{Field, ParameterError};
use crate::math::Real;

/// Least slope of the map: beyond its place the map is a straight line of this slope.
pub const SLOPE_LEAST: f64 = 0.1;
/// `q w` there.
const EDGE_BEND: f64 = 0.5 * (SLOPE_LEAST - 1.0);

/// The map for one `q`, in 1/V.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadratic<T> {
    q: T,
    /// Where the slope is [`SLOPE_LEAST`]; of no account for `q = 0`.
    edge: T,
}

impl<T: Real> Quadratic<T> {
    /// The map.
    ///
    /// # Errors
    /// A `q` that is not finite.
    pub fn new(q: T) -> Result<Self, ParameterError> {
        if q.is_finite() {
            // q w_l = (least - 1) / 2
            let edge = T::from_f64(EDGE_BEND) / q;
            Ok(Self { q, edge })
        } else {
            Err(ParameterError::NotFinite(Field::Quadratic, 0))
        }
    }

    /// `w + q w^2`, continued by a line.
    #[inline(always)]
    pub fn step(&self, w: T) -> T {
        let least = T::from_f64(SLOPE_LEAST);
        let bend = self.q * w;
        let slope = T::ONE + bend + bend;
        if slope >= least {
            w + bend * w
        } else {
            self.edge + T::from_f64(EDGE_BEND) * self.edge + least * (w - self.edge)
        }
    }

    /// Slope of the map at `w`, `1 + 2 q w` or [`SLOPE_LEAST`].
    #[inline(always)]
    pub fn slope(&self, w: T) -> T {
        let bend = self.q * w;
        let slope = T::ONE + bend + bend;
        crate::math::max(slope, T::from_f64(SLOPE_LEAST))
    }

    /// `w` for which [`Quadratic::step`] is `y`.
    #[inline(always)]
    pub fn step_inverse(&self, y: T) -> T {
        super::newton(y, |w| (self.step(w), self.slope(w)))
    }
}
