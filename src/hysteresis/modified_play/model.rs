//! The full model (M 34): the terms of a [`Basis`], weighted.

use super::basis::{bank, bounded};
use super::{Basis, Grid, Plane, State};
use crate::error::{Field, ParameterError};
use crate::math::Real;

/// Coefficients of what is not a play; all zero leaves the play model alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terms<T> {
    /// `g`, one over the unit of the input.
    pub interleaving: T,
    /// `c_1`, `c_2`, `c_3`.
    pub feedback: [T; 3],
    /// `A_11`, `A_31`, `A_51`: with the sine.
    pub sine: [T; 3],
    /// `A_12`, `A_32`, `A_52`: with the cosine.
    pub cosine: [T; 3],
}

impl<T: Real> Terms<T> {
    /// The play model alone.
    pub fn none() -> Self {
        Self {
            interleaving: T::ZERO,
            feedback: [T::ZERO; 3],
            sine: [T::ZERO; 3],
            cosine: [T::ZERO; 3],
        }
    }

    /// From the order of (M 39), that of [`super::Signals`]: g, c_1, c_2, c_3, A_11, A_12, A_31,
    /// A_32, A_51, A_52.
    pub fn from_list(list: &[T; 10]) -> Self {
        let [g, c1, c2, c3, a11, a12, a31, a32, a51, a52] = *list;
        Self {
            interleaving: g,
            feedback: [c1, c2, c3],
            sine: [a11, a31, a51],
            cosine: [a12, a32, a52],
        }
    }
}

impl<T: Real, const N: usize> super::Signals<T, N> {
    /// The terms that are not plays, in the order of [`Terms::from_list`].
    pub fn other_terms(&self) -> [T; 10] {
        let [y1, y2, y3] = self.outputs;
        let [a11, a12, a31, a32, a51, a52] = self.harmonics;
        [self.product, y1, y2, y3, a11, a12, a31, a32, a51, a52]
    }
}

/// The model, its plane being a [`super::LinearPlane`] or a [`super::ClampedPlane`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModifiedPlay<T, const N: usize, P> {
    basis: Basis<T, N>,
    plane: P,
    terms: Terms<T>,
}

impl<T: Real, const N: usize, P: Plane<T, N>> ModifiedPlay<T, N, P> {
    /// The terms of `basis` with the coefficients of `plane`, made for the same grid, and `terms`.
    ///
    /// # Errors
    /// Coefficients that are not finite.
    pub fn new(basis: &Basis<T, N>, plane: P, terms: Terms<T>) -> Result<Self, ParameterError> {
        let all = [
            (&[terms.interleaving][..], Field::Interleaving),
            (&terms.feedback, Field::Feedback),
            (&terms.sine, Field::Sine),
            (&terms.cosine, Field::Cosine),
        ];
        for (values, field) in all {
            if let Some(index) = values.iter().position(|value| !value.is_finite()) {
                return Err(ParameterError::NotFinite(field, index));
            }
        }
        let mut basis = *basis;
        basis.bank = bank(basis.grid(), &plane.bank_weights())?;
        Ok(Self {
            basis,
            plane,
            terms,
        })
    }

    /// At rest; see [`Basis::start`].
    pub fn start(&self) -> State<T, N> {
        self.basis.start()
    }

    /// Output for the next input, which is finite, in free run; its rate is the backward difference.
    #[inline(always)]
    pub fn step(&self, state: &mut State<T, N>, input: T) -> T {
        let rate = self.basis.backward_rate(state, input);
        self.step_with_rate(state, input, rate)
    }

    /// Output for the next input at a `rate` known from elsewhere, in free run.
    #[inline(always)]
    pub fn step_with_rate(&self, state: &mut State<T, N>, input: T, rate: T) -> T {
        let past = self.past(state);
        let (output, _) = self.respond(state, input, rate, past);
        output
    }

    /// Output for the next input in one step: from the outputs that were measured before. `measured`
    /// is that of this sample, for the samples to come.
    pub fn predict(&self, state: &mut State<T, N>, input: T, rate: T, measured: T) -> T {
        let past = self.past(state);
        let (output, _) = self.respond(state, input, rate, past);
        state.correct(measured);
        output
    }

    /// Begins a sample: what `H^` holds besides the plays, all of it from the samples before.
    #[inline(always)]
    pub(crate) fn past(&self, state: &mut State<T, N>) -> T {
        self.basis.turn(state);
        let [c1, c2, c3] = self.terms.feedback;
        let [y1, y2, y3] = state.outputs();
        let [first, third, fifth] = self.basis.powers(state);
        let on = |[a, b, c]: [T; 3]| a * first + b * third + c * fifth;
        let phasor = state.phasor();
        let feedback = c1 * y1 + c2 * y2 + c3 * y3;
        let harmonic = on(self.terms.sine) * phasor.sine + on(self.terms.cosine) * phasor.cosine;
        feedback + harmonic + self.terms.interleaving * state.product()
    }

    /// Ends a sample: the output, within [`super::OUTPUT_BOUND`], and the plays' part `H` of it.
    #[inline(always)]
    pub(crate) fn respond(&self, state: &mut State<T, N>, input: T, rate: T, past: T) -> (T, T) {
        let (weighted, plays) = self.basis.move_plays(state, input, rate);
        let memory = self.plane.memory(weighted, &plays);
        let output = bounded(self.plane.gain() * input + memory + past);
        state.remember(input, output);
        (output, memory)
    }

    /// What the terms are made of.
    pub fn basis(&self) -> &Basis<T, N> {
        &self.basis
    }

    /// The plane's division.
    pub fn grid(&self) -> &Grid<T, N> {
        self.basis.grid()
    }

    /// What is spread on the plane.
    pub fn plane(&self) -> &P {
        &self.plane
    }

    /// Coefficients of what is not a play.
    pub fn terms(&self) -> &Terms<T> {
        &self.terms
    }
}
