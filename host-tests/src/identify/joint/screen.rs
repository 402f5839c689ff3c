//! Which effects are worth a fit of their own, and from where: each start of each one is simulated
//! once, and what it changes is held, scaled, against what the model leaves over.
//!
//! Only what the weights and numbers that the model has already cannot follow counts.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rayon::prelude::*;

use crate::error::Error;

use super::super::catalogue::{self, Effect};
use super::pull::Pull;
use super::responses::Responses;
use super::{Joint, JointFit, LEAST_DIRECT};

/// Share of its own square that a change must keep beside the model's own; less is the model's.
const NEW: f64 = 1e-6;

/// An effect as it looks before any fit.
#[derive(Clone, Debug)]
pub struct Lead {
    /// The effect.
    pub effect: Effect,
    /// Its starts, the most promising first.
    pub starts: Vec<Vec<f64>>,
    /// Rms that the best of them promises, in um.
    pub rms: f64,
}

/// What a model leaves over, and how it could move itself.
struct Tangent {
    /// Columns over all rows: by weights and numbers.
    columns: DMatrix<f64>,
    inverse: Cholesky<f64, Dyn>,
    pulls: Vec<Vec<Pull>>,
    /// What is left over beside them.
    left: DVector<f64>,
}

/// What a start changes at the rows.
enum Changes {
    /// All of it at once.
    Whole(DVector<f64>),
    /// Nothing yet: what each of its numbers would.
    ByNumber(Vec<DVector<f64>>),
    /// Nothing that a fit could move.
    Unseen,
}

