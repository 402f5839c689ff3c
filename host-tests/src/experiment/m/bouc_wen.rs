//! The rival: an enhanced Bouc-Wen model, after Fujii, Tatebatake, Morita and Shiinoki, Actuators
//! 7(3), 2018.
//!
//! ```text
//! y[k] = d u[k] - h[k] + e + c_1 y[k-1] + c_2 y[k-2] + c_3 y[k-3] + harmonic terms of (M 34)
//! h'   = a u' - beta |u'| h - gamma u' |h|
//! ```
//!
//! Paper M names this model without its equations. What is taken here is the Bouc-Wen equation with
//! exponent one, four parameters with d, in the place of the plays; everything else is given to it as
//! to the proposed model, g apart, which came later. So the comparison is one of hysteresis operators.

use std::cell::RefCell;

use nalgebra::{DMatrix, DVector};

use crate::error::Error;

use super::free_run::{Feedback, Samples, Stretch};
use super::model::{COEFFICIENTS, DIVISIONS, Recipe};
use super::record::Record;
use super::separable::{Separable, at, search};

/// Starts for beta, in 1 over full drive, and for gamma over beta.
const BETAS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];
const GAMMAS: [f64; 3] = [-0.8, 0.0, 0.8];
/// Every so many samples count in the one-step error: prime, so that all sampling phases do.
const EVERY: usize = 11;

/// An identified rival.
#[derive(Clone, Debug, PartialEq)]
pub struct BoucWen {
    /// beta and gamma over full drive.
    shape: [f64; 2],
    /// c_1 to c_3.
    feedback: [f64; 3],
    /// -a, d, e, then the harmonic terms.
    weights: [f64; FIXED + 1],
}

/// h along a drive, for a = 1, from h = 0, by the trapezoidal rule.
fn states(drive: &[f64], [beta, gamma]: [f64; 2]) -> Vec<f64> {
    let (mut h, mut before) = (0.0_f64, 0.0);
    drive
        .iter()
        .map(|&u| {
            let change = u - before;
            before = u;
            let decay = beta * change.abs() + gamma * change * h.signum();
            h += (change - decay * h) / (1.0 + 0.5 * decay);
            h
        })
        .collect()
}

/// Whether the equation is bounded and dissipates.
fn admissible([beta, gamma]: [f64; 2]) -> bool {
    (1e-3..=1e3).contains(&beta) && gamma.abs() <= beta
}

/// Drive, offset and harmonic terms, which do not depend on what is searched.
const FIXED: usize = 8;

/// Those terms along a record, one row a sample, a first entry left to h.
fn terms(record: &Record) -> Result<Vec<[f64; FIXED + 1]>, Error> {
    let row = |row: &[f64; COEFFICIENTS]| {
        let mut terms = [0.0; FIXED + 1];
        (terms[1], terms[2]) = (row[0], row[DIVISIONS]);
        terms[3..].copy_from_slice(&row[COEFFICIENTS - 6..]);
        terms
    };
    Ok(Recipe::PROPOSED.rows(record)?.iter().map(row).collect())
}

fn starts() -> impl Iterator<Item = [f64; 2]> {
    BETAS
        .into_iter()
        .flat_map(|beta| GAMMAS.map(|share| [beta, share * beta]))
}

/// Everything but beta and gamma is linear in the one-step error.
struct OneStep<'a> {
    record: &'a Record,
    terms: &'a [[f64; FIXED + 1]],
}

impl Separable for OneStep<'_> {
    fn columns(&self, parameters: &[f64]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let shape = *parameters.first_chunk::<2>()?;
        if !admissible(shape) {
            return None;
        }
        let h = states(&self.record.drive, shape);
        let y = &self.record.displacement_mm;
        let entry = |row: usize, column: usize| {
            let k = EVERY * row;
            match column {
                0 => h[k],
                1..=FIXED => self.terms[k][column],
                // The three outputs before, of which there are none before the first.
                _ => k.checked_sub(column - FIXED).map_or(0.0, |k| y[k]),
            }
        };
        let rows = y.len().div_ceil(EVERY);
        let columns = DMatrix::from_fn(rows, FIXED + 4, entry);
        let target = DVector::from_fn(rows, |row, _| y[EVERY * row]);
        Some((columns, target))
    }

    fn scales(&self) -> &[f64] {
        &[1.0, 1.0]
    }
}

/// Nonlinear in c_1 to c_3, beta and gamma.
struct FreeRun<'a> {
    record: &'a Record,
    stretch: Stretch<'a>,
    /// Shape for which the first entry of the terms holds h, and the terms over the stretch: most
    /// derivatives leave the shape alone.
    terms: RefCell<([f64; 2], Vec<[f64; FIXED + 1]>)>,
}

