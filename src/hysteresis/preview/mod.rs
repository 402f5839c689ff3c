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
//! is checked in one pass. An error of `d_(k+1)` reaches `d_k` times `rho_m / (1 + rho_m)`,
//! `rho_m = -b B_m = (beta / h) (A_m - a_0) / A_m`, which is below one as long as `rho_m > -1/2`:
//!
//! ```text
//! A_m > a_0 / (1 + h / (2 beta))   for every partial sum A_m                            (P 4)
//! ```
//!
//! Then **the recursion is stable backward in time**, where the same equation run forward grows
//! without bound, so a guess at the end of a short window is forgotten within it. Weights
//! `a_i >= 0` always meet (P 4); other models are refused. (P 1) is the difference of two samples on
//! purpose: in absolute form the drive after a turning point hangs on the plays before it, and the
//! sweep does not converge. For the same reason `y_(k-1)` in `e_i` is not where the steps of the sweep
//! before put a play that slides, but where it came to rest before: `min(q + b d, e_i)` is the same
//! for both, and the sample at which a play is captured no longer hangs on the steps before it.
//!
//! Behind a turning point the envelope may close faster than the reference rises, and the plays at
//! its other side are pushed back, by up to `g_i = y_(k-1) - s_i - v_(k+1) - b |d_(k+1)|`. Then
//!
//! ```text
//! d = b_0 p - sum b_i clamp(b d - p - b |d_(k+1)|, 0, g_i)                              (P 5)
//! ```
//!
//! has exactly one solution beyond `b d = p + b |d_(k+1)|`, found in one pass from the largest `g_i`.
//! So there always is a step, and one sweep in a tick converges, since the next tick goes on from it.
//!
//! A tick takes in one reference sample, follows the plays forward through the window with the steps
//! it has, sweeps (P 3) backward through it, and emits the oldest drive.
//!
//! # Which rate the plant sees
//!
//! A plant that sees the step *to come* ([`PlantRate::Forward`]) is inverted exactly. A drive that is
//! joined by straight lines shows the actuator the step that *led* to a sample
//! ([`PlantRate::Backward`]), half a sample earlier than the drive's derivative there; the two differ
//! by `beta h u''` in the envelope, so no drive satisfies both. The envelope is therefore taken
//! as `b (|d_k| + g c_k)`, with
//!
//! ```text
//! c_k = minmod(|d_(k-1)| - |d_k|, |d_k| - |d_(k+1)|),   min(|d_(k-1)| - |d_k|, 0) at a turn (P 6)
//! ```
//!
//! from the sweep before: second order where the drive is smooth, and nothing where its rate jumps.
//! There an error is left that no drive avoids: the plant sees the old rate for one more sample, and
//! what corrects it now must be paid for later, since while plays slide its error is
//! `e_k = alpha x_k + gamma x_(k-1)` for a deviation `x` from the plan, `alpha = A_m (1 - rho_m)`,
//! `gamma = A_m rho_m`. The sum of the squares of the errors is least with
//!
//! ```text
//! x_k = -e_k alpha / (alpha^2 + max(gamma'^2 - alpha'^2, 0))                            (P 7)
//! ```
//!
//! where the primes mean the plays that slide at the next sample and `e_k` is what the simulated plant
//! would do with the plan. With `rho < 1/2` the plant can be followed forward, and (P 7) does so.
//! The inverse plays are then taken over from the simulated plant. [`PlantRate::Midpoint`] has both
//! corrections in part, `g = 0.46` and `g^2`.
//!
//! # Limits
//!
//! The window has to hold [`window_for`] samples, about `7 beta / h`: a smaller one truncates the
//! recursion. Figures, and what is worse than the explicit inverse: `docs/preview.md`.

mod aim;
mod solve;
mod window;

pub use aim::PlantRate;
pub use window::PreviewState;

use crate::error::{Field, ParameterError};
use crate::hysteresis::RateDependentPi;
use crate::math::Real;

use aim::{Plant, Return};
use window::Window;

/// Preview inverse of a model of up to `N` plays that looks at up to `WINDOW` reference samples.
///
/// Takes `O(sweeps window)` operations a tick and as many a play that moves, and no division.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PreviewInverse<T, const N: usize, const WINDOW: usize> {
    model: RateDependentPi<T, N>,
    inverse: RateDependentPi<T, N>,
    /// `beta / h`: half width of the model's envelope for a step of the drive.
    ratio: T,
    /// `b = a_0 beta / h`: that of the inverse.
    widening: T,
    /// `B_1..B_n`.
    sums: [T; N],
    /// `1 / (1 - b B_m)` for `m = 1..n`.
    gains: [T; N],
    /// `1 / (1 + b B_m)` where that is positive.
    closing_gains: [T; N],
    returning: Return<T, N>,
    window: usize,
    sweeps: usize,
    /// `g`.
    share: T,
}

/// How a preview inverse works; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PreviewSettings {
    /// Reference samples that it looks at, `2..=WINDOW`; [`window_for`] proposes a number.
    pub window: usize,
    /// Sweeps a tick, at least one; one is enough.
    pub sweeps: usize,
    /// What the plant's thresholds widen with.
    pub plant_rate: PlantRate,
}

