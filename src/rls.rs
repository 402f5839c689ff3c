//! Recursive least squares of fixed size, with forgetting.
//!
//! After the samples `(x, y)` the estimate minimises
//! `sum lambda^(age) (y - x' theta)^2` plus what the initial covariance weighs its start with:
//!
//! ```text
//! e = y - x' theta,   k = P x / (lambda + x' P x)
//! theta <- theta + k e,   P <- (P - k x' P) / lambda
//! ```
//!
//! The covariance is kept as `P = U D U'`, `U` unit upper triangular and `D` diagonal, and updated
//! in that form (Bierman, *Factorization Methods for Discrete Sequential Estimation*, 1977): so it is
//! symmetric by construction, and as every new entry of `D` is an old one times a quotient of
//! positive numbers it stays positive semidefinite in single precision, too.
//!
//! Without excitation forgetting lets `P` grow without end. So its trace is bounded: where it would
//! pass the bound, all of `P` is scaled down to it, which is a smaller covariance of the same shape.
//! A sample that says nothing (`x = 0`) then leaves the estimate alone for ever.

use core::cmp::Ordering;

use crate::error::{Field, ParameterError, SampleError};
use crate::math::{Real, max, min};

/// Smallest entry of `D`: above the denormal numbers, where a quotient would lose its digits.
const SMALLEST_VARIANCE: f64 = 1e-30;

/// How samples are weighed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rls<T> {
    forgetting: T,
    covariance: T,
    trace_bound: T,
}

/// Estimate of `K` parameters and its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate<T, const K: usize> {
    parameters: [T; K],
    /// Above the diagonal: `U`; entry `[column][row]`, so that a column is one slice.
    factor: [[T; K]; K],
    diagonal: [T; K],
}

impl<T: Real> Rls<T> {
    /// `forgetting` is the factor lambda, 0 < lambda <= 1, one for none; `covariance` the initial
    /// entries of the covariance's diagonal; `trace_bound` the most that its trace may be.
    ///
    /// # Errors
    /// A number that is not finite or not in its range.
    pub fn new(forgetting: T, covariance: T, trace_bound: T) -> Result<Self, ParameterError> {
        let all = [
            (forgetting, Field::Forgetting),
            (covariance, Field::Covariance),
            (trace_bound, Field::TraceBound),
        ];
        for (value, field) in all {
            if !value.is_finite() {
                return Err(ParameterError::NotFinite(field, 0));
            }
            if value <= T::ZERO {
                return Err(ParameterError::NotPositive(field));
            }
        }
        if forgetting > T::ONE {
            return Err(ParameterError::TooLarge(Field::Forgetting));
        }
        Ok(Self {
            forgetting,
            covariance,
            trace_bound,
        })
    }

    /// The estimate before the first sample.
    pub fn start<const K: usize>(&self, parameters: [T; K]) -> Estimate<T, K> {
        const { assert!(K > 0, "there is nothing to estimate") };
        let mut estimate = Estimate {
            parameters,
            factor: [[T::ZERO; K]; K],
            diagonal: [T::ZERO; K],
        };
        self.restart(&mut estimate);
        estimate
    }

    /// Takes a sample `y = x' theta` and returns the error of its prediction, `y - x' theta` with the
    /// estimate before it.
    ///
    /// # Errors
    /// A sample that is not finite, or so large that what is computed from it would not be, is turned
    /// away; the parameters are unchanged.
    pub fn update<const K: usize>(
        &self,
        estimate: &mut Estimate<T, K>,
        x: &[T; K],
        y: T,
    ) -> Result<T, SampleError> {
        let error = y - estimate.predict(x);
        // x' P x is at most the trace times the square of x.
        let square = x.iter().fold(T::ZERO, |sum, &x| sum + x * x);
        if !(error.is_finite() && (square * self.trace_bound).is_finite()) {
            return Err(SampleError::NotFinite);
        }
        let (gain, trace) = estimate.condense(x, self.forgetting);
        if trace > self.trace_bound {
            let scale = self.trace_bound / trace;
            estimate.diagonal.iter_mut().for_each(|d| *d = *d * scale);
        }
        if !trace.is_finite() {
            self.restart(estimate);
        }
        let mut parameters = estimate.parameters;
        for (parameter, gain) in parameters.iter_mut().zip(gain) {
            *parameter = *parameter + gain * error;
        }
        if parameters.iter().any(|parameter| !parameter.is_finite()) {
            return Err(SampleError::NotFinite);
        }
        estimate.parameters = parameters;
        Ok(error)
    }

    /// Gives the covariance its first value.
    fn restart<const K: usize>(&self, estimate: &mut Estimate<T, K>) {
        let share = self.trace_bound / T::from_f64(K as f64);
        estimate.factor = [[T::ZERO; K]; K];
        estimate.diagonal = [min(self.covariance, share); K];
    }
}

impl<T: Real, const K: usize> Estimate<T, K> {
    /// The parameters.
    pub fn parameters(&self) -> &[T; K] {
        &self.parameters
    }

    /// `x' theta`.
    pub fn predict(&self, x: &[T; K]) -> T {
        dot(x, &self.parameters)
    }

    /// The covariance `P`, over the variance of the noise: rows, symmetric.
    pub fn covariance(&self) -> [[T; K]; K] {
        let unit = |row: usize, column: usize| match row.cmp(&column) {
            Ordering::Less => self.above(row, column),
            Ordering::Equal => T::ONE,
            Ordering::Greater => T::ZERO,
        };
        let mut covariance = [[T::ZERO; K]; K];
        for (row, entries) in covariance.iter_mut().enumerate() {
            for (column, entry) in entries.iter_mut().enumerate() {
                // The same products in the same order on both sides of the diagonal.
                for (k, &d) in self.diagonal.iter().enumerate() {
                    *entry = *entry + d * (unit(row, k) * unit(column, k));
                }
            }
        }
        covariance
    }

    fn above(&self, row: usize, column: usize) -> T {
        let column = self.factor.get(column);
        column
            .and_then(|column| column.get(row))
            .copied()
            .unwrap_or(T::ZERO)
    }

    /// Takes a sample's information into the covariance; returns the gain and the trace.
    fn condense(&mut self, x: &[T; K], forgetting: T) -> ([T; K], T) {
        let smallest = T::from_f64(SMALLEST_VARIANCE);
        let mut gain = [T::ZERO; K];
        let mut innovation = forgetting;
        let mut trace = T::ZERO;
        let columns = self.factor.iter_mut().zip(&mut self.diagonal);
        for (j, ((column, variance), &x_j)) in columns.zip(x).enumerate() {
            let column = column.get_mut(..j).unwrap_or(&mut []);
            let f = x_j + dot(column, x);
            let v = *variance * f;
            let before = innovation;
            innovation = before + f * v;
            *variance = max(*variance * (before / innovation) / forgetting, smallest);
            let back = -f / before;
            let mut square = T::ONE;
            for (u, gain) in column.iter_mut().zip(&mut gain) {
                let old = *u;
                *u = old + *gain * back;
                *gain = *gain + old * v;
                square = square + *u * *u;
            }
            trace = trace + *variance * square;
            if let Some(gain) = gain.get_mut(j) {
                *gain = v;
            }
        }
        let per_innovation = T::ONE / innovation;
        gain.iter_mut()
            .for_each(|gain| *gain = *gain * per_innovation);
        (gain, trace)
    }
}

/// Sum of the products of two lists, as long as the shorter one.
fn dot<T: Real>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (&a, &b)| sum + a * b)
}
