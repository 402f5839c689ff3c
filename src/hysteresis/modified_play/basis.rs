//! The terms of the model before they are weighted: plays, past outputs, harmonic terms.
//!
//! What is needed to identify the model's coefficients, which enter linearly, and to compute its
//! output once they are known.

use super::Grid;
use crate::error::{Field, ParameterError};
use crate::math::{Real, max, min};
use crate::phasor::{Phasor, Rotation};
use crate::play::{Envelope, PlainState, PlayBank};
use crate::rate::TwoSlopes;

/// Largest magnitude of an output that is remembered. A model that runs away, and an input or output
/// that is not a number, stay below it, so that the state is finite in every sample.
pub const OUTPUT_BOUND: f64 = 1e9;

/// Which functions stand for the odd harmonics, with `u = u[k-1]` and the angle `2 pi f (k-1) h`: that
/// of sample `k`, zero at the first one, `k = 1` (M 38).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Harmonics {
    /// `u`, `u^3`, `u^5`, each times the sine and the cosine, as printed (M 34). Under a sine of that
    /// frequency they hold even harmonics only: an odd one times an odd one.
    Printed,
    /// 1, `u^2`, `u^4` times the sine and the cosine: under a sine the first, third and fifth
    /// harmonic.
    Corrected,
}

/// Everything but the coefficients that are linear in the output.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasisParameters<T> {
    /// Largest input of the plane.
    pub u_max: T,
    /// The paper's `N`, at least two.
    pub divisions: usize,
    /// Slope of the lower envelope in seconds (M 7).
    pub alpha: T,
    /// Slope of the upper envelope in seconds (M 6).
    pub beta: T,
    /// Form of the harmonic terms.
    pub harmonics: Harmonics,
    /// Frequency of the harmonic terms in Hz.
    pub frequency: T,
}

/// Terms of a model of up to `N` divisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis<T, const N: usize> {
    grid: Grid<T, N>,
    slopes: TwoSlopes<T>,
    harmonics: Harmonics,
    rotation: Rotation<T>,
    sample_time: T,
    per_sample_time: T,
    /// Plays `i >= 1`, one less than rows.
    pub(super) bank: PlayBank<T, N>,
}

/// Plays, the input before, the outputs before, and the angle of the harmonic terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T, const N: usize> {
    plays: PlainState<T, N>,
    previous: T,
    outputs: [T; 3],
    phasor: Phasor<T>,
}

/// The terms at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Signals<T, const N: usize> {
    /// `u[k]`.
    pub input: T,
    /// Outputs of the plays `i >= 1`, entry `i - 1`.
    pub plays: [T; N],
    /// `y[k-1] u[k-1]`.
    pub product: T,
    /// `y[k-1]`, `y[k-2]`, `y[k-3]`.
    pub outputs: [T; 3],
    /// Of A_11, A_12, A_31, A_32, A_51, A_52.
    pub harmonics: [T; 6],
    /// What the plays followed.
    pub envelope: Envelope<T>,
    /// Magnitude of the rate that opened it, in input units a second.
    pub rate: T,
}

/// Terms of the pseudo-linear form (M 12 to 16).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateTerms<T, const N: usize> {
    /// Outputs of the plays `i >= 1` less the part that this sample's rate added.
    pub plays: [T; N],
    /// Of alpha: minus the slopes of the plays that the lower envelope holds, times the rate.
    pub alpha: T,
    /// Of beta: the slopes of the plays that the upper envelope holds, times the rate.
    pub beta: T,
}

impl<T: Real> BasisParameters<T> {
    /// Terms for samples that are `sample_time` seconds apart.
    ///
    /// # Errors
    /// Names what is wrong: the plane's range or number of divisions, a slope of an envelope below
    /// zero, a frequency outside zero to half the sample rate, a sample time that is not positive,
    /// anything not finite.
    pub fn build<const N: usize>(&self, sample_time: T) -> Result<Basis<T, N>, ParameterError> {
        if !(sample_time.is_finite() && (T::ONE / sample_time).is_finite()) {
            return Err(ParameterError::NotFinite(Field::SampleTime, 0));
        }
        if sample_time <= T::ZERO {
            return Err(ParameterError::NotPositive(Field::SampleTime));
        }
        for (slope, field) in [(self.alpha, Field::Alpha), (self.beta, Field::Beta)] {
            if !(slope / sample_time).is_finite() {
                return Err(ParameterError::NotFinite(field, 0));
            }
            if slope < T::ZERO {
                return Err(ParameterError::Negative(field));
            }
        }
        let grid = Grid::new(self.u_max, self.divisions)?;
        Ok(Basis {
            grid,
            slopes: TwoSlopes {
                alpha: self.alpha,
                beta: self.beta,
            },
            harmonics: self.harmonics,
            rotation: Rotation::new(self.frequency, sample_time)?,
            sample_time,
            per_sample_time: T::ONE / sample_time,
            bank: bank(&grid, &[T::ZERO; N])?,
        })
    }
}

