//! The triangular plane of thresholds and play outputs, divided into cells, and what is spread on it.
//!
//! ```text
//! r_i  = i u_max / N                                         i = 0..N-1
//! p_ij = (2j - N + 1 + i) (u_max - r_i) / (N - i)            j = 0..N-1-i
//! P    = sum_ij omega_ij x_ij(p_i)                                              (M 10)
//! ```
//!
//! `p_i` is the output of the play of threshold `r_i`, and `p_0` the input itself. Row 0 has one
//! common weight (M 31), so that with the term `A_1 u` it is `2A u` (M 36), the *gain* here.
//!
//! The shape is printed as `x_ij = (p_i - p_ij) / (u_max - r_i)` (M 4). It is linear in `p_i`, so the
//! sum over `j` collapses: the N(N+1)/2 weights act through N slopes and one offset alone,
//! [`LinearPlane`], and have rank N + 1 under any input whatever.
//!
//! The form that keeps its degrees of freedom limits the shape to its cell, [`ClampedPlane`]:
//! `x_ij = clamp((p_i - p_ij) (N - i) / (u_max - r_i), -1, 1)`. The cells of a row are all
//! `2 u_max / N` wide and lie side by side, so a play moves through one of them at a time and a row
//! is a shape function made of straight pieces, of slope `omega_ij N / u_max`.

use crate::error::{Field, ParameterError};
use crate::math::{Real, max, min};

/// The plane's division: `2..=N` thresholds up to `u_max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid<T, const N: usize> {
    u_max: T,
    divisions: usize,
}

impl<T: Real, const N: usize> Grid<T, N> {
    /// The plane for inputs from `-u_max` to `u_max` with the paper's `N` as `divisions`.
    ///
    /// # Errors
    /// A range that is not positive and finite, fewer than two divisions or more than `N`.
    pub fn new(u_max: T, divisions: usize) -> Result<Self, ParameterError> {
        if !(u_max.is_finite() && (T::ONE / u_max).is_finite()) {
            return Err(ParameterError::NotFinite(Field::InputRange, 0));
        }
        if u_max <= T::ZERO {
            return Err(ParameterError::NotPositive(Field::InputRange));
        }
        if !(2..=N).contains(&divisions) {
            return Err(ParameterError::Length(Field::Divisions));
        }
        Ok(Self { u_max, divisions })
    }

    /// Largest input.
    pub fn u_max(&self) -> T {
        self.u_max
    }

    /// The paper's `N`: rows of the plane, row 0 being the input itself.
    pub fn divisions(&self) -> usize {
        self.divisions
    }

    /// Weights of the whole plane, `N(N+1)/2`.
    pub fn weights(&self) -> usize {
        self.divisions * (self.divisions + 1) / 2
    }

    /// Weights of the rows `i >= 1`, `N(N-1)/2`.
    pub fn memory_weights(&self) -> usize {
        self.divisions * (self.divisions - 1) / 2
    }

    /// `r_i`.
    pub fn threshold(&self, i: usize) -> T {
        self.fraction(i as f64)
    }

    /// `u_max - r_i`.
    pub fn reach(&self, i: usize) -> T {
        self.fraction(self.divisions as f64 - i as f64)
    }

    /// `p_ij`.
    pub fn point(&self, i: usize, j: usize) -> T {
        // (u_max - r_i) / (N - i) is u_max / N in every row.
        self.fraction(2.0 * j as f64 + 1.0 + i as f64 - self.divisions as f64)
    }

    /// `x_ij` as printed (M 4), of a play output `p` of row `i`.
    pub fn printed(&self, i: usize, j: usize, p: T) -> T {
        (p - self.point(i, j)) / self.reach(i)
    }

    /// `x_ij` limited to its cell.
    #[inline(always)]
    pub fn clamped(&self, i: usize, j: usize, p: T) -> T {
        let x = (p - self.point(i, j)) * (T::from_f64(self.divisions as f64) / self.u_max);
        max(min(x, T::ONE), -T::ONE)
    }

    /// Index pairs `(i, j)` from row `first` on, in the order of the weights (M 8).
    pub fn cells(&self, first: usize) -> impl Iterator<Item = (usize, usize)> + use<T, N> {
        let divisions = self.divisions;
        (first..divisions).flat_map(move |i| (0..divisions - i).map(move |j| (i, j)))
    }

    fn fraction(&self, steps: f64) -> T {
        T::from_f64(steps) * self.u_max / T::from_f64(self.divisions as f64)
    }
}

/// What is spread on the plane: from the plays' outputs to the model's output.
pub trait Plane<T, const N: usize>: Clone {
    /// `2A`, output unit over input unit.
    fn gain(&self) -> T;

    /// Weights of the plays `i >= 1`, entry `i - 1`, with which a bank is to sum their outputs.
    fn bank_weights(&self) -> [T; N];

    /// `H`: what the plays `i >= 1` add to the output, from their weighted sum and their outputs,
    /// entry `i - 1`.
    fn memory(&self, weighted: T, plays: &[T; N]) -> T;

    /// Slope `dH/dp_i` of the plays `i >= 1`, entry `i - 1`, at their outputs.
    fn local_slopes(&self, plays: &[T; N]) -> [T; N];
}

/// The printed shape, collapsed: N slopes and one offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinearPlane<T, const N: usize> {
    divisions: usize,
    gain: T,
    /// Of the plays `i >= 1`, entry `i - 1`.
    slopes: [T; N],
    offset: T,
}

