//! Stages of a few parts, and the end of a signal.

use hysteron_host::plant::{Band, Hysteresis, Stage};

/// An actuator behind a perfect amplifier.
pub fn actuator(gain_um_per_v: f64, bands: &[Band], rate_widening_s: f64) -> Stage {
    Stage::ideal(Hysteresis {
        gain_um_per_v,
        bands: bands.to_vec(),
        rate_widening_s,
    })
}

/// A stage that only passes the drive on, 1 um/V.
pub fn wire() -> Stage {
    actuator(1.0, &[], 0.0)
}

/// The last samples of a signal.
pub fn last(signal: &[f64], samples: usize) -> &[f64] {
    &signal[signal.len() - samples..]
}