/// The plays of a grid with these weights, one a play.
pub(super) fn bank<T: Real, const N: usize>(
    grid: &Grid<T, N>,
    weights: &[T; N],
) -> Result<PlayBank<T, N>, ParameterError> {
    let mut thresholds = [T::ZERO; N];
    for (i, threshold) in thresholds.iter_mut().enumerate() {
        *threshold = grid.threshold(i + 1);
    }
    let plays = ..grid.divisions() - 1;
    PlayBank::new(
        thresholds.get(plays).unwrap_or(&[]),
        weights.get(plays).unwrap_or(&[]),
    )
}

impl<T: Real, const N: usize> Basis<T, N> {
    /// At rest: plays, input and outputs before the first sample are zero, and the first sample has
    /// the angle zero.
    pub fn start(&self) -> State<T, N> {
        State {
            plays: PlainState::zero(),
            previous: T::ZERO,
            outputs: [T::ZERO; 3],
            phasor: self.rotation.before_zero(),
        }
    }

    /// Moves the plays to the next input and returns all terms. The rate is the caller's: with the
    /// input known ahead the paper's forward difference `(u[k+1] - u[k]) / h`, else the backward
    /// one, [`Basis::backward_rate`]; its sign does not matter.
    ///
    /// The sample ends with [`State::remember`].
    pub fn advance(&self, state: &mut State<T, N>, input: T, rate: T) -> Signals<T, N> {
        self.turn(state);
        let product = state.product();
        let harmonics = self.harmonic_terms(state);
        let envelope = self.slopes.from_rate(input, rate);
        let _ = state.plays.step(&self.bank, envelope);
        Signals {
            input,
            plays: state.plays.outputs(),
            product,
            outputs: state.outputs,
            harmonics,
            envelope,
            rate: rate.abs(),
        }
    }

    /// `(u[k] - u[k-1]) / h` of an input `u[k]` to come.
    #[inline(always)]
    pub fn backward_rate(&self, state: &State<T, N>, input: T) -> T {
        (input - state.previous) * self.per_sample_time
    }

    /// Lets the harmonic terms begin anew with the next sample, at the angle zero.
    #[inline(always)]
    pub fn reset_angle(&self, state: &mut State<T, N>) {
        state.phasor = self.rotation.before_zero();
    }

    /// The plane's division.
    pub fn grid(&self) -> &Grid<T, N> {
        &self.grid
    }

    /// Slopes of the two envelopes.
    pub fn slopes(&self) -> &TwoSlopes<T> {
        &self.slopes
    }

    /// `r_i` of the plays `i >= 1`.
    #[inline(always)]
    pub fn thresholds(&self) -> &[T] {
        self.bank.thresholds()
    }

    /// Form of the harmonic terms.
    pub fn harmonics(&self) -> Harmonics {
        self.harmonics
    }

    /// Time between two samples in seconds.
    pub fn sample_time(&self) -> T {
        self.sample_time
    }

    /// Terms of the plane's collapsed form: the input, the plays, and one for the offset; `N + 1`.
    /// They go with the parameters of [`super::LinearPlane::new`].
    pub fn linear_terms(&self, signals: &Signals<T, N>) -> impl Iterator<Item = T> {
        let plays = self.grid.divisions() - 1;
        core::iter::once(signals.input)
            .chain(signals.plays.into_iter().take(plays))
            .chain(core::iter::once(T::ONE))
    }

    /// Terms of the clamped form: the input and the `N(N-1)/2` cells of the plays. They go with the
    /// parameters of [`super::ClampedPlane::new`].
    pub fn clamped_terms(&self, signals: &Signals<T, N>) -> impl Iterator<Item = T> {
        let (grid, plays) = (self.grid, signals.plays);
        core::iter::once(signals.input).chain(grid.cells(1).map(move |(i, j)| {
            let p = plays.get(i - 1).copied().unwrap_or(T::ZERO);
            grid.clamped(i, j, p)
        }))
    }

