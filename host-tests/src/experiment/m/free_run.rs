//! Identification for the free run: outputs in the terms are the model's own, and the error that is
//! made small is that of the simulated output.
//!
//! For given c_1 to c_3 and g the output is linear in all other coefficients: each of their terms
//! passes through `1 - (c_1 + g u[k-1]) q - c_2 q^2 - c_3 q^3`, q a delay.

use nalgebra::{DMatrix, DVector};

use super::record::{Record, SECOND};
use super::separable::Separable;

/// Samples before those that are fitted, in which what the start leaves dies out.
const WARM_UP: usize = SECOND / 5;
/// Rows of a sparse problem, about.
const SPARSE_ROWS: usize = 625;

/// Which samples count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// For a search from afar: some of the last period, or of the last quarter of a second.
    Sparse,
    /// Where a search ends: all that are scored.
    All,
}

/// Magnitude of a pole that counts as stable: 1 % is left after a second.
const STABLE: f64 = 0.9991;

/// Output feedback: c_1 to c_3, and g.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feedback {
    /// c_1 to c_3.
    pub c: [f64; 3],
    /// g.
    pub g: f64,
}

impl Feedback {
    /// From nonlinear parameters that begin with c_1 to c_3, and a g if there is one more.
    pub fn of(parameters: &[f64]) -> Option<Self> {
        let (c, rest) = parameters.split_first_chunk::<3>()?;
        Some(Self {
            c: *c,
            g: rest.first().copied().unwrap_or(0.0),
        })
    }

    /// Whether the output dies out without terms: Jury's test of the poles, drawn in by [`STABLE`]. g
    /// times the drive, of zero mean, is left out.
    fn is_stable(&self) -> bool {
        let [c1, c2, c3] = self.c;
        let (a, b, c) = (
            -c1 / STABLE,
            -c2 / (STABLE * STABLE),
            -c3 / (STABLE * STABLE * STABLE),
        );
        c.abs() < 1.0
            && 1.0 + a + b + c > 0.0
            && 1.0 - a + b - c > 0.0
            && (c * c - 1.0).abs() > (c * a - b).abs()
    }
}

/// The stretch of a record that is fitted.
#[derive(Clone, Debug)]
pub struct Stretch<'a> {
    /// Drive of the sample before, from the first sample on.
    previous: &'a [f64],
    measured: &'a [f64],
    /// The three outputs before, latest first.
    before: [f64; 3],
    first: usize,
    fitted: usize,
    every: usize,
}

impl<'a> Stretch<'a> {
    /// The end of a record.
    pub fn new(record: &'a Record, samples: Samples) -> Self {
        let (fitted, every) = match samples {
            Samples::All => (SECOND, 1),
            Samples::Sparse => {
                let period = (SECOND as f64 / record.frequency_hz).ceil() as usize;
                let fitted = period.clamp(SECOND / 4, SECOND);
                (fitted, fitted / SPARSE_ROWS)
            }
        };
        let first = record.drive.len() - WARM_UP - fitted;
        let y = &record.displacement_mm;
        Self {
            previous: &record.drive[first - 1..],
            measured: &y[first..],
            before: [y[first - 1], y[first - 2], y[first - 3]],
            first,
            fitted,
            every,
        }
    }

    /// Number of samples that count.
    fn rows(&self) -> usize {
        self.fitted.div_ceil(self.every)
    }

    /// Number of its first sample in the record.
    pub fn first(&self) -> usize {
        self.first
    }

    /// Columns of the terms, one row of them a sample, and the target, for this feedback; `None`
    /// where it is unstable.
    pub fn columns<const W: usize>(
        &self,
        feedback: Feedback,
        terms: &[[f64; W]],
    ) -> Option<(DMatrix<f64>, DVector<f64>)> {
        if !feedback.is_stable() {
            return None;
        }
        let mut columns = DMatrix::zeros(self.rows(), W);
        // Terms side by side: one after the other each would wait for its own last output.
        let [mut y1, mut y2, mut y3] = [[0.0; W]; 3];
        for (k, (x, u)) in terms.iter().zip(self.previous).enumerate() {
            let Feedback { c, g } = feedback;
            let latest = c[0] + g * u;
            let mut y = *x;
            for (((y, y1), y2), y3) in y.iter_mut().zip(&y1).zip(&y2).zip(&y3) {
                *y += latest * y1 + c[1] * y2 + c[2] * y3;
            }
            (y1, y2, y3) = (y, y1, y2);
            if let Some(row) = self.row(k) {
                for (to, from) in columns.row_mut(row).iter_mut().zip(y) {
                    *to = from;
                }
            }
        }
        Some((columns, self.target(feedback)))
    }

    /// What the terms have to make up: the measured outputs less what the outputs before the stretch
    /// leave by themselves.
    fn target(&self, Feedback { c, g }: Feedback) -> DVector<f64> {
        let mut target = DVector::zeros(self.rows());
        let [mut y1, mut y2, mut y3] = self.before;
        for (k, (measured, u)) in self.measured.iter().zip(self.previous).enumerate() {
            let y = (c[0] + g * u) * y1 + c[1] * y2 + c[2] * y3;
            (y1, y2, y3) = (y, y1, y2);
            if let Some(row) = self.row(k) {
                target[row] = measured - y;
            }
        }
        target
    }

    /// Row of the sample `k` of the stretch, if it counts.
    fn row(&self, k: usize) -> Option<usize> {
        let after = k.checked_sub(WARM_UP)?;
        after
            .is_multiple_of(self.every)
            .then_some(after / self.every)
    }
}

/// The proposed model's free run: nonlinear in c_1 to c_3 and, if it has it, g.
#[derive(Clone, Debug)]
pub struct FreeRun<'a, const W: usize> {
    stretch: Stretch<'a>,
    /// Terms of all linear coefficients, from the beginning of the stretch.
    terms: &'a [[f64; W]],
    scales: &'static [f64],
}

impl<'a, const W: usize> FreeRun<'a, W> {
    /// The problem for a record and the terms of the linear coefficients along all of it; `with_g`
    /// makes g a fourth nonlinear parameter.
    pub fn new(record: &'a Record, terms: &'a [[f64; W]], with_g: bool, samples: Samples) -> Self {
        let stretch = Stretch::new(record, samples);
        Self {
            terms: &terms[stretch.first()..],
            stretch,
            scales: if with_g { &[1.0; 4] } else { &[1.0; 3] },
        }
    }
}

impl<const W: usize> Separable for FreeRun<'_, W> {
    fn columns(&self, parameters: &[f64]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        self.stretch.columns(Feedback::of(parameters)?, self.terms)
    }

    fn scales(&self) -> &[f64] {
        self.scales
    }
}
