//! Odd curvature behind the hysteresis (`cubic`): `y = w + c w^3`.
//!
//! Monotone everywhere for `c >= 0`, and for `c < 0` while `1 + 3 c w^2 > 0`; beyond the place where
//! the slope is [`SLOPE_LEAST`] both directions go on along the tangent there. The inverse is
//! Newton's iteration from `w = y`, of a fixed number of steps.

pub use super::quadratic::SLOPE_LEAST;
use crate::error::{Field, ParameterError};
use crate::math::{Real, sqrt};

/// The map for one `c`, in 1/V^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic<T> {
    c: T,
    /// Where the slope is least; infinite for `c >= 0`.
    edge: T,
}

impl<T: Real> Cubic<T> {
    /// The map.
    ///
    /// # Errors
    /// A `c` that is not finite.
    pub fn new(c: T) -> Result<Self, ParameterError> {
        if !c.is_finite() {
            return Err(ParameterError::NotFinite(Field::Cubic, 0));
        }
        let edge = if c < T::ZERO {
            T::from_f64(sqrt((SLOPE_LEAST - 1.0) / (3.0 * c.to_f64())))
        } else {
            T::INFINITY
        };
        Ok(Self { c, edge })
    }

    /// `w + c w^3`, continued by lines.
    #[inline(always)]
    pub fn step(&self, w: T) -> T {
        let bend = |w: T| w + self.c * w * w * w;
        if w > self.edge {
            bend(self.edge) + T::from_f64(SLOPE_LEAST) * (w - self.edge)
        } else if w < -self.edge {
            bend(-self.edge) + T::from_f64(SLOPE_LEAST) * (w + self.edge)
        } else {
            bend(w)
        }
    }

    /// Slope of the map at `w`.
    #[inline(always)]
    pub fn slope(&self, w: T) -> T {
        if w.abs() > self.edge {
            T::from_f64(SLOPE_LEAST)
        } else {
            T::ONE + T::from_f64(3.0) * self.c * w * w
        }
    }

    /// `w` for which [`Cubic::step`] is `y`.
    #[inline(always)]
    pub fn step_inverse(&self, y: T) -> T {
        super::newton(y, |w| (self.step(w), self.slope(w)))
    }
}
