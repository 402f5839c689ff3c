//! The fit itself: thresholds and beta by Levenberg-Marquardt, weights and slopes inside it by
//! non-negative linear least squares (variable projection, Kaufman's approximation).
//!
//! Every pass over the data folds its rows into a small triangle, so the optimiser only ever sees
//! problems of the size of the parameters, whatever the length of the records.

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::dataset::Role;

use super::map::Map;
use super::plays::{Plays, Walk};
use super::reduce::{Triangle, non_negative};
use super::run::{Run, Runs, Span};

/// Share of the stage's mean gain that the weight of the drive itself keeps at least: with none the
/// model has no inverse, with little of it the inverse leaps wherever the reference turns.
const LEAST_WEIGHT_0: f64 = 0.1;

/// How thresholds are parametrised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Thresholds {
    /// Multiples of one spacing, `alpha_i = zeta i` (J 25).
    Spaced,
    /// Each gap on its own.
    Free,
    /// Not fitted.
    Fixed,
}

/// What is fitted from which rows.
#[derive(Clone, Copy, Debug)]
pub struct Fit<'a> {
    /// The data.
    pub runs: &'a Runs,
    /// Emphasis of each record of the data set, A_p of (J 44); 1 for all weighs them equally.
    pub emphasis: &'a [f64],
    /// How many rows to use at most; of longer records an even choice of samples is taken.
    pub most_rows: usize,
}

/// A fitted hysteresis with its map, in micrometres per volt.
#[derive(Clone, Debug, PartialEq)]
pub struct Fitted {
    /// Thresholds and beta.
    pub plays: Plays,
    /// Weights a_0..a_n in um/V.
    pub weights: Vec<f64>,
    /// The map behind them, argument and value in um.
    pub map: Option<Map>,
    /// Root of the weighted mean square residual over the rows used, in um.
    pub rms: f64,
}

impl Fitted {
    /// Displacement in um, less the offset, for a drive and the outputs of the plays there.
    pub fn displacement(&self, drive: f64, outputs: &[f64]) -> f64 {
        let w = self.w(drive, outputs);
        self.map.as_ref().map_or(w, |map| map.value(w))
    }

    /// Without the plays that got no weight; at least one stays.
    pub fn pruned(mut self) -> Self {
        let mut kept: Vec<usize> = (0..self.plays.thresholds.len())
            .filter(|&i| self.weights[i + 1] > 0.0)
            .collect();
        if kept.is_empty() {
            kept.push(0);
        }
        self.plays.thresholds = kept.iter().map(|&i| self.plays.thresholds[i]).collect();
        self.weights = std::iter::once(self.weights[0])
            .chain(kept.iter().map(|&i| self.weights[i + 1]))
            .collect();
        self
    }

    /// Sum of the weights, in um/V.
    pub fn gain(&self) -> f64 {
        self.weights.iter().sum()
    }

    fn w(&self, drive: f64, outputs: &[f64]) -> f64 {
        self.weights[0] * drive
            + self.weights[1..]
                .iter()
                .zip(outputs)
                .map(|(a, z)| a * z)
                .sum::<f64>()
    }
}

