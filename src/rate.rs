//! From samples to the envelopes that the plays follow.
//!
//! A threshold that moves with the rate, `r_i = alpha_i + beta |u'|` (J 19, 24), is the same as a
//! constant threshold `alpha_i` between two envelopes that open with the rate:
//! `lo = u - beta |u'|`, `hi = u + beta |u'|`. That is [`RateLaw`]. Paper M opens its envelopes by
//! two slopes of their own (M 6, 7), [`TwoSlopes`].

use crate::math::Real;
use crate::play::Envelope;

/// Opens the envelope of the input in proportion to its rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateLaw<T> {
    beta: T,
    beta_per_sample: T,
}

impl<T: Real> RateLaw<T> {
    /// `beta` in seconds, `sample_time` in seconds; both were validated by the model that owns the
    /// law.
    pub(crate) fn new(beta: T, sample_time: T) -> Self {
        // Divided once here, so that the step has no division.
        Self {
            beta,
            beta_per_sample: beta / sample_time,
        }
    }

    /// The rate coefficient in seconds.
    pub fn beta(&self) -> T {
        self.beta
    }

    /// Envelope at `input`, its rate taken as the backward difference to `previous` (J 34).
    #[inline(always)]
    pub fn from_samples(&self, input: T, previous: T) -> Envelope<T> {
        Self::open(input, self.beta_per_sample * (input - previous).abs())
    }

    /// Envelope at `input` for a rate known from elsewhere, in input units a second; its sign does
    /// not matter.
    #[inline(always)]
    pub fn from_rate(&self, input: T, rate: T) -> Envelope<T> {
        Self::open(input, self.beta * rate.abs())
    }

    #[inline(always)]
    fn open(input: T, half_width: T) -> Envelope<T> {
        Envelope {
            lo: input - half_width,
            hi: input + half_width,
        }
    }
}

/// Opens the envelope of the input by one slope downwards and another one upwards (M 6, 7):
/// `lo = u - alpha |u'|`, `hi = u + beta |u'|`. Unequal slopes make a loop asymmetric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoSlopes<T> {
    /// `alpha >= 0` in seconds, of the lower envelope.
    pub alpha: T,
    /// `beta >= 0` in seconds, of the upper envelope.
    pub beta: T,
}

impl<T: Real> TwoSlopes<T> {
    /// Envelope at `input` for a rate in input units a second; its sign does not matter.
    #[inline(always)]
    pub fn from_rate(&self, input: T, rate: T) -> Envelope<T> {
        let rate = rate.abs();
        Envelope {
            lo: input - self.alpha * rate,
            hi: input + self.beta * rate,
        }
    }
}
