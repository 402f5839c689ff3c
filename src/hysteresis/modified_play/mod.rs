//! The modified play model of a bimorph, with output feedback, harmonic terms and interleaving.
//!
//! ```text
//! p_i  = max(min(p_i_previous, u + beta |u'| + r_i), u - alpha |u'| - r_i)      (M 5 to 7)
//! y[k] = 2A u[k] + H(p_1..p_(N-1)) + g y[k-1] u[k-1]
//!      + c_1 y[k-1] + c_2 y[k-2] + c_3 y[k-3]
//!      + (A_11 u + A_31 u^3 + A_51 u^5)[k-1] sin(2 pi f (k-1) h)
//!      + (A_12 u + A_32 u^3 + A_52 u^5)[k-1] cos(2 pi f (k-1) h)                (M 34)
//!      = 2A u[k] + H^[k]
//! ```
//!
//! [`Grid`] divides the plane of thresholds and play outputs, a [`Plane`] is what is spread on it:
//! [`LinearPlane`] as printed, [`ClampedPlane`] in the form that does not degenerate. [`Basis`] makes
//! the terms and [`ModifiedPlay`] weights them. A sample is predicted in one step, from measured
//! outputs, or in free run, from the model's own.
//!
//! Where the print contradicts itself, this is the form taken:
//!
//! - (M 34) with (M 38): the first sample is `k = 1`, so the angle `2 pi f (k-1) h` is zero there.
//! - (M 35) leaves the c terms out of `H^`. They belong there, or (M 34) does not add up.
//! - (M 20) loses `A_1 u[k]` and has `u[k]` in the harmonic terms where (M 19) and (M 34) have
//!   `u[k-1]`.
//! - (M 4) makes the plane degenerate; see [`LinearPlane`].
//! - The printed harmonic terms hold even harmonics only; see [`Harmonics`].
//! - (M 11) takes `u'` by a forward difference, which is known in a model, not in a causal
//!   compensator. Here the caller chooses: [`ModifiedPlay::step_with_rate`] takes any rate, and
//!   [`ModifiedPlay::step`] the backward difference.
//! - (M 39) lists 56 parameters for N = 10; with alpha and beta there are 58.
//! - Whether `y[k-1]` is measured or simulated is not said: [`ModifiedPlay::predict`] and
//!   [`ModifiedPlay::step`] do the one and the other.

mod basis;
mod model;
mod plane;

pub use basis::{Basis, BasisParameters, Harmonics, OUTPUT_BOUND, RateTerms, Signals, State};
pub use model::{ModifiedPlay, Terms};
pub use plane::{ClampedPlane, Grid, LinearPlane, Plane};
