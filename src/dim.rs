//! Direct inverse multiplication (DIM): the drive that makes the modified play model follow a
//! reference.
//!
//! ```text
//! u[k] = (y_d[k] - H^[k]) / (2A)                                                (M 37)
//! ```
//!
//! The print says that `H^` needs past drives only. But the plays in it move with `u[k]`. There are
//! two laws here:
//!
//! - [`Law::Printed`] takes the plays where the drive before left them. That hides a delay of one
//!   sample: as long as all plays slide the law is the iteration
//!   `2A u[k] = y - S u[k-1]`, `S` the sum of the plays' slopes, which runs away where `|S| > |2A|`
//!   and is then held by the range of the drive alone.
//! - [`Law::Exact`] solves `2A u + H(u) = y` within the sample, with the rate of the envelopes held.
//!   With the plane collapsed ([`LinearPlane`]) the left side is made of straight pieces: the plays
//!   in order of their thresholds, each one beyond its corner adding its slope. It is monotone when
//!   all partial sums `2A + s_1 + .. + s_m` have one sign, and one pass over the plays inverts it.
//!
//! With the rate `|u - u_previous| / h` in place of a held one, the map is mostly not monotone: its
//! slopes become `2A + (1 - alpha / h) (s_1 + .. + s_m)`. The rate that is held is the caller's
//! ([`Dim::step_with_rate`]); [`Dim::step`] takes that of the drive one sample before in the exact
//! law, and of the drive itself, once it is known, in the printed one.
//!
//! The outputs in `H^` are simulated ones. The drive is held within `-u_max..=u_max`, where the plane
//! is defined, and the simulation is given the drive that was so held. So whatever the coefficients,
//! no drive and no state is infinite or NaN.

use crate::error::{Field, ParameterError, SampleError};
use crate::hysteresis::modified_play::{self, LinearPlane, ModifiedPlay, Plane};
use crate::math::{Real, max, min};

/// Smallest magnitude of `2A`, and of a partial sum of slopes, that is divided by, over the sum of
/// the magnitudes of all slopes.
pub const SMALLEST_SLOPE: f64 = 1e-6;

/// How `u[k]` is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Plays one sample late.
    Printed,
    /// Plays solved for, at a held rate.
    Exact,
}

/// Compensator of a [`ModifiedPlay`] model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dim<T, const N: usize, P> {
    model: ModifiedPlay<T, N, P>,
    law: Law,
    per_gain: T,
    /// Slope below the corner of the play `i` over that beyond it, entry `i - 1`.
    ratios: [T; N],
}

/// State of the simulated model, and what the last sample left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T, const N: usize> {
    model: modified_play::State<T, N>,
    /// `H` after the last sample.
    memory: T,
    /// Rate of the drive there, in V/s.
    rate: T,
}

impl<T, const N: usize> State<T, N> {
    /// The simulated model.
    pub fn model(&self) -> &modified_play::State<T, N> {
        &self.model
    }
}

impl<T: Real, const N: usize, P: Plane<T, N>> Dim<T, N, P> {
    /// The printed law, for any plane.
    ///
    /// # Errors
    /// A `2A` that nearly vanishes beside the slopes of the plays, [`SMALLEST_SLOPE`].
    pub fn printed(model: ModifiedPlay<T, N, P>) -> Result<Self, ParameterError> {
        let gain = model.plane().gain();
        let slopes = model.plane().bank_weights();
        let sum = slopes.iter().fold(gain.abs(), |sum, s| sum + s.abs());
        let per_gain = reciprocal(gain, sum).ok_or(ParameterError::Zero(Field::Slopes))?;
        Ok(Self {
            model,
            law: Law::Printed,
            per_gain,
            ratios: [T::ONE; N],
        })
    }

    /// At rest; see [`modified_play::Basis::start`].
    pub fn start(&self) -> State<T, N> {
        let model = self.model.start();
        State {
            memory: self.model.plane().memory(T::ZERO, &model.plays()),
            model,
            rate: T::ZERO,
        }
    }

    /// Drive for the next sample `y_d` of the reference.
    ///
    /// # Errors
    /// A reference that is infinite or NaN is turned away; the state is unchanged.
    #[inline(always)]
    pub fn step(&self, state: &mut State<T, N>, reference: T) -> Result<T, SampleError> {
        self.drive(state, reference, None)
    }