impl JointFit<'_> {
    /// Leads for `effects` beside a fitted model, the most promising first; those of which no start can be
    /// computed are left out.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn leads(&self, base: &Joint, effects: &[Effect]) -> Result<Vec<Lead>, Error> {
        let mut base = base.clone();
        base.core = base.core.active();
        let at = self.responses(&base)?;
        let Some(tangent) = self.tangent(&base, &at) else {
            return Ok(Vec::new());
        };
        let mut leads: Vec<Lead> = effects
            .par_iter()
            .filter_map(|&effect| self.lead(&base, &at, &tangent, effect).transpose())
            .collect::<Result<_, Error>>()?;
        if base.terms.half_step(&self.seen).is_some() {
            // The rows count what they ask for; the rest of the search, what lies outside of the steps.
            let unit = base.rms / tangent.left.norm().max(f64::MIN_POSITIVE);
            leads.iter_mut().for_each(|lead| lead.rms *= unit);
        }
        leads.sort_by(|a, b| a.rms.total_cmp(&b.rms));
        Ok(leads)
    }

    fn lead(
        &self,
        base: &Joint,
        at: &Responses,
        tangent: &Tangent,
        effect: Effect,
    ) -> Result<Option<Lead>, Error> {
        let starts = match effect {
            Effect::MainsHum => catalogue::hum_starts(&self.seen, &self.left_over(base)?),
            _ => effect.template().starts(&self.seen),
        };
        let mut judged: Vec<(f64, Vec<f64>)> = starts
            .into_iter()
            .filter_map(|numbers| {
                // Numbers that the core refuses are no start.
                let changes = self
                    .changes(base, at, &tangent.pulls, effect, &numbers)
                    .ok()?;
                Some((tangent.left_beside(&changes), numbers))
            })
            .collect();
        judged.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(judged.first().map(|(rms, _)| *rms).map(|rms| Lead {
            effect,
            starts: judged.into_iter().map(|(_, numbers)| numbers).collect(),
            rms,
        }))
    }

    fn changes(
        &self,
        base: &Joint,
        at: &Responses,
        pulls: &[Vec<Pull>],
        effect: Effect,
        numbers: &[f64],
    ) -> Result<Changes, Error> {
        let terms = base.terms.with(effect, numbers.to_vec());
        let new = base.terms.iter().filter(|t| t.effect <= effect).count();
        let behind = terms.is_behind((new, 0)).then_some(&at.w[..]);
        let whole = self.differences(&base.core, &terms, behind, &at.y, 1.0)?;
        let whole = self.at_rows(pulls, &whole);
        if whole.norm_squared() > 0.0 {
            return Ok(Changes::Whole(whole));
        }
        let free = terms.free(&self.seen).into_iter();
        let by_number: Vec<DVector<f64>> = free
            .filter(|place| place.0 == new)
            .map(|place| {
                let slope = self.slope(&base.core, &terms, place, behind, &at.y)?;
                Ok(self.at_rows(pulls, &slope))
            })
            .collect::<Result<_, Error>>()?;
        Ok(if by_number.is_empty() {
            Changes::Unseen
        } else {
            Changes::ByNumber(by_number)
        })
    }

    /// A signal of the runs at the rows, weighted, less its mean over each run that has its own offset.
    pub(super) fn at_rows(&self, pulls: &[Vec<Pull>], runs: &[Vec<f64>]) -> DVector<f64> {
        let values: Vec<Vec<f64>> = self
            .fitted_frames()
            .iter()
            .zip(runs)
            .map(|(frame, signal)| frame.rows.iter().map(|&(k, _)| signal[k]).collect())
            .collect();
        self.weighted(pulls, &values)
    }

    /// What the rows ask for, in the same way.
    pub(super) fn asked(&self, pulls: &[Vec<Pull>]) -> DVector<f64> {
        let by = |pulls: &Vec<Pull>| pulls.iter().map(|pull| pull.by).collect();
        let values: Vec<Vec<f64>> = pulls.iter().map(by).collect();
        self.weighted(pulls, &values)
    }

    fn weighted(&self, pulls: &[Vec<Pull>], values: &[Vec<f64>]) -> DVector<f64> {
        let mut rows = Vec::new();
        for ((frame, pulls), values) in self.fitted_frames().iter().zip(pulls).zip(values) {
            let pairs = || pulls.iter().map(|pull| pull.weight).zip(values);
            let (sum, total) =
                pairs().fold((0.0, 0.0), |(s, t), (w, x)| (s + w * w * x, t + w * w));
            let own = self.own_offset(frame) && total > 0.0;
            let mean = if own { sum / total } else { 0.0 };
            rows.extend(pairs().map(|(w, x)| w * (x - mean)));
        }
        DVector::from_vec(rows)
    }

    fn tangent(&self, base: &Joint, at: &Responses) -> Option<Tangent> {
        let frames = self.fitted_frames();
        let mut signals = self.by_numbers(base, at);
        // A weight that its bound holds cannot follow.
        let floor = LEAST_DIRECT * self.runs.mean_gain();
        let held = base
            .core
            .weights
            .first()
            .is_some_and(|a| *a <= 1.001 * floor);
        let weights = usize::from(held)..base.core.weights.len();
        signals.extend(weights.map(|j| at.by_weight(frames, j)));
        let ones = frames.iter().map(|frame| vec![1.0; frame.run.drive.len()]);
        signals.push(ones.collect());
        let pulls = self.pulls(base, at);
        let columns: Vec<DVector<f64>> = signals.iter().map(|s| self.at_rows(&pulls, s)).collect();
        let columns = DMatrix::from_columns(&columns);
        let asked = self.asked(&pulls);
        let mut square = columns.tr_mul(&columns);
        for i in 0..square.nrows() {
            square[(i, i)] = square[(i, i)] * (1.0 + 1e-9) + f64::MIN_POSITIVE;
        }
        square.cholesky().map(|inverse| {
            let own = inverse.solve(&columns.tr_mul(&asked));
            Tangent {
                left: asked - &columns * own,
                columns,
                inverse,
                pulls,
            }
        })
    }
}

impl Tangent {
    /// Rms that is left over with a start beside the model's own.
    fn left_beside(&self, changes: &Changes) -> f64 {
        let others = match changes {
            Changes::Whole(whole) => DMatrix::from_columns(std::slice::from_ref(whole)),
            Changes::ByNumber(columns) => DMatrix::from_columns(columns),
            Changes::Unseen => return self.left.norm(),
        };
        let shared = self.columns.tr_mul(&others);
        let mut square = others.tr_mul(&others);
        let own: Vec<f64> = square.diagonal().iter().copied().collect();
        square -= shared.tr_mul(&self.inverse.solve(&shared));
        for (i, own) in own.iter().enumerate() {
            square[(i, i)] = square[(i, i)].max(0.0) + NEW * own + f64::MIN_POSITIVE;
        }
        let along = others.tr_mul(&self.left);
        // A start the other way round is not the effect.
        let against = matches!(changes, Changes::Whole(_)) && along[0] <= 0.0;
        let gain = match square.cholesky() {
            Some(square) if !against => along.dot(&square.solve(&along)),
            _ => 0.0,
        };
        (self.left.norm_squared() - gain).max(0.0).sqrt()
    }
}