impl<T: Real, const N: usize, const WINDOW: usize> PreviewInverse<T, N, WINDOW> {
    /// The preview inverse of `model`.
    ///
    /// # Errors
    /// As [`RateDependentPi::inverse`]; a window or a number of sweeps that is out of range
    /// ([`Field::Preview`]); a partial sum of weights that violates (P 4).
    pub fn new(
        model: &RateDependentPi<T, N>,
        settings: PreviewSettings,
    ) -> Result<Self, ParameterError> {
        let PreviewSettings {
            window,
            sweeps,
            plant_rate,
        } = settings;
        if !(2..=WINDOW).contains(&window) || sweeps == 0 {
            return Err(ParameterError::Length(Field::Preview));
        }
        let inverse = model.inverse()?;
        let ratio = model.beta() / model.sample_time();
        let widening = model.weight_0() * ratio;
        if !widening.is_finite() {
            return Err(ParameterError::NotFinite(Field::Beta, 0));
        }
        let half = T::from_f64(0.5);
        let [mut sums, mut gains, mut closing_gains] = [[T::ZERO; N]; 3];
        let mut sum = T::ZERO;
        let rows = sums.iter_mut().zip(&mut gains).zip(&mut closing_gains);
        let weights = inverse.bank().weights();
        for (i, (((to, gain), closing_gain), &weight)) in rows.zip(weights).enumerate() {
            sum = sum + weight;
            let rho = -(widening * sum);
            if rho <= -half {
                return Err(ParameterError::RateTooStrong(i + 1));
            }
            (*to, *gain) = (sum, T::ONE / (T::ONE + rho));
            // With more sliding plays the root of (P 5) does not lie.
            let closing = T::ONE / (T::ONE - rho);
            if closing > T::ZERO && closing.is_finite() {
                *closing_gain = closing;
            }
        }
        let mut partial_sums = [T::ZERO; N];
        let mut sum = model.weight_0();
        let mut count = 0;
        for (to, &weight) in partial_sums.iter_mut().zip(model.bank().weights()) {
            sum = sum + weight;
            *to = sum;
            count += 1;
        }
        let partial_sums = partial_sums.get(..count).unwrap_or(&[]);
        Ok(Self {
            model: *model,
            inverse,
            ratio,
            widening,
            sums,
            gains,
            closing_gains,
            returning: Return::new(model.weight_0(), partial_sums, ratio),
            window,
            sweeps,
            share: T::from_f64(plant_rate.share()),
        })
    }

    /// Samples between a reference sample going in and its drive coming out.
    pub const fn latency(&self) -> usize {
        self.window - 1
    }

    /// State for a reference that has rested at `first` until now, plays at zero before.
    pub fn start(&self, first: T) -> PreviewState<T, N, WINDOW> {
        let mut state = PreviewState {
            window: Window::new(first, [T::ZERO; N]),
            plant: Plant::new(T::ZERO),
        };
        self.settle(&mut state, first);
        state
    }

    /// Takes the state up again for a reference that rests at `reference` from now on, plays where they
    /// stand, and returns the drive there.
    pub fn rest_at(&self, state: &mut PreviewState<T, N, WINDOW>, reference: T) -> T {
        state.window.rest_at(reference);
        self.settle(state, reference)
    }

    /// The inverse operator, whose plays [`PreviewState::plays`] are.
    pub fn inverse(&self) -> &RateDependentPi<T, N> {
        &self.inverse
    }

    /// Drive for the reference sample that came [`PreviewInverse::latency`] samples ago.
    ///
    /// Trusts a finite reference, as the explicit inverse does.
    pub fn step(&self, state: &mut PreviewState<T, N, WINDOW>, reference: T) -> T {
        self.advance(&mut state.window, reference);
        self.emit(state)
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
/// assert_eq!(preview::window_for(&model), 30);
/// # Ok::<(), hysteron::error::ParameterError>(())
/// ```
pub fn window_for<T: Real, const N: usize>(model: &RateDependentPi<T, N>) -> usize {
    let a_0 = model.weight_0().to_f64();
    let ratio = model.beta().to_f64() / model.sample_time().to_f64();
    let mut sum = a_0;
    let mut slowest = 0.0;
    for weight in model.bank().weights() {
        sum += weight.to_f64();
        let rho = ratio * (1.0 - a_0 / sum);
        // A negative one shrinks an error as -rho / (1 + 2 rho) does, and turns its sign.
        let rho = if rho < 0.0 {
            -rho / (1.0 + 2.0 * rho)
        } else {
            rho
        };
        if rho > slowest {
            slowest = rho;
        }
    }
    // A step of (P 3) shrinks an error by exp(-ln(1 + 1 / rho)), nearly exp(-1 / (rho + 1/2)).
    let samples = 6.91 * (slowest + 0.5) + 2.0;
    if samples < 8.0 {
        8
    } else {
        samples as usize + 1
    }
}
