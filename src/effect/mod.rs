//! What a stage does besides hysteresis: one file an effect, forward and inverse.
//!
//! Each effect is built once from its parameters and the sample time and steps a state of its own.
//! An inverse that needs the future of its signal is fed ahead of time and answers for a sample
//! that it took in some samples before; its `LATENCY` says how many. What the clock alone drives, drift
//! and hum, has no state but a value for each time; what loses something, limits and steps, no
//! inverse.

pub mod asymmetry;
pub mod backlash;
pub mod congruency;
pub mod creep;
pub mod cubic;
pub mod delay;
pub mod derivative;
pub mod drift;
pub mod interleaving;
pub mod lag;
pub mod mains_hum;
pub mod quadratic;
pub mod quantisation;
pub mod rate_power;
pub mod resonance;
pub mod saturation;
pub mod slew_limit;

use crate::error::{Field, ParameterError};
use crate::math::Real;

/// A time that is zero or more, in samples.
fn in_samples<T: Real>(time: T, sample_time: T, field: Field) -> Result<f64, ParameterError> {
    check_sample_time(sample_time)?;
    let samples = time.to_f64() / sample_time.to_f64();
    if !samples.is_finite() {
        return Err(ParameterError::NotFinite(field, 0));
    }
    if samples < 0.0 {
        return Err(ParameterError::Negative(field));
    }
    Ok(samples)
}

fn check_sample_time<T: Real>(sample_time: T) -> Result<(), ParameterError> {
    check_positive(sample_time, Field::SampleTime)
}

fn check_positive<T: Real>(value: T, field: Field) -> Result<(), ParameterError> {
    if !value.is_finite() {
        return Err(ParameterError::NotFinite(field, 0));
    }
    if value <= T::ZERO {
        return Err(ParameterError::NotPositive(field));
    }
    Ok(())
}

/// Root of a monotone map that is near the identity: six steps of Newton's iteration from `y`.
///
/// Without a division, which the sample interrupt does not have: a slope that is off by 1e-7 only
/// takes the last bits a step later.
// A map is met in several places: once in the firmware is enough.
#[inline(never)]
fn newton<T: Real>(y: T, map: impl Fn(T) -> (T, T)) -> T {
    let mut w = y;
    for _ in 0..6 {
        let (value, slope) = map(w);
        w = w - (value - y) * slope.rough_reciprocal();
    }
    w
}