impl Fit<'_> {
    /// Fits weights, and the free slopes of `map` if there is one, for given plays; `start` gives
    /// the weights around which the map is linearised.
    pub fn weights(&self, plays: &Plays, start: Option<&Fitted>, map: Option<Map>) -> Fitted {
        let mut fitted = Fitted {
            plays: plays.clone(),
            weights: match start {
                Some(start) => start.weights.clone(),
                None => vec![0.0; plays.thresholds.len() + 1],
            },
            map,
            rms: f64::INFINITY,
        };
        // The product of weights and slopes is linearised: Gauss-Newton, which settles quickly
        // because maps are nearly straight.
        let passes = if fitted.map.is_some() { 4 } else { 1 };
        for _ in 0..passes {
            self.linear_pass(&mut fitted);
        }
        fitted
    }

    /// Fits plays, weights and slopes, starting from `start`.
    pub fn minimise(&self, start: &Fitted, thresholds: Thresholds, with_beta: bool) -> Fitted {
        let parameters = Parameters::of(&start.plays, thresholds, with_beta);
        if parameters.values.is_empty() {
            return self.weights(&start.plays, Some(start), start.map.clone());
        }
        let problem = Problem::new(self, parameters, start.clone());
        let (problem, _) = LevenbergMarquardt::new()
            .with_ftol(1e-9)
            .with_xtol(1e-9)
            .with_stepbound(1.0)
            .with_patience(20)
            .minimize(problem);
        problem.fitted
    }

    fn linear_pass(&self, fitted: &mut Fitted) {
        let plays = fitted.plays.thresholds.len();
        let slopes = fitted.map.as_ref().map_or(0, Map::free_slopes);
        let columns = 1 + plays + slopes;
        let floor = LEAST_WEIGHT_0 * self.runs.mean_gain();
        let triangle = self.triangle(&fitted.plays, columns + 1, |run, k, walk, row| {
            let (u, y) = (run.drive[k], run.displacement[k]);
            let linear = [u].into_iter().chain(walk.outputs.iter().copied());
            match &fitted.map {
                None => {
                    row.extend(linear);
                    row.push(y - floor * u);
                }
                Some(map) => {
                    let w = fitted.w(u, &walk.outputs);
                    let slope = map.slope(w);
                    row.extend(linear.map(|z| slope * z));
                    row.extend(map.by_slope(w));
                    row.push(y + slope * w - map.floor(w) - floor * slope * u);
                }
            }
        });
        let (a, b) = (triangle.columns(0, columns), triangle.column(columns));
        let mut a = a.into_owned();
        for (i, r) in fitted.plays.thresholds.iter().enumerate() {
            if *r > self.runs.widest_threshold() * (1.0 + 1e-9) {
                a.column_mut(i + 1).fill(0.0);
            }
        }
        let solution = non_negative(&a, &b.into_owned());
        let residual = triangle.columns(0, columns) * DVector::from_column_slice(&solution)
            - triangle.column(columns);
        fitted.rms = residual.norm();
        fitted.weights = solution[..=plays].to_vec();
        fitted.weights[0] += floor;
        if let Some(map) = &mut fitted.map {
            map.set_slopes(&solution[plays + 1..]);
        }
    }

    /// Passes over the scored rows of the fit and folds what `fill` makes of each into a triangle,
    /// offsets already projected out.
    fn triangle(
        &self,
        plays: &Plays,
        columns: usize,
        mut fill: impl FnMut(&Run, usize, &Walk, &mut Vec<f64>),
    ) -> DMatrix<f64> {
        let spans: Vec<(usize, &Run, &Span)> = self.runs.scored(Role::Fit).collect();
        let total: usize = spans.iter().map(|(_, _, span)| span.samples.len()).sum();
        let share = self.most_rows as f64 / total.max(1) as f64;
        let emphasis: f64 = spans
            .iter()
            .map(|(_, _, span)| self.emphasis[span.record])
            .sum();

        let mut all = Triangle::new(columns);
        let mut shared = Triangle::new(columns + 1);
        let mut row = Vec::with_capacity(columns + 1);
        for (index, run) in self.runs.runs.iter().enumerate() {
            let spans: Vec<&Span> = spans
                .iter()
                .filter(|(i, _, _)| *i == index)
                .map(|(_, _, span)| *span)
                .collect();
            let Some(last) = spans.last() else { continue };
            let mut own = Triangle::new(columns + 1);
            let mut walk = Walk::new(plays, run);
            let mut position = 0;
            for span in &spans {
                while position < span.samples.start {
                    walk.step(plays, run, position);
                    position += 1;
                }
                // A record of its own weight, whatever its length; short ones keep all their rows.
                let len = span.samples.len();
                let share = share.max(400.0 / len.max(1) as f64).min(1.0);
                let rows = (0..len).filter(|&k| chosen(k, share)).count();
                let weight = (self.emphasis[span.record] / emphasis / rows.max(1) as f64).sqrt();
                for k in span.samples.clone() {
                    walk.step(plays, run, k);
                    if chosen(k - span.samples.start, share) {
                        row.clear();
                        row.push(1.0);
                        fill(run, k, &walk, &mut row);
                        let triangle = if self.runs.own_offsets {
                            &mut own
                        } else {
                            &mut shared
                        };
                        triangle.push(weight, row.iter().copied());
                    }
                }
                position = span.samples.end;
            }
            debug_assert_eq!(position, last.samples.end);
            if self.runs.own_offsets {
                without_offset(own, &mut all);
            }
        }
        if !self.runs.own_offsets {
            without_offset(shared, &mut all);
        }
        all.finish()
    }
}

/// Whether sample `k` is one of the given share of samples. Multiples of the golden ratio leave no
/// phase of a periodic drive out, which a fixed stride may.
fn chosen(k: usize, share: f64) -> bool {
    share >= 1.0 || (k as f64 * 0.618_033_988_749_894_9).fract() < share
}

/// Eliminates the first column of a triangle, the offset, and folds the rest into another.
fn without_offset(from: Triangle, into: &mut Triangle) {
    let r = from.finish();
    for i in 1..r.nrows() {
        into.push(1.0, r.row(i).iter().skip(1).copied());
    }
}

/// Logarithms of what the optimiser moves: a spacing or gaps, then beta. Logarithms keep all of
/// them positive, so that thresholds increase and gaps do not shrink.
#[derive(Clone, Debug)]
struct Parameters {
    thresholds: Thresholds,
    with_beta: bool,
    values: DVector<f64>,
}

impl Parameters {
    fn of(plays: &Plays, thresholds: Thresholds, with_beta: bool) -> Self {
        let mut values = match thresholds {
            Thresholds::Spaced => vec![plays.thresholds[0].ln()],
            Thresholds::Free => {
                let before = std::iter::once(0.0).chain(plays.thresholds.iter().copied());
                plays
                    .thresholds
                    .iter()
                    .zip(before)
                    .map(|(r, before)| (r - before).ln())
                    .collect()
            }
            Thresholds::Fixed => Vec::new(),
        };
        if with_beta {
            values.push(plays.beta.ln());
        }
        Self {
            thresholds,
            with_beta,
            values: DVector::from_vec(values),
        }
    }

