//! A whole stage: drive in volts to displacement in micrometres.
//!
//! ```text
//! displacement = offset + gain Lambda(Psi[drive])                             (J 27)
//! ```
//!
//! `Psi` is the rate-dependent Prandtl-Ishlinskii operator and keeps the unit of the drive, `Lambda`
//! the asymmetry map, if there is one, and the gain turns volts into micrometres. Kept apart from
//! the weights, it lets the compensator take the rate of the reference in volts a second, the unit
//! that beta was identified in.

use crate::compensator::{Compensator, PreviewCompensator, Unshape};
use crate::effect::asymmetry::Asymmetry;
use crate::error::{Field, ParameterError};
use crate::hysteresis::preview::{PreviewInverse, PreviewSettings};
use crate::hysteresis::{RateDependentPi, State};
use crate::math::Real;

/// A stage with up to `N` plays and up to `M` dead zones on each side of its asymmetry map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<T, const N: usize, const M: usize> {
    hysteresis: RateDependentPi<T, N>,
    asymmetry: Option<Asymmetry<T, M>>,
    gain: T,
    offset: T,
}

impl<T: Real, const N: usize, const M: usize> Model<T, N, M> {
    /// `gain` in um/V, `offset` in um.
    ///
    /// # Errors
    /// A gain that is zero, a gain or an offset that is not finite. A stage that falls as the drive
    /// rises has a negative gain.
    pub fn new(
        hysteresis: RateDependentPi<T, N>,
        asymmetry: Option<Asymmetry<T, M>>,
        gain: T,
        offset: T,
    ) -> Result<Self, ParameterError> {
        if gain == T::ZERO {
            return Err(ParameterError::Zero(Field::Gain));
        }
        if !(gain.is_finite() && (T::ONE / gain).is_finite()) {
            return Err(ParameterError::NotFinite(Field::Gain, 0));
        }
        if !offset.is_finite() {
            return Err(ParameterError::NotFinite(Field::Offset, 0));
        }
        Ok(Self {
            hysteresis,
            asymmetry,
            gain,
            offset,
        })
    }

    /// State before the first drive sample `first` (V): plays at zero, rate zero.
    pub fn start(&self, first: T) -> State<T, N> {
        self.hysteresis.start(first)
    }

    /// Displacement (um) for the next drive sample (V), which is finite.
    #[inline(always)]
    pub fn step(&self, state: &mut State<T, N>, drive: T) -> T {
        self.shape(self.hysteresis.step(state, drive))
    }

    /// Displacement (um) for the next drive sample (V) at a drive rate (V/s) known from elsewhere.
    #[inline(always)]
    pub fn step_with_rate(&self, state: &mut State<T, N>, drive: T, rate: T) -> T {
        self.shape(self.hysteresis.step_with_rate(state, drive, rate))
    }

    #[inline(always)]
    fn shape(&self, w: T) -> T {
        self.scale(self.map(w))
    }

    /// The asymmetry map, where there is one.
    #[inline(always)]
    pub(crate) fn map(&self, w: T) -> T {
        match &self.asymmetry {
            Some(asymmetry) => asymmetry.step(w),
            None => w,
        }
    }

    /// From volts to micrometres.
    #[inline(always)]
    pub(crate) fn scale(&self, w: T) -> T {
        self.offset + self.gain * w
    }

    /// The compensator that inverts this model.
    ///
    /// # Errors
    /// A parameter of the inverse that leaves the range of `T`.
    pub fn compensator(&self) -> Result<Compensator<T, N, M>, ParameterError> {
        Ok(Compensator::new(
            self.unshape()?,
            self.hysteresis.inverse()?,
        ))
    }

    /// The compensator that inverts this model with a preview of the reference.
    ///
    /// # Errors
    /// As [`Model::compensator`] and [`PreviewInverse::new`].
    pub fn preview_compensator<const WINDOW: usize>(
        &self,
        settings: PreviewSettings,
    ) -> Result<PreviewCompensator<T, N, M, WINDOW>, ParameterError> {
        let inverse = PreviewInverse::new(&self.hysteresis, settings)?;
        Ok(PreviewCompensator::new(self.unshape()?, inverse))
    }

    fn unshape(&self) -> Result<Unshape<T, M>, ParameterError> {
        let asymmetry = self.asymmetry.as_ref().map(Asymmetry::inverse);
        Ok(Unshape {
            offset: self.offset,
            per_gain: T::ONE / self.gain,
            asymmetry: asymmetry.transpose()?,
        })
    }

    /// The same model without its rate term.
    pub fn rate_independent(&self) -> Self {
        Self {
            hysteresis: self.hysteresis.rate_independent(),
            ..*self
        }
    }

    /// The asymmetry map, where there is one.
    pub fn asymmetry(&self) -> Option<&Asymmetry<T, M>> {
        self.asymmetry.as_ref()
    }

    /// Gain in um/V.
    pub fn gain(&self) -> T {
        self.gain
    }

    /// Displacement at rest in um.
    pub fn offset(&self) -> T {
        self.offset
    }

    /// The hysteresis operator.
    pub fn hysteresis(&self) -> &RateDependentPi<T, N> {
        &self.hysteresis
    }
}
