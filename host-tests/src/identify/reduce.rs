//! Linear least squares on tall matrices: rows are folded into a triangle, a block at a time, so
//! memory is bounded by the number of columns; a non-negative solution is found on the triangle.

use nalgebra::{DMatrix, DVector};

/// Rows folded at a time.
const BLOCK: usize = 512;

/// The R factor of all rows pushed so far.
pub struct Triangle {
    columns: usize,
    /// The triangle on top, new rows below it.
    buffer: DMatrix<f64>,
    filled: usize,
}

impl Triangle {
    /// For rows of the given number of columns.
    pub fn new(columns: usize) -> Self {
        Self {
            columns,
            buffer: DMatrix::zeros(columns + BLOCK, columns),
            filled: columns,
        }
    }

    /// Adds a row, given by its entries, each scaled by `weight`.
    pub fn push(&mut self, weight: f64, row: impl Iterator<Item = f64>) {
        for (j, value) in row.take(self.columns).enumerate() {
            self.buffer[(self.filled, j)] = weight * value;
        }
        self.filled += 1;
        if self.filled == self.buffer.nrows() {
            self.fold();
        }
    }

    fn fold(&mut self) {
        let r = self.buffer.rows(0, self.filled).into_owned().qr().r();
        self.buffer.fill(0.0);
        self.buffer.rows_mut(0, r.nrows()).copy_from(&r);
        self.filled = self.columns;
    }

    /// The triangle: square, upper triangular, one row and column a column of the rows.
    pub fn finish(mut self) -> DMatrix<f64> {
        self.fold();
        self.buffer.rows(0, self.columns).into_owned()
    }
}

/// Minimises `|A x - b|` over `x >= 0` for a small matrix (Lawson and Hanson).
pub fn non_negative(a: &DMatrix<f64>, b: &DVector<f64>) -> Vec<f64> {
    if a.is_empty() {
        return vec![0.0; a.ncols()];
    }
    // Columns of one size: the solver's tolerance for dependent columns is absolute.
    let scale: Vec<f64> = a.column_iter().map(|c| c.norm()).collect();
    let scaled = ndarray::Array2::from_shape_fn((a.nrows(), a.ncols()), |(i, j)| {
        if scale[j] > 0.0 {
            a[(i, j)] / scale[j]
        } else {
            0.0
        }
    });
    let b = ndarray::Array1::from_iter(b.iter().copied());
    let (x, _) = nnls::nnls(scaled.view(), b.view());
    x.iter()
        .zip(&scale)
        .map(|(&x, &s)| if s > 0.0 { x / s } else { 0.0 })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangle has the Gram matrix of the rows.
    #[test]
    fn triangle_keeps_the_gram_matrix() {
        let rows: Vec<[f64; 3]> = (0..1500)
            .map(|k| {
                let t = k as f64 * 0.01;
                [1.0, t.sin(), (3.0 * t).cos() * t]
            })
            .collect();
        let mut triangle = Triangle::new(3);
        let mut gram = DMatrix::<f64>::zeros(3, 3);
        for row in &rows {
            triangle.push(2.0, row.iter().copied());
            let row = 2.0 * DVector::from_row_slice(row);
            gram += &row * row.transpose();
        }
        let r = triangle.finish();
        assert!((r.transpose() * &r - &gram).norm() < 1e-10 * gram.norm());
    }

    /// Karush-Kuhn-Tucker: the gradient vanishes where x > 0 and does not point down where x = 0.
    #[test]
    fn non_negative_solution_is_optimal() {
        let a = DMatrix::from_fn(8, 5, |i, j| {
            ((i * 7 + j * 3) % 11) as f64 - 4.0 + (j == i) as u8 as f64
        });
        let b = DVector::from_fn(8, |i, _| ((i * 5) % 7) as f64 - 2.0);
        let x = DVector::from_vec(non_negative(&a, &b));
        let gradient = a.transpose() * (&a * &x - &b);
        assert!(x.iter().any(|&x| x == 0.0) && x.iter().any(|&x| x > 0.0));
        for (x, g) in x.iter().zip(gradient.iter()) {
            assert!(
                *x >= 0.0 && if *x > 0.0 { g.abs() < 1e-9 } else { *g > -1e-9 },
                "{x} {g}"
            );
        }
    }
}