    /// Keeps a step of the optimiser within what the records can show.
    fn limit(&mut self, runs: &Runs) {
        let widest = runs.widest_threshold();
        let beta_scale = widest / runs.highest_rate();
        let last = self.values.len() - 1;
        for (i, value) in self.values.iter_mut().enumerate() {
            let scale = if self.with_beta && i == last {
                beta_scale
            } else {
                widest
            };
            *value = value.clamp((1e-5 * scale).ln(), (2.0 * scale).ln());
        }
    }

    fn plays(&self, like: &Plays) -> Plays {
        let mut plays = like.clone();
        match self.thresholds {
            Thresholds::Spaced => {
                let zeta = self.values[0].exp();
                (1..)
                    .zip(&mut plays.thresholds)
                    .for_each(|(i, r)| *r = zeta * f64::from(i));
            }
            Thresholds::Free => {
                let mut sum = 0.0;
                for (r, gap) in plays.thresholds.iter_mut().zip(self.values.iter()) {
                    sum += gap.exp();
                    *r = sum;
                }
            }
            Thresholds::Fixed => {}
        }
        if self.with_beta {
            plays.beta = self.values[self.values.len() - 1].exp();
        }
        plays
    }

    /// Derivatives by each parameter of `sum a_i z_i`.
    fn gradient(&self, fitted: &Fitted, walk: &Walk, row: &mut Vec<f64>) {
        let weights = &fitted.weights[1..];
        let by_threshold = |i: usize| weights[i] * walk.by_threshold[i];
        let thresholds = &fitted.plays.thresholds;
        match self.thresholds {
            Thresholds::Spaced => {
                row.push(
                    (0..weights.len())
                        .map(|i| by_threshold(i) * thresholds[i])
                        .sum(),
                );
            }
            Thresholds::Free => {
                // A gap moves its own threshold and all above it.
                let first = row.len();
                let mut above = 0.0;
                for i in (0..weights.len()).rev() {
                    above += by_threshold(i);
                    row.push(above * self.values[i].exp());
                }
                row[first..].reverse();
            }
            Thresholds::Fixed => {}
        }
        if self.with_beta {
            let by_beta: f64 = weights.iter().zip(&walk.by_beta).map(|(a, q)| a * q).sum();
            row.push(fitted.plays.beta * by_beta);
        }
    }
}

/// The problem as the optimiser sees it: residuals and Jacobian with the linear part projected out.
struct Problem<'a> {
    fit: &'a Fit<'a>,
    parameters: Parameters,
    fitted: Fitted,
    residuals: DVector<f64>,
    jacobian: DMatrix<f64>,
}

impl<'a> Problem<'a> {
    fn new(fit: &'a Fit<'a>, parameters: Parameters, fitted: Fitted) -> Self {
        let mut problem = Self {
            fit,
            parameters,
            fitted,
            residuals: DVector::zeros(0),
            jacobian: DMatrix::zeros(0, 0),
        };
        problem.evaluate();
        problem
    }

    fn evaluate(&mut self) {
        let plays = self.parameters.plays(&self.fitted.plays);
        self.fitted = self
            .fit
            .weights(&plays, Some(&self.fitted), self.fitted.map.clone());
        let fitted = &self.fitted;
        let active: Vec<usize> = (1..fitted.weights.len())
            .filter(|&i| fitted.weights[i] > 0.0)
            .collect();
        let slopes = fitted.map.as_ref().map_or(0, Map::free_slopes);
        let linear = 1 + active.len() + slopes;
        let count = self.parameters.values.len();
        let triangle = self
            .fit
            .triangle(&plays, linear + count + 1, |run, k, walk, row| {
                let (u, y) = (run.drive[k], run.displacement[k]);
                let w = fitted.w(u, &walk.outputs);
                let (slope, value) = match &fitted.map {
                    Some(map) => (map.slope(w), map.value(w)),
                    None => (1.0, w),
                };
                row.push(slope * u);
                row.extend(active.iter().map(|&i| slope * walk.outputs[i - 1]));
                if let Some(map) = &fitted.map {
                    row.extend(map.by_slope(w));
                }
                let first = row.len();
                self.parameters.gradient(fitted, walk, row);
                row[first..].iter_mut().for_each(|d| *d *= slope);
                row.push(value - y);
            });
        let last = linear + count;
        self.jacobian = triangle
            .view((linear, linear), (count + 1, count))
            .into_owned();
        self.residuals = triangle
            .view((linear, last), (count + 1, 1))
            .column(0)
            .into_owned();
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, values: &DVector<f64>) {
        self.parameters.values.copy_from(values);
        self.parameters.limit(self.fit.runs);
        self.evaluate();
    }

    fn params(&self) -> DVector<f64> {
        self.parameters.values.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        self.residuals
            .iter()
            .all(|r| r.is_finite())
            .then(|| self.residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        self.jacobian
            .iter()
            .all(|d| d.is_finite())
            .then(|| self.jacobian.clone())
    }
}
