//! Asymmetry: a strictly increasing memoryless map behind the hysteresis, as dead-zone banks.
//!
//! ```text
//! Lambda(w) = sum g_i S_i(w),  S_i(w) = max(w - rho_i, 0)  for w >= 0         (J 29, 30)
//! ```
//!
//! and a second set of slopes and thresholds for `w < 0` with `S_i(w) = min(w + rho_i, 0)`;
//! `rho_0 = 0` on both sides. With the partial sums `G_i = g_0 + ... + g_i`, all positive, the
//! inverse is a map of the same kind (J 31 to 33, which mix the letters Lambda, Gamma, g, delta):
//!
//! ```text
//! rho'_i = sum_(j <= i) g_j (rho_i - rho_j),   g'_0 = 1 / g_0,   g'_i = -g_i / (G_i G_(i-1))
//! ```

use crate::error::{Field, ParameterError};
use crate::math::{Real, max};

/// Parameters of one side of the map, as they are identified and stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side<'a, T> {
    /// `g_0..g_m`, output unit over input unit: one entry more than there are thresholds.
    pub slopes: &'a [T],
    /// `rho_1..rho_m` as distances from zero, positive and increasing; may be empty.
    pub thresholds: &'a [T],
}

/// The map, with up to `M` dead zones on each side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asymmetry<T, const M: usize> {
    positive: DeadZones<T, M>,
    negative: DeadZones<T, M>,
}

/// One side of the map for an argument `>= 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DeadZones<T, const M: usize> {
    len: usize,
    slope_0: T,
    slopes: [T; M],
    thresholds: [T; M],
}

impl<T: Real, const M: usize> Asymmetry<T, M> {
    /// The map from its two sides.
    ///
    /// # Errors
    /// Names the side and field: non-finite entries, unequal lengths or more than `M` thresholds,
    /// thresholds that do not increase, a partial sum of slopes that is not positive (the map would
    /// not be monotone).
    pub fn new(positive: Side<'_, T>, negative: Side<'_, T>) -> Result<Self, ParameterError> {
        let positive = DeadZones::new(positive, Field::PositiveSlopes, Field::PositiveThresholds)?;
        let negative = DeadZones::new(negative, Field::NegativeSlopes, Field::NegativeThresholds)?;
        Ok(Self { positive, negative })
    }

    /// `Lambda(w)`.
    #[inline(always)]
    pub fn step(&self, w: T) -> T {
        if w < T::ZERO {
            -self.negative.eval(-w)
        } else {
            self.positive.eval(w)
        }
    }

    /// The inverse map.
    ///
    /// # Errors
    /// A slope or threshold of the inverse that leaves the range of `T`.
    pub fn inverse(&self) -> Result<Self, ParameterError> {
        Ok(Self {
            positive: self
                .positive
                .inverse(Field::PositiveSlopes, Field::PositiveThresholds)?,
            negative: self
                .negative
                .inverse(Field::NegativeSlopes, Field::NegativeThresholds)?,
        })
    }
}

impl<T: Real, const M: usize> DeadZones<T, M> {
    fn new(
        side: Side<'_, T>,
        slopes_field: Field,
        thresholds_field: Field,
    ) -> Result<Self, ParameterError> {
        let Some((&slope_0, slopes)) = side.slopes.split_first() else {
            return Err(ParameterError::Length(slopes_field));
        };
        let len = side.thresholds.len();
        if len > M {
            return Err(ParameterError::Length(thresholds_field));
        }
        if slopes.len() != len {
            return Err(ParameterError::Length(slopes_field));
        }
        let mut partial_sum = T::ZERO;
        for (i, &slope) in side.slopes.iter().enumerate() {
            partial_sum = partial_sum + slope;
            if !partial_sum.is_finite() {
                return Err(ParameterError::NotFinite(slopes_field, i));
            }
            if partial_sum <= T::ZERO {
                return Err(ParameterError::PartialSum(slopes_field, i));
            }
        }
        let mut before = T::ZERO;
        for (i, &threshold) in side.thresholds.iter().enumerate() {
            if !threshold.is_finite() {
                return Err(ParameterError::NotFinite(thresholds_field, i));
            }
            if threshold <= before {
                return Err(ParameterError::NotIncreasing(thresholds_field, i));
            }
            before = threshold;
        }
        let mut zones = Self {
            len,
            slope_0,
            slopes: [T::ZERO; M],
            thresholds: [T::ZERO; M],
        };
        zones
            .slopes
            .iter_mut()
            .zip(slopes)
            .for_each(|(to, &from)| *to = from);
        zones
            .thresholds
            .iter_mut()
            .zip(side.thresholds)
            .for_each(|(to, &from)| *to = from);
        Ok(zones)
    }

    #[inline(always)]
    fn eval(&self, w: T) -> T {
        let mut sum = self.slope_0 * w;
        for (&slope, &threshold) in self.slopes.iter().zip(&self.thresholds).take(self.len) {
            sum = sum + slope * max(w - threshold, T::ZERO);
        }
        sum
    }

    fn inverse(
        &self,
        slopes_field: Field,
        thresholds_field: Field,
    ) -> Result<Self, ParameterError> {
        let mut inverse = *self;
        let mut partial_sum = self.slope_0;
        inverse.slope_0 = T::ONE / self.slope_0;
        if !inverse.slope_0.is_finite() {
            return Err(ParameterError::NotFinite(slopes_field, 0));
        }
        let rows = inverse.slopes.iter_mut().zip(&mut inverse.thresholds);
        let zones = self.slopes.iter().zip(&self.thresholds).take(self.len);
        for (i, ((inverse_slope, inverse_threshold), (&slope, &threshold))) in
            rows.zip(zones).enumerate()
        {
            // sum_(j <= i) g_j (rho_i - rho_j) is the map itself at its corner.
            *inverse_threshold = self.eval(threshold);
            let next = partial_sum + slope;
            *inverse_slope = -slope / (next * partial_sum);
            partial_sum = next;
            if !inverse_slope.is_finite() {
                return Err(ParameterError::NotFinite(slopes_field, i + 1));
            }
            if !inverse_threshold.is_finite() {
                return Err(ParameterError::NotFinite(thresholds_field, i));
            }
        }
        Ok(inverse)
    }
}
