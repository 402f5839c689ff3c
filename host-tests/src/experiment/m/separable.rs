//! Nonlinear least squares where most parameters are linear: those are eliminated, and the few
//! others searched by Levenberg-Marquardt.

use std::cmp::Ordering;

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

/// Weight of a linear parameter's own size beside that of its column, relative: only where columns
/// cannot be told apart does it decide anything.
const RIDGE: f64 = 1e-13;
/// From how many of the best starts a search is run.
const SEARCHES: usize = 3;
/// Steps of a search from afar.
const STEPS_FROM_AFAR: usize = 60;
/// Steps of a search near its end.
pub const LAST_STEPS: usize = 12;
/// Step of the numeric derivatives, relative to the scale of a parameter.
const STEP: f64 = 1e-6;

/// Residual that stands for inadmissible parameters: larger than any displacement, mm.
const INADMISSIBLE: f64 = 1e3;

/// A model `target = columns(parameters) linear`.
pub trait Separable {
    /// Columns and target for these nonlinear parameters; `None` where they are inadmissible.
    fn columns(&self, parameters: &[f64]) -> Option<(DMatrix<f64>, DVector<f64>)>;

    /// What change of a parameter matters.
    fn scales(&self) -> &[f64];
}

/// A fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Nonlinear parameters.
    pub parameters: Vec<f64>,
    /// Linear parameters, one a column.
    pub linear: Vec<f64>,
    /// Sum of the squared residuals; infinite for inadmissible parameters.
    pub cost: f64,
}

/// The linear parameters for given nonlinear ones, and the residual.
fn eliminate(model: &impl Separable, parameters: &[f64]) -> Option<(Vec<f64>, DVector<f64>)> {
    let (mut columns, target) = model.columns(parameters)?;
    let sizes: Vec<f64> = columns
        .column_iter()
        .map(|column| column.norm().max(f64::MIN_POSITIVE))
        .collect();
    for (mut column, size) in columns.column_iter_mut().zip(&sizes) {
        column /= *size;
    }
    let normal = DMatrix::from_fn(sizes.len(), sizes.len(), |i, j| match i.cmp(&j) {
        Ordering::Less => 0.0,
        Ordering::Equal => 1.0 + RIDGE,
        Ordering::Greater => columns.column(i).dot(&columns.column(j)),
    });
    // Only the lower triangle is read.
    let factor = normal.cholesky()?;
    let mut linear = factor.solve(&columns.tr_mul(&target));
    // Normal equations square the condition number; a second pass over the residual mends that.
    let rest = &target - &columns * &linear;
    linear += factor.solve(&columns.tr_mul(&rest));
    let residual = &columns * &linear - target;
    let linear: Vec<f64> = linear
        .iter()
        .zip(&sizes)
        .map(|(a, size)| a / size)
        .collect();
    let finite = residual
        .iter()
        .chain(&linear)
        .all(|value| value.is_finite());
    finite.then_some((linear, residual))
}

/// Linear parameters and cost at given nonlinear ones.
pub fn at(model: &impl Separable, parameters: &[f64]) -> Fit {
    let (linear, cost) = match eliminate(model, parameters) {
        Some((linear, residual)) => (linear, residual.norm_squared()),
        None => (Vec::new(), f64::INFINITY),
    };
    Fit {
        parameters: parameters.to_vec(),
        linear,
        cost,
    }
}

/// Searches for the least cost from the best of many starts: from afar on a problem with `sparse`
/// samples, in the end on `all` of them.
pub fn search(
    sparse: &impl Separable,
    all: &impl Separable,
    starts: impl Iterator<Item = Vec<f64>>,
) -> Option<Fit> {
    let mut tried: Vec<Fit> = starts.map(|start| at(sparse, &start)).collect();
    tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    tried
        .iter()
        .take(SEARCHES)
        .map(|start| minimise(sparse, &start.parameters, STEPS_FROM_AFAR))
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
        .map(|found| minimise(all, &found.parameters, LAST_STEPS))
        .filter(|fit| fit.cost.is_finite())
}

/// Searches from `start` for about `steps` steps, none of which makes it worse.
pub fn minimise(model: &impl Separable, start: &[f64], steps: usize) -> Fit {
    let before = at(model, start);
    if !before.cost.is_finite() {
        return before;
    }
    let scales = model.scales();
    let Some((_, residual)) = eliminate(model, start) else {
        return before;
    };
    let problem = Problem {
        model,
        rows: residual.len(),
        scaled: DVector::from_iterator(
            start.len(),
            start.iter().zip(scales).map(|(value, scale)| value / scale),
        ),
    };
    let (problem, _) = LevenbergMarquardt::new()
        .with_patience((steps / (start.len() + 1)).max(1))
        .with_ftol(1e-7)
        .with_xtol(1e-8)
        .minimize(problem);
    let found = at(model, &problem.parameters());
    if found.cost < before.cost {
        found
    } else {
        before
    }
}

struct Problem<'a, S> {
    model: &'a S,
    rows: usize,
    scaled: DVector<f64>,
}

impl<S: Separable> Problem<'_, S> {
    fn parameters(&self) -> Vec<f64> {
        let scales = self.model.scales();
        self.scaled.iter().zip(scales).map(|(a, b)| a * b).collect()
    }
}

impl<S: Separable> LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_, S> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, scaled: &DVector<f64>) {
        self.scaled.copy_from(scaled);
    }

    fn params(&self) -> DVector<f64> {
        self.scaled.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        // A step into what is inadmissible is a bad step, not the end of the search.
        let found = eliminate(self.model, &self.parameters());
        Some(found.map_or_else(
            || DVector::from_element(self.rows, INADMISSIBLE),
            |(_, residual)| residual,
        ))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let here = self.residuals()?;
        let mut jacobian = DMatrix::zeros(here.len(), self.scaled.len());
        for (i, mut column) in jacobian.column_iter_mut().enumerate() {
            // Where one side is inadmissible, the other one is taken.
            let beside = |step: f64| {
                let mut parameters = self.parameters();
                parameters[i] += step * self.model.scales()[i];
                let (_, residual) = eliminate(self.model, &parameters)?;
                Some((residual - &here) / step)
            };
            column.copy_from(&beside(STEP).or_else(|| beside(-STEP))?);
        }
        Some(jacobian)
    }
}