impl<T: Real, const N: usize> LinearPlane<T, N> {
    /// The plane from its slopes, `2A` first and one for each play after it, and its offset.
    ///
    /// # Errors
    /// Not one slope for each row of the grid, numbers that are not finite.
    pub fn new(grid: &Grid<T, N>, slopes: &[T], offset: T) -> Result<Self, ParameterError> {
        if slopes.len() != grid.divisions {
            return Err(ParameterError::Length(Field::Slopes));
        }
        check_finite(slopes, Field::Slopes)?;
        check_finite(&[offset], Field::Offset)?;
        let mut plane = Self {
            divisions: grid.divisions,
            gain: T::ZERO,
            slopes: [T::ZERO; N],
            offset,
        };
        if let Some((&gain, slopes)) = slopes.split_first() {
            plane.gain = gain;
            copy(&mut plane.slopes, slopes);
        }
        Ok(plane)
    }

    /// The plane of all weights `omega_ij` of the printed double sum (M 10), row 0 included:
    /// `s_i = sum_j omega_ij / (u_max - r_i)`, offset `-sum_ij omega_ij p_ij / (u_max - r_i)`.
    ///
    /// # Errors
    /// Not [`Grid::weights`] numbers, or some that are not finite.
    pub fn collapse(grid: &Grid<T, N>, weights: &[T]) -> Result<Self, ParameterError> {
        if weights.len() != grid.weights() {
            return Err(ParameterError::Length(Field::PlaneWeights));
        }
        check_finite(weights, Field::PlaneWeights)?;
        let mut slopes = [T::ZERO; N];
        let mut offset = T::ZERO;
        for ((i, j), &weight) in grid.cells(0).zip(weights) {
            let per_reach = weight / grid.reach(i);
            offset = offset - per_reach * grid.point(i, j);
            if let Some(slope) = slopes.get_mut(i) {
                *slope = *slope + per_reach;
            }
        }
        Self::new(grid, slopes.get(..grid.divisions).unwrap_or(&[]), offset)
    }

    /// Slopes of the plays `i >= 1`.
    pub fn slopes(&self) -> &[T] {
        self.slopes.get(..self.divisions - 1).unwrap_or(&[])
    }

    /// Output with all plays at zero.
    pub fn offset(&self) -> T {
        self.offset
    }
}

impl<T: Real, const N: usize> Plane<T, N> for LinearPlane<T, N> {
    #[inline(always)]
    fn gain(&self) -> T {
        self.gain
    }

    fn bank_weights(&self) -> [T; N] {
        self.slopes
    }

    #[inline(always)]
    fn memory(&self, weighted: T, _: &[T; N]) -> T {
        weighted + self.offset
    }

    fn local_slopes(&self, _: &[T; N]) -> [T; N] {
        self.slopes
    }
}

/// The shape limited to its cell: a gain and N(N-1)/2 weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClampedPlane<T, const N: usize> {
    grid: Grid<T, N>,
    gain: T,
    /// `weights[i][j]`; row 0 is not used.
    weights: [[T; N]; N],
}

impl<T: Real, const N: usize> ClampedPlane<T, N> {
    /// The plane from `2A` and the weights of the rows `i >= 1` in the order of [`Grid::cells`].
    ///
    /// # Errors
    /// Not [`Grid::memory_weights`] numbers, or some that are not finite.
    pub fn new(grid: &Grid<T, N>, gain: T, weights: &[T]) -> Result<Self, ParameterError> {
        if weights.len() != grid.memory_weights() {
            return Err(ParameterError::Length(Field::PlaneWeights));
        }
        check_finite(&[gain], Field::Slopes)?;
        check_finite(weights, Field::PlaneWeights)?;
        let mut plane = Self {
            grid: *grid,
            gain,
            weights: [[T::ZERO; N]; N],
        };
        for ((i, j), &weight) in grid.cells(1).zip(weights) {
            if let Some(slot) = plane.weights.get_mut(i).and_then(|row| row.get_mut(j)) {
                *slot = weight;
            }
        }
        Ok(plane)
    }

    fn row(&self, i: usize) -> impl Iterator<Item = (usize, T)> {
        let len = self.grid.divisions - i;
        let row = self.weights.get(i).into_iter().flatten();
        row.take(len).copied().enumerate()
    }
}

impl<T: Real, const N: usize> Plane<T, N> for ClampedPlane<T, N> {
    #[inline(always)]
    fn gain(&self) -> T {
        self.gain
    }

    fn bank_weights(&self) -> [T; N] {
        [T::ZERO; N]
    }

    #[inline(always)]
    fn memory(&self, _: T, plays: &[T; N]) -> T {
        let mut sum = T::ZERO;
        for (i, &p) in (1..self.grid.divisions).zip(plays) {
            for (j, weight) in self.row(i) {
                sum = sum + weight * self.grid.clamped(i, j, p);
            }
        }
        sum
    }

    fn local_slopes(&self, plays: &[T; N]) -> [T; N] {
        let per_cell = T::from_f64(self.grid.divisions as f64) / self.grid.u_max;
        let mut slopes = [T::ZERO; N];
        for (slope, (i, &p)) in slopes.iter_mut().zip((1..self.grid.divisions).zip(plays)) {
            for (j, weight) in self.row(i) {
                if self.grid.clamped(i, j, p).abs() < T::ONE {
                    *slope = weight * per_cell;
                }
            }
        }
        slopes
    }
}

fn check_finite<T: Real>(values: &[T], field: Field) -> Result<(), ParameterError> {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(ParameterError::NotFinite(field, index)),
        None => Ok(()),
    }
}

fn copy<T: Real>(to: &mut [T], from: &[T]) {
    to.iter_mut().zip(from).for_each(|(to, &from)| *to = from);
}
