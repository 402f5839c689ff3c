//! Preview inverse: the drive for a plant whose thresholds widen with the rate of *its own* drive.
//!
//! The explicit inverse (J 12 to 15) is exact when model and inverse see the same rate. A real
//! actuator sees the rate of its drive `u`, and a compensator that only knows the past of the
//! reference `v` has to take another one. With a short preview of the reference it need not.
//!
//! # Derivation
//!
//! At sample `k` let the plant see the rate of the step to come, `|d_k| / h`, `d_k = u_(k+1) - u_k`.
//! Were the steps known, the explicit inverse would be exact: its plays follow `v_k` between
//! envelopes that are `b |d_k|` wide, `b = a_0 beta / h`,
//!
//! ```text
//! y_k = clamp(y_(k-1); v_k - b |d_k| - s_i, v_k + b |d_k| + s_i),   u_k = b_0 v_k + sum b_i y_k
//! ```
//!
//! and the steps have to be those of this very drive:
//!
//! ```text
//! d_k = b_0 (v_(k+1) - v_k) + sum b_i (y_(k+1) - y_k)                                   (P 1)
//! ```
//!
//! Read as an equation for `d_k` with `d_(k+1)` known, (P 1) involves the past through the plays
//! alone, and through them hardly at all: a play that rests adds nothing to it, and one that slides
//! has forgotten where it was. For a rising reference, `p = v_(k+1) - v_k > 0`, it reads
//!
//! ```text
//! d = b_0 p + sum b_i clamp(q + b d, 0, e_i),   q = p - b |d_(k+1)|                     (P 2)
//! e_i = max(v_(k+1) - b |d_(k+1)| - s_i - y_(k-1), 0),   e_1 >= e_2 >= ...
//! ```
//!
//! so the `m` plays that slide through both samples are a prefix, and with them
//!
//! ```text
//! d = (b_0 p + B_m q + sum_(i > m) b_i e_i) / (1 - b B_m),   B_m = b_1 + ... + b_m      (P 3)
//! ```
//!
//! is checked in one pass. It has exactly one solution while every `1 - b B_m > 0`, that is
//!
//! ```text
//! A_m > a_0 / (1 + h / beta)   for every partial sum A_m                                (P 4)
//! ```
//!
//! which weights `a_i >= 0` always meet; other models are refused. An error of `d_(k+1)` reaches
//! `d_k` shrunk by `-b B_m / (1 - b B_m) < 1`: **the recursion is stable backward in time**, where the
//! same equation run forward grows without bound, so a guess at the end of a short window is
//! forgotten within it. (P 1) is the difference of two samples on purpose: in absolute form the
//! drive after a turning point hangs on the plays before it and the sweep does not converge.
//!
//! A tick takes in one reference sample, follows the plays forward through the window with the steps
//! it has, sweeps (P 3) backward through it, and emits the oldest drive; the next tick goes on from
//! there. `sweeps` of them are made in each tick.
//!
//! # Which rate the plant sees
//!
//! A plant that sees the step *to come* is inverted exactly. A drive that is joined by straight lines
//! shows the actuator the step that *led* to a sample, half a sample earlier than the drive's
//! derivative there; the two differ by `tau h u''`, and no drive can satisfy both. A further stage
//! therefore simulates the second kind of plant on the drive of the stage before, and gives the
//! reference, less the `correction` times that error smoothed over three samples, to another window.
//! `correction` 0 aims at the step to come, 1 at the step that led there.
//!
//! # Limits
//!
//! At the sample of a turning point whose next step is much smaller, (P 1) may have no solution at
//! all: the closing envelope pushes plays back. The nearest step is taken.

mod window;

pub use window::PreviewState;

use crate::error::{Field, ParameterError};
use crate::hysteresis::{RateDependentPi, State};
use crate::math::Real;

use window::Window;

/// Preview inverse of a model of up to `N` plays: `WINDOW` reference samples a stage, `STAGES` of
/// them.
///
/// Takes `O(STAGES sweeps window N)` operations a tick and no division.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewInverse<T, const N: usize, const WINDOW: usize, const STAGES: usize> {
    model: RateDependentPi<T, N>,
    inverse: RateDependentPi<T, N>,
    /// `a_0 beta / h`: half width of the envelope for a step of the drive.
    widening: T,
    /// Its reciprocal; zero where there is no rate term.
    per_widening: T,
    /// `B_1..B_n`.
    sums: [T; N],
    /// `1 / (1 - b B_m)` for `m = 1..n`.
    gains: [T; N],
    window: usize,
    sweeps: usize,
    quarter_correction: T,
}

/// How a preview inverse works; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewSettings<T> {
    /// Reference samples that a stage looks at, `2..=WINDOW`; [`window_for`] proposes a number.
    pub window: usize,
    /// Sweeps a tick, at least one. One is enough for smooth references, a corner may take three.
    pub sweeps: usize,
    /// From 0 for a plant that sees the step to come to 1 for one that sees the step that led there.
    pub correction: T,
}

/// What a later stage remembers of the one before.
#[derive(Clone, Copy, Debug)]
struct Corrector<T, const N: usize> {
    plant: State<T, N>,
    /// The newest sample of the stage before.
    newest: Sample<T>,
    /// Error of the sample before that.
    error_before: T,
}

#[derive(Clone, Copy, Debug)]
struct Sample<T> {
    wanted: T,
    reference: T,
    error: T,
}

