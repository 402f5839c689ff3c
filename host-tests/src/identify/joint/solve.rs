//! The linear part of a step: least squares with some of the unknowns held non-negative.

use nalgebra::{DMatrix, DVector};
use ndarray::Array2;

use super::super::reduce::non_negative;

/// Normal equations of rows `[offset, free unknowns, non-negative unknowns, target]`.
pub struct Normal {
    free: usize,
    gram: Array2<f64>,
}

/// What solves them.
pub struct Solution {
    /// Change of the free unknowns.
    pub free: Vec<f64>,
    /// The non-negative unknowns.
    pub weights: Vec<f64>,
    /// Root of the sum of squares that is left over, damping not counted.
    pub rms: f64,
}

impl Normal {
    /// For so many free and non-negative unknowns.
    pub fn new(free: usize, weights: usize) -> Self {
        let columns = 1 + free + weights + 1;
        Self {
            free,
            gram: Array2::zeros((columns, columns)),
        }
    }

    /// Entries of a row.
    pub fn columns(&self) -> usize {
        self.gram.ncols()
    }

    /// Adds the rows of one run, weights multiplied in; the offset is that of all runs, or its own.
    pub fn add(&mut self, rows: &Array2<f64>, own_offset: bool) {
        let mut gram = rows.t().dot(rows);
        if own_offset {
            eliminate(&mut gram, 0);
        }
        self.gram += &gram;
    }

    /// Solves with `damping` added to the squares of the free unknowns and the first non-negative
    /// unknown not below `floor`.
    pub fn solve(&self, damping: f64, floor: f64) -> Solution {
        let columns = self.columns();
        let mut gram = self.gram.clone();
        eliminate(&mut gram, 0);
        let undamped = gram.clone();
        for j in 1..=self.free {
            gram[(j, j)] += damping;
        }
        let before = gram.clone();
        for j in 1..=self.free {
            eliminate(&mut gram, j);
        }
        // What is left concerns the non-negative unknowns: a triangle again.
        let first = 1 + self.free;
        let weights = columns - 1 - first;
        let target = columns - 1;
        let mut square = DMatrix::from_fn(weights, weights, |i, j| gram[(first + i, first + j)]);
        let mut right = DVector::from_fn(weights, |i, _| {
            gram[(first + i, target)] - floor * gram[(first + i, first)]
        });
        // Plays next to each other are almost the same: a hair keeps the triangle regular.
        let hair = 1e-12 * square.diagonal().max();
        for i in 0..weights {
            square[(i, i)] += hair.max(f64::MIN_POSITIVE);
        }
        let mut found = match square.cholesky() {
            Some(cholesky) => {
                let l = cholesky.l();
                if l.solve_lower_triangular_mut(&mut right) {
                    non_negative(&l.transpose(), &right)
                } else {
                    vec![0.0; weights]
                }
            }
            None => vec![0.0; weights],
        };
        if let Some(first) = found.first_mut() {
            *first += floor;
        }
        let mut free = vec![0.0; self.free];
        if self.free > 0 {
            let left = DMatrix::from_fn(self.free, self.free, |i, j| before[(1 + i, 1 + j)]);
            let right = DVector::from_fn(self.free, |i, _| {
                let explained: f64 = found
                    .iter()
                    .enumerate()
                    .map(|(j, a)| a * before[(1 + i, first + j)])
                    .sum();
                before[(1 + i, target)] - explained
            });
            if let Some(solved) = left.lu().solve(&right) {
                free = solved.iter().copied().collect();
            }
        }
        // Square of what the row [0, free, weights, -1] of unknowns makes of the columns.
        let unknowns: Vec<f64> = std::iter::once(0.0)
            .chain(free.iter().copied())
            .chain(found.iter().copied())
            .chain([-1.0])
            .collect();
        let unknowns = ndarray::Array1::from(unknowns);
        let left = unknowns.dot(&undamped.dot(&unknowns));
        Solution {
            free,
            weights: found,
            rms: left.max(0.0).sqrt(),
        }
    }
}

/// Takes the unknown `j` out of the others' equations.
fn eliminate(gram: &mut Array2<f64>, j: usize) {
    let pivot = gram[(j, j)];
    if pivot.is_nan() || pivot <= 0.0 {
        return;
    }
    let row = gram.row(j).to_owned();
    for i in 0..gram.nrows() {
        let share = row[i] / pivot;
        if share != 0.0 {
            gram.row_mut(i).scaled_add(-share, &row);
        }
    }
}
