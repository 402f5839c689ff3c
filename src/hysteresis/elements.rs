//! Up to three elements of Bouc and Wen beside a bank of plays, and the drive for which both together
//! yield a given output.

use crate::effect::congruency::{Congruency, MOST};
use crate::error::{Field, ParameterError};
use crate::hysteresis::RateDependentPi;
use crate::hysteresis::bouc_wen::{BoucWen, BoucWenState};
use crate::math::{Real, max};
use crate::play::{Envelope, play};

/// Elements at most.
pub const ELEMENTS: usize = 3;
/// Least slope of the output against the drive, over the sum of the other weights.
const LEAST_SLOPE: f64 = 1e-6;
/// Halvings of the interval that holds the drive: enough for every digit of double precision.
const HALVINGS: usize = 80;

/// The elements beside a bank; none by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Elements<T>([Option<BoucWen<T>>; ELEMENTS]);

/// State of the elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementsState<T>([Option<BoucWenState<T>>; ELEMENTS]);

impl<T: Real> Elements<T> {
    /// Adds one.
    ///
    /// # Errors
    /// More than [`ELEMENTS`].
    pub fn add(&mut self, element: BoucWen<T>) -> Result<(), ParameterError> {
        let free = self.0.iter_mut().find(|slot| slot.is_none());
        *free.ok_or(ParameterError::TooLarge(Field::Elements))? = Some(element);
        Ok(())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.iter().all(Option::is_none)
    }

    /// Sum of their weights.
    pub fn weight(&self) -> T {
        self.0
            .iter()
            .flatten()
            .fold(T::ZERO, |sum, e| sum + e.weight())
    }

    /// Before anything moved them.
    pub fn start(&self) -> ElementsState<T> {
        ElementsState(self.0.map(|element| element.map(|element| element.start())))
    }

    /// Sum of what they add (V) at the next drive sample within its `envelope`.
    #[inline(always)]
    pub fn step(&self, state: &mut ElementsState<T>, input: T, envelope: Envelope<T>) -> T {
        let mut sum = T::ZERO;
        for (element, at) in self.0.iter().zip(&mut state.0) {
            if let (Some(element), Some(at)) = (element, at) {
                sum = sum + element.step(at, input, envelope);
            }
        }
        sum
    }

    /// Whether `operator` with these elements, under a congruency if there is one, rises with the drive
    /// everywhere.
    ///
    /// # Errors
    /// A weight of the drive itself that hardly outweighs the steepest fall of the elements and the negative
    /// weights, or not at all; those of [`Congruency::check`].
    pub fn check<const N: usize>(
        &self,
        operator: &RateDependentPi<T, N>,
        congruency: Option<&Congruency<T>>,
    ) -> Result<(), ParameterError> {
        if let Some(congruency) = congruency {
            congruency.check(operator)?;
        }
        let weights = operator.bank().weights().iter();
        let all = weights.fold(self.weight(), |sum, a| sum + a.abs());
        if self.least_slope(operator, congruency) > T::from_f64(LEAST_SLOPE) * all {
            Ok(())
        } else {
            Err(ParameterError::Outweighed(Field::Weights))
        }
    }

    fn least_slope<const N: usize>(
        &self,
        operator: &RateDependentPi<T, N>,
        congruency: Option<&Congruency<T>>,
    ) -> T {
        let elements = self.0.iter().flatten();
        let fall = elements.fold(T::ZERO, |sum, element| sum + element.fall());
        let weights = operator.bank().weights().iter();
        let fall = weights.fold(fall, |sum, &a| sum + max(-a, T::ZERO));
        let most = congruency.map_or(T::ONE, |_| T::from_f64(MOST));
        operator.weight_0() - most * fall
    }

    /// Drive for which `operator` and the elements yield `w`, with the plays at `z` before and an envelope
    /// that opens by `half_width`; plays and elements follow. They have passed [`Elements::check`].
    ///
    /// The output rises with the drive by no less than the slope that was checked, so how far off it is
    /// where the drive stands bounds the way to go; halving does the rest.
    pub fn step_inverse<const N: usize>(
        &self,
        operator: &RateDependentPi<T, N>,
        congruency: Option<&Congruency<T>>,
        (z, state): (&mut [T; N], &mut ElementsState<T>),
        (w, half_width): (T, T),
    ) -> T {
        let bank = operator.bank();
        let (thresholds, weights) = (bank.thresholds(), bank.weights());
        let envelope = |u: T| Envelope {
            lo: u - half_width,
            hi: u + half_width,
        };
        // With the output given, a congruency is a number.
        let factor = congruency.map_or(T::ONE, |law| law.factor(w));
        let output = |u: T, state: &ElementsState<T>| {
            let mut moved = *state;
            let elements = self.step(&mut moved, u, envelope(u));
            let plays = z.iter().zip(thresholds.iter().zip(weights));
            let lagging = plays.fold(elements, |sum, (&z, (&r, &a))| {
                sum + a * play(z, envelope(u), r)
            });
            operator.weight_0() * u + factor * lagging
        };
        let here = state.0.iter().flatten().next();
        let here = here.map_or(T::ZERO, |state| state.followed);
        let way = (w - output(here, state)) / self.least_slope(operator, congruency);
        let (mut low, mut high) = if way > T::ZERO {
            (here, here + way)
        } else {
            (here + way, here)
        };
        for _ in 0..HALVINGS {
            let middle = low + (high - low) * T::from_f64(0.5);
            if middle <= low || middle >= high {
                break;
            }
            if output(middle, state) < w {
                low = middle;
            } else {
                high = middle;
            }
        }
        self.step(state, high, envelope(high));
        for (z, &r) in z.iter_mut().zip(thresholds) {
            *z = play(*z, envelope(high), r);
        }
        high
    }
}