    /// Drive for the next sample of the reference with the envelopes opened by a `rate` known from
    /// elsewhere, in V/s; its sign does not matter.
    ///
    /// # Errors
    /// As [`Dim::step`], and a rate that is infinite or NaN.
    #[inline(always)]
    pub fn step_with_rate(
        &self,
        state: &mut State<T, N>,
        reference: T,
        rate: T,
    ) -> Result<T, SampleError> {
        if !rate.is_finite() {
            return Err(SampleError::NotFinite);
        }
        self.drive(state, reference, Some(rate))
    }

    /// Lets the harmonic terms begin anew with the next sample, at the angle zero, and the drive from
    /// rest: where a new motion begins.
    pub fn restart(&self, state: &mut State<T, N>) {
        self.model.basis().reset_angle(&mut state.model);
        state.rate = T::ZERO;
    }

    #[inline(always)]
    fn drive(
        &self,
        state: &mut State<T, N>,
        reference: T,
        rate: Option<T>,
    ) -> Result<T, SampleError> {
        if !reference.is_finite() {
            return Err(SampleError::NotFinite);
        }
        let past = self.model.past(&mut state.model);
        let target = reference - past;
        // Where no play moves.
        let mut drive = (target - state.memory) * self.per_gain;
        if let Law::Exact = self.law {
            drive = self.slide(state, drive, rate.unwrap_or(state.rate));
        }
        let u_max = self.model.grid().u_max();
        let drive = max(min(drive, u_max), -u_max);
        let own = self.model.basis().backward_rate(&state.model, drive);
        let rate = match (rate, self.law) {
            (Some(rate), _) => rate,
            (None, Law::Printed) => own,
            (None, Law::Exact) => state.rate,
        };
        (_, state.memory) = self.model.respond(&mut state.model, drive, rate, past);
        state.rate = own;
        Ok(drive)
    }

    /// Takes a drive that was found with no play moving to where the plays that it would pass do move.
    #[inline(always)]
    fn slide(&self, state: &State<T, N>, mut drive: T, rate: T) -> T {
        let basis = self.model.basis();
        let plays = state.model.plays();
        let rows = plays.iter().zip(basis.thresholds()).zip(&self.ratios);
        let open = basis.slopes().from_rate(T::ZERO, rate);
        // A state that drives can lead to has its upper corners in rising order and its lower ones in
        // falling order, all upper ones above all lower ones.
        let mut rising = false;
        for ((&p, &r), &ratio) in rows.clone() {
            let corner = p + (r - open.lo);
            if drive <= corner {
                break;
            }
            rising = true;
            drive = corner + (drive - corner) * ratio;
        }
        if rising {
            return drive;
        }
        for ((&p, &r), &ratio) in rows {
            let corner = p - (r + open.hi);
            if drive >= corner {
                break;
            }
            drive = corner + (drive - corner) * ratio;
        }
        drive
    }

    /// The model that is inverted.
    pub fn model(&self) -> &ModifiedPlay<T, N, P> {
        &self.model
    }

    /// How `u[k]` is found.
    pub fn law(&self) -> Law {
        self.law
    }
}

impl<T: Real, const N: usize> Dim<T, N, LinearPlane<T, N>> {
    /// The law that is solved within the sample, for the collapsed plane.
    ///
    /// # Errors
    /// As [`Dim::printed`], and slopes whose partial sum changes its sign or nearly vanishes: the map
    /// from drive to output would not be monotone.
    pub fn exact(model: ModifiedPlay<T, N, LinearPlane<T, N>>) -> Result<Self, ParameterError> {
        let mut dim = Self {
            law: Law::Exact,
            ..Self::printed(model)?
        };
        let plane = model.plane();
        let gain = plane.gain();
        let total = plane
            .slopes()
            .iter()
            .fold(gain.abs(), |sum, s| sum + s.abs());
        let mut below = gain;
        for (i, (ratio, &slope)) in dim.ratios.iter_mut().zip(plane.slopes()).enumerate() {
            let beyond = below + slope;
            let same_sign = (beyond > T::ZERO) == (gain > T::ZERO);
            *ratio = match reciprocal(beyond, total) {
                Some(per_beyond) if same_sign => below * per_beyond,
                _ => return Err(ParameterError::NotMonotone(Field::Slopes, i + 1)),
            };
            below = beyond;
        }
        Ok(dim)
    }
}

/// One over a slope that does not nearly vanish beside the `sum` of all.
fn reciprocal<T: Real>(slope: T, sum: T) -> Option<T> {
    let reciprocal = T::ONE / slope;
    let large = slope.abs() > T::from_f64(SMALLEST_SLOPE) * sum;
    (large && reciprocal.is_finite()).then_some(reciprocal)
}