impl Separable for FreeRun<'_> {
    fn columns(&self, parameters: &[f64]) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let (feedback, shape) = parameters.split_first_chunk::<3>()?;
        let shape = *shape.first_chunk::<2>()?;
        if !admissible(shape) {
            return None;
        }
        let mut held = self.terms.borrow_mut();
        let (held_shape, terms) = &mut *held;
        if *held_shape != shape {
            *held_shape = shape;
            let h = states(&self.record.drive, shape);
            for (row, h) in terms.iter_mut().zip(&h[self.stretch.first()..]) {
                row[0] = *h;
            }
        }
        self.stretch.columns(Feedback::of(feedback)?, terms)
    }

    fn scales(&self) -> &[f64] {
        &[1.0; 5]
    }
}

impl BoucWen {
    /// Identifies by the one-step error over a record.
    ///
    /// # Errors
    /// A record from which no start leads to a model.
    pub fn identify_one_step(record: &Record) -> Result<Self, Error> {
        let problem = OneStep {
            record,
            terms: &terms(record)?,
        };
        let starts = starts().map(|shape| shape.to_vec());
        let fit = search(&problem, &problem, starts).ok_or_else(no_model)?;
        let (rest, feedback) = fit.linear.split_last_chunk::<3>().ok_or_else(no_model)?;
        Self::assemble(&fit.parameters, *feedback, rest)
    }

    /// Identifies by the error of the free run; `feedbacks` are starts for c_1 to c_3.
    ///
    /// # Errors
    /// A record from which no start leads to a model.
    pub fn identify_free_run(record: &Record, feedbacks: &[[f64; 3]]) -> Result<Self, Error> {
        let terms = terms(record)?;
        let problem = |samples| {
            let stretch = Stretch::new(record, samples);
            // No shape equals NaN.
            let terms = RefCell::new(([f64::NAN; 2], terms[stretch.first()..].to_vec()));
            FreeRun {
                record,
                stretch,
                terms,
            }
        };
        // Of each feedback the best shape: the starts stay apart from each other.
        let sparse = problem(Samples::Sparse);
        let starts = feedbacks.iter().filter_map(|feedback| {
            let shapes = starts().map(|shape| at(&sparse, &[&feedback[..], &shape].concat()));
            let best = shapes.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
            Some(best.parameters)
        });
        let fit = search(&sparse, &problem(Samples::All), starts).ok_or_else(no_model)?;
        let (feedback, shape) = fit
            .parameters
            .split_first_chunk::<3>()
            .ok_or_else(no_model)?;
        Self::assemble(shape, *feedback, &fit.linear)
    }

    /// `linear` holds -a, d, e and the harmonics, in the order of the columns.
    fn assemble(shape: &[f64], feedback: [f64; 3], linear: &[f64]) -> Result<Self, Error> {
        let shape = *shape.first_chunk::<2>().ok_or_else(no_model)?;
        let weights = *linear.first_chunk::<{ FIXED + 1 }>().ok_or_else(no_model)?;
        Ok(Self {
            shape,
            feedback,
            weights,
        })
    }

    /// What the terms give without output feedback, mm.
    fn forward(&self, record: &Record) -> Result<Vec<f64>, Error> {
        let h = states(&record.drive, self.shape);
        let terms = terms(record)?;
        let weighted = terms.iter().zip(h).map(|(row, h)| {
            let fixed = row.iter().zip(&self.weights).skip(1);
            self.weights[0] * h + fixed.map(|(term, weight)| term * weight).sum::<f64>()
        });
        Ok(weighted.collect())
    }

    /// c_1 to c_3.
    pub fn feedback(&self) -> [f64; 3] {
        self.feedback
    }

    /// Output along the record's drive from the model's own outputs, mm.
    ///
    /// # Errors
    /// A frequency above half the sample rate.
    pub fn free_run(&self, record: &Record) -> Result<Vec<f64>, Error> {
        let [c1, c2, c3] = self.feedback;
        let [mut y1, mut y2, mut y3] = [0.0; 3];
        let forward = self.forward(record)?.into_iter();
        Ok(forward
            .map(|x| {
                let y = x + c1 * y1 + c2 * y2 + c3 * y3;
                (y1, y2, y3) = (y, y1, y2);
                y
            })
            .collect())
    }

    /// Output along a record from the measured outputs before each sample, mm.
    ///
    /// # Errors
    /// A frequency above half the sample rate.
    pub fn one_step(&self, record: &Record) -> Result<Vec<f64>, Error> {
        let [c1, c2, c3] = self.feedback;
        let mut before = [0.0; 3];
        let forward = self.forward(record)?.into_iter();
        let samples = forward.zip(&record.displacement_mm);
        Ok(samples
            .map(|(x, &measured)| {
                let [y1, y2, y3] = before;
                before = [measured, y1, y2];
                x + c1 * y1 + c2 * y2 + c3 * y3
            })
            .collect())
    }
}

fn no_model() -> Error {
    crate::experiment::refused("no start leads to a Bouc-Wen model")
}
