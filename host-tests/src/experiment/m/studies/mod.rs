//! What the paper's choices amount to, one at a time.

mod harmonics;
mod planes;
mod tuning;

use crate::error::Error;

pub use harmonics::{AtHarmonic, Compared, Content};
pub use planes::{Held, Plane};
pub use tuning::{AtCovariance, AtEnvelope};

/// Frequencies of the studies of covariance and envelopes, Hz.
pub const LOOKED_AT_HZ: &[f64] = &tuning::LOOKED_AT_HZ;

/// All studies.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Studies {
    /// Lines of the response at 25 Hz before and after compensation.
    pub response_25_hz: Vec<AtHarmonic>,
    /// Harmonics that the harmonic terms hold under a sine.
    pub harmonic_terms: Vec<Content>,
    /// The model with printed and with corrected harmonic terms.
    pub printed_and_corrected: Vec<Compared>,
    /// Printed and clamped plane on a signal that was not fitted.
    pub planes: Vec<Held>,
    /// What the initial covariance does.
    pub covariances: Vec<AtCovariance>,
    /// What the slopes of the envelopes do.
    pub envelopes: Vec<AtEnvelope>,
}

/// Pieces of work in [`run`].
pub const PIECES: u64 = 4;

/// Runs them all; `done` is called [`PIECES`] times.
///
/// # Errors
/// A model or drive that is refused.
pub fn run(done: &(dyn Fn() + Sync)) -> Result<Studies, Error> {
    let (planes, covariances) = rayon::join(
        || planes::run().inspect(|_| done()),
        || tuning::covariances().inspect(|_| done()),
    );
    let (envelopes, printed_and_corrected) = rayon::join(
        || tuning::envelopes().inspect(|_| done()),
        || harmonics::compare().inspect(|_| done()),
    );
    Ok(Studies {
        response_25_hz: harmonics::response()?,
        harmonic_terms: harmonics::contents()?,
        printed_and_corrected: printed_and_corrected?,
        planes: planes?,
        covariances: covariances?,
        envelopes: envelopes?,
    })
}