impl<T: Real, const N: usize, const WINDOW: usize, const STAGES: usize>
    PreviewInverse<T, N, WINDOW, STAGES>
{
    /// The preview inverse of `model`.
    ///
    /// # Errors
    /// As [`RateDependentPi::inverse`]; a window or a number of sweeps that is out of range
    /// ([`Field::Preview`]); a correction that is not from 0 to 1; a partial sum of weights that
    /// violates (P 4).
    pub fn new(
        model: &RateDependentPi<T, N>,
        settings: PreviewSettings<T>,
    ) -> Result<Self, ParameterError> {
        const { assert!(WINDOW > 1 && STAGES > 0, "no room for a window") };
        let PreviewSettings {
            window,
            sweeps,
            correction,
        } = settings;
        if !(2..=WINDOW).contains(&window) || sweeps == 0 {
            return Err(ParameterError::Length(Field::Preview));
        }
        if !(correction >= T::ZERO && correction <= T::ONE) {
            return Err(ParameterError::NotFinite(Field::Preview, 0));
        }
        let inverse = model.inverse()?;
        let widening = inverse.beta() / model.sample_time();
        let per_widening = if widening > T::ZERO {
            T::ONE / widening
        } else {
            T::ZERO
        };
        if !(widening.is_finite() && per_widening.is_finite()) {
            return Err(ParameterError::NotFinite(Field::Beta, 0));
        }
        let (mut sums, mut gains) = ([T::ZERO; N], [T::ZERO; N]);
        let mut sum = T::ZERO;
        let rows = sums.iter_mut().zip(&mut gains);
        for (i, ((to, gain), &weight)) in rows.zip(inverse.bank().weights()).enumerate() {
            sum = sum + weight;
            let slope = T::ONE - widening * sum;
            if slope <= T::ZERO {
                return Err(ParameterError::RateTooStrong(i + 1));
            }
            (*to, *gain) = (sum, T::ONE / slope);
        }
        Ok(Self {
            model: *model,
            inverse,
            widening,
            per_widening,
            sums,
            gains,
            window,
            sweeps,
            quarter_correction: T::from_f64(0.25) * correction,
        })
    }

    /// Samples between a reference sample going in and its drive coming out.
    pub const fn latency(&self) -> usize {
        STAGES * (self.window - 1) + (STAGES - 1)
    }

    /// State for a reference that has rested at `first` until now, plays at zero.
    pub fn start(&self, first: T) -> PreviewState<T, N, WINDOW, STAGES> {
        let sample = Sample {
            wanted: first,
            reference: first,
            error: T::ZERO,
        };
        let window = Window::new(first);
        let mut state = PreviewState {
            windows: [window; STAGES],
            correctors: [Corrector {
                plant: self.model.start(T::ZERO),
                newest: sample,
                error_before: T::ZERO,
            }; STAGES],
        };
        // A plant at rest at the drive that the first window is going to emit.
        let drive = self.rest(first);
        for corrector in &mut state.correctors {
            corrector.plant = self.model.start(drive);
        }
        state
    }

    /// Drive for the reference sample that came [`PreviewInverse::latency`] samples ago.
    ///
    /// Trusts a finite reference, as the explicit inverse does.
    pub fn step(&self, state: &mut PreviewState<T, N, WINDOW, STAGES>, reference: T) -> T {
        let mut sample = Sample {
            wanted: reference,
            reference,
            error: T::ZERO,
        };
        let mut drive = T::ZERO;
        let last = STAGES - 1;
        let stages = state.windows.iter_mut().zip(&mut state.correctors);
        for (stage, (window, corrector)) in stages.enumerate() {
            let (aged, out) = self.advance(window, sample.wanted, sample.reference);
            drive = out;
            if stage < last {
                sample = self.correct(corrector, aged, out);
            }
        }
        drive
    }

    /// The reference of the next stage, one sample behind what the stage before emitted.
    fn correct(&self, corrector: &mut Corrector<T, N>, emitted: (T, T), drive: T) -> Sample<T> {
        let (wanted, reference) = emitted;
        let error = self.model.step(&mut corrector.plant, drive) - wanted;
        let error_before = corrector.error_before;
        let middle = corrector.newest;
        corrector.error_before = middle.error;
        corrector.newest = Sample {
            wanted,
            reference,
            error,
        };
        let smooth = error_before + middle.error + middle.error + error;
        Sample {
            wanted: middle.wanted,
            reference: middle.reference - self.quarter_correction * smooth,
            error: T::ZERO,
        }
    }

    fn rest(&self, reference: T) -> T {
        let mut state = self.inverse.start(reference);
        self.inverse.step_with_rate(&mut state, reference, T::ZERO)
    }
}

/// Samples after which a guess at the end of the window has shrunk to a thousandth, for a model at its
/// sample time; at least 8.
///
/// ```
/// use hysteron::hysteresis::{Parameters, preview};
///
/// let model = Parameters { weights: &[0.7236, 0.2906, 0.0416, 0.1512],
///     thresholds: &[9.715, 19.43, 29.145], beta: 8.572e-4 }.build::<3>(1e-4)?;
/// assert_eq!(preview::window_for(&model), 32);
/// # Ok::<(), hysteron::error::ParameterError>(())
/// ```
pub fn window_for<T: Real, const N: usize>(model: &RateDependentPi<T, N>) -> usize {
    let a_0 = model.weight_0().to_f64();
    let per_sample = model.beta().to_f64() / model.sample_time().to_f64();
    let mut sum = a_0;
    let mut slowest = 0.0;
    for weight in model.bank().weights() {
        sum += weight.to_f64();
        let share = per_sample * (1.0 - a_0 / sum).abs();
        if share > slowest {
            slowest = share;
        }
    }
    // ln(1000) samples of the time constant `slowest`, of which one step of (P 3) is
    // ln(1 + 1 / slowest), nearly 1 / (slowest + 1/2).
    let samples = 6.91 * (slowest + 0.5) + 2.0;
    if samples < 8.0 {
        8
    } else {
        samples as usize + 1
    }
}