    /// Terms of alpha and beta, linear in them only as long as the slopes of the plays, entry
    /// `i - 1` of the play `i`, are taken as known: those of the sample before (M 12). A play that
    /// nothing holds still carries the rate of the sample that left it there, so the form is
    /// pseudo-linear: recursive least squares equals the batch solution with alpha and beta fixed.
    pub fn rate_terms(&self, signals: &Signals<T, N>, slopes: &[T; N]) -> RateTerms<T, N> {
        let Signals { envelope, rate, .. } = *signals;
        let mut terms = RateTerms {
            plays: signals.plays,
            alpha: T::ZERO,
            beta: T::ZERO,
        };
        let rows = self.bank.thresholds().iter().zip(slopes);
        for (p, (&r, &slope)) in terms.plays.iter_mut().zip(rows) {
            if *p <= envelope.lo - r {
                *p = *p + self.slopes.alpha * rate;
                terms.alpha = terms.alpha - slope * rate;
            } else if *p >= envelope.hi + r {
                *p = *p - self.slopes.beta * rate;
                terms.beta = terms.beta + slope * rate;
            }
        }
        terms
    }

    /// Takes the angle to the sample that begins.
    #[inline(always)]
    pub(super) fn turn(&self, state: &mut State<T, N>) {
        self.rotation.step(&mut state.phasor);
    }

    #[inline(always)]
    pub(super) fn move_plays(&self, state: &mut State<T, N>, input: T, rate: T) -> (T, [T; N]) {
        let envelope = self.slopes.from_rate(input, rate);
        let weighted = state.plays.step(&self.bank, envelope);
        (weighted, state.plays.outputs())
    }

    #[inline(always)]
    fn harmonic_terms(&self, state: &State<T, N>) -> [T; 6] {
        let [first, third, fifth] = self.powers(state);
        let Phasor { sine, cosine } = state.phasor;
        [
            first * sine,
            first * cosine,
            third * sine,
            third * cosine,
            fifth * sine,
            fifth * cosine,
        ]
    }

    /// What stands before the sine and the cosine.
    #[inline(always)]
    pub(super) fn powers(&self, state: &State<T, N>) -> [T; 3] {
        let u = state.previous;
        let square = u * u;
        let first = match self.harmonics {
            Harmonics::Printed => u,
            Harmonics::Corrected => T::ONE,
        };
        let third = first * square;
        [first, third, third * square]
    }
}

impl<T: Real, const N: usize> State<T, N> {
    /// Ends a sample: what the next one has as `u[k-1]` and `y[k-1]`, the output measured or
    /// simulated, limited to [`OUTPUT_BOUND`].
    #[inline(always)]
    pub fn remember(&mut self, input: T, output: T) {
        let [y1, y2, _] = self.outputs;
        self.outputs = [bounded(output), y1, y2];
        self.previous = input;
    }

    /// Takes a measured output in place of the latest one remembered.
    #[inline(always)]
    pub fn correct(&mut self, measured: T) {
        let [_, y2, y3] = self.outputs;
        self.outputs = [bounded(measured), y2, y3];
    }

    /// Outputs of the plays `i >= 1`, entry `i - 1`.
    #[inline(always)]
    pub fn plays(&self) -> [T; N] {
        self.plays.outputs()
    }

    /// `y[k-1]`, `y[k-2]`, `y[k-3]`.
    pub fn outputs(&self) -> [T; 3] {
        self.outputs
    }

    /// `u[k-1]`.
    pub fn previous(&self) -> T {
        self.previous
    }

    /// Sine and cosine of the harmonic terms' angle.
    pub fn phasor(&self) -> Phasor<T> {
        self.phasor
    }

    #[inline(always)]
    pub(super) fn product(&self) -> T {
        let [y1, ..] = self.outputs;
        y1 * self.previous
    }
}

/// `value` within [`OUTPUT_BOUND`]; NaN becomes the upper bound.
#[inline(always)]
pub(super) fn bounded<T: Real>(value: T) -> T {
    let bound = T::from_f64(OUTPUT_BOUND);
    max(min(value, bound), -bound)
}
