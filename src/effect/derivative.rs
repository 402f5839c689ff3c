//! Derivatives of a sampled signal that is known two samples ahead.
//!
//! ```text
//! x'_k  = (x_(k-2) - 8 x_(k-1) + 8 x_(k+1) - x_(k+2)) / (12 h) + O(h^4)
//! x''_k = (-x_(k-2) + 16 x_(k-1) - 30 x_k + 16 x_(k+1) - x_(k+2)) / (12 h^2) + O(h^4)
//! ```

use crate::math::Real;

/// Samples between the newest sample and the one that the derivatives belong to.
pub(super) const LATENCY: usize = 2;

/// The five newest samples, oldest first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Samples<T>([T; 5]);

/// A signal and its derivatives by the sample number, each times 12.
pub(super) struct Derivatives<T> {
    pub value: T,
    pub twelve_first: T,
    pub twelve_second: T,
}

impl<T: Real> Samples<T> {
    /// A signal at rest.
    pub(super) fn at_rest(value: T) -> Self {
        Self([value; 5])
    }

    /// Takes in the newest sample; the derivatives at the middle one.
    #[inline(always)]
    pub(super) fn push(&mut self, newest: T) -> Derivatives<T> {
        let [_, a, b, c, d] = self.0;
        self.0 = [a, b, c, d, newest];
        let (eight, sixteen, thirty) = (T::from_f64(8.0), T::from_f64(16.0), T::from_f64(30.0));
        Derivatives {
            value: c,
            twelve_first: (a - newest) + eight * (d - b),
            twelve_second: sixteen * (b + d) - thirty * c - (a + newest),
        }
    }
}
