//! The baseline: a hysteresis with as many plays as still help on records that it was not fitted to.
//!
//! What an unsaturated core leaves over looks like effects that are not there.

use rayon::prelude::*;

use crate::dataset::Role;
use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::joint::{Joint, JointFit, SETTLED, Terms};
use crate::identify::run::{Run, Runs};
use crate::identify::score;
use crate::identify::start::Start;
use crate::model_file::ModelFile;

use super::own_model;
use super::search::PLAYS;

/// Which hysteresis the data are held against.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Baseline {
    /// Plays with a rate term, where the records can show one.
    #[default]
    RateDependent,
    /// Plays alone.
    RateIndependent,
    /// A model of the user's own.
    Model(Box<ModelFile>),
}

/// Plays that are enough to see how a stage moves.
const FEW: usize = 6;
/// How much closer thresholds lie to each other near zero: the power of an even spread.
const CROWDING: f64 = 1.3;

/// Most of what is left over that plays wider than every loop may leave to be kept.
const WIDE: f64 = 0.9;
/// Their thresholds, over the widest that shows in every loop.
const BEYOND: [f64; 7] = [1.06, 1.12, 1.25, 1.4, 1.6, 1.85, 2.1];

/// Share of the drive's range below which a record rests.
const RESTING: f64 = 0.02;
/// The same below which wide plays stand still along a record, where nobody knows.
const NARROW: f64 = 0.7;

/// How the records began.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Histories {
    /// Every record goes on from where the one before it in time ended.
    Session,
    /// Each from whichever history on the menu explains it best.
    Each,
}

/// Saturates the core and chooses the state that each run starts in.
///
/// # Errors
/// Numbers that the core refuses; a model that cannot be fitted.
pub fn saturate(
    runs: &mut Runs,
    baseline: &Baseline,
    histories: Histories,
) -> Result<Joint, Error> {
    if let Baseline::Model(model) = baseline {
        return own_model::fitted_anew(model, runs, histories);
    }
    let terms = terms(runs, baseline);
    for plays in [FEW, 2 * FEW] {
        let joint = {
            let fit = JointFit::new(runs);
            fitted(&fit, crowded(&fit, plays), terms.clone())?
        };
        choose_starts(runs, &joint, histories)?;
    }
    let mut best = {
        let fit = JointFit::new(runs);
        fitted(&fit, crowded(&fit, PLAYS), terms)?
    };
    choose_starts(runs, &best, histories)?;
    let fit = JointFit::new(runs);
    best.rms = fit.rms(&best.core, &best.terms, Role::Fit)?;
    fit.settle(&mut best, SETTLED.0)?;
    with_wide_plays(&fit, best)
}

fn terms(runs: &Runs, baseline: &Baseline) -> Terms {
    let seen = crate::identify::catalogue::Seen::new(runs);
    let rate = Effect::RateDependence.template();
    match baseline {
        Baseline::RateDependent if rate.hidden(&seen).is_none() => {
            let start = rate.starts(&seen).into_iter().next().unwrap_or_default();
            Terms::none().with(Effect::RateDependence, start)
        }
        _ => Terms::none(),
    }
}

fn fitted(fit: &JointFit<'_>, thresholds: Vec<f64>, terms: Terms) -> Result<Joint, Error> {
    let mut joint = fit.weights(thresholds, Vec::new(), terms)?;
    fit.settle(&mut joint, SETTLED.1)?;
    Ok(joint)
}

/// Thresholds that lie closer together near zero.
pub fn crowded(fit: &JointFit<'_>, plays: usize) -> Vec<f64> {
    let widest = fit.seen().threshold_v;
    (1..=plays)
        .map(|i| widest * (i as f64 / plays as f64).powf(CROWDING))
        .collect()
}

/// The model with plays that move only while the first records lead them away from zero, where these are
/// known and it leaves that much less.
pub fn with_wide_plays(fit: &JointFit<'_>, joint: Joint) -> Result<Joint, Error> {
    let beyond = BEYOND.map(|share| share * fit.seen().threshold_v);
    let beyond: Vec<f64> = beyond.into_iter().filter(|&r| r < fit.widest()).collect();
    if beyond.is_empty() {
        return Ok(joint);
    }
    let mut thresholds = joint.core.thresholds.clone();
    thresholds.retain(|&r| r <= fit.seen().threshold_v);
    thresholds.extend(beyond);
    let elements = joint.core.elements.clone();
    let mut wide = fit.weights(thresholds, elements, joint.terms.clone())?;
    fit.settle(&mut wide, SETTLED.1)?;
    let (before, after) = (judged(fit, &joint)?, judged(fit, &wide)?);
    Ok(
        if after.max(wide.rms / joint.rms * before) < WIDE * before {
            wide
        } else {
            joint
        },
    )
}

/// What a structure is chosen by: the rms on the select records, or where there are none and none
/// could be held back, that of the fit.
pub fn judged(fit: &JointFit<'_>, joint: &Joint) -> Result<f64, Error> {
    let select = fit.rms(&joint.core, &joint.terms, Role::Select)?;
    Ok(if select.is_finite() {
        select
    } else {
        joint.rms
    })
}

/// Gives every run its history: that of a session, or the one from the menu under which the model
/// explains it best.
///
/// # Errors
/// Numbers that the core refuses.
pub fn choose_starts(runs: &mut Runs, joint: &Joint, histories: Histories) -> Result<(), Error> {
    let range = runs.drive_range;
    let known = match histories {
        Histories::Session => RESTING,
        Histories::Each => NARROW,
    };
    for run in &mut runs.runs {
        run.loose = run.is_narrow(known * range);
    }
    if histories == Histories::Session {
        runs.runs
            .iter_mut()
            .for_each(|run| run.start = Start::Carried);
        if let Some(first) = runs.runs.first_mut() {
            first.start = Start::Zero;
        }
        return Ok(());
    }
    let mut menu = vec![Start::Carried];
    menu.extend(Start::menu(runs.drive_range));
    let predicted = JointFit::new(runs).predicted(&joint.core, &joint.terms)?;
    let shared = score::offsets(runs, &predicted);
    let tried: Vec<(Start, Vec<Vec<f64>>)> = menu
        .par_iter()
        .map(|&start| {
            let mut other = runs.clone();
            other.runs.iter_mut().for_each(|run| run.start = start);
            let fit = JointFit::new(&other);
            Ok((start, fit.predicted(&joint.core, &joint.terms)?))
        })
        .collect::<Result<_, Error>>()?;
    let own = runs.own_offsets;
    for (i, run) in runs.runs.iter_mut().enumerate() {
        let shared = (!own && !run.loose).then_some(shared[i]);
        let square = |predicted: &[f64]| mean_square(run, predicted, shared);
        let mut best = (square(&predicted[i]) * (1.0 - 1e-9), run.start);
        for (start, predicted) in &tried {
            let square = square(&predicted[i]);
            // An equal history further down the menu is not a better one.
            if square < best.0 {
                best = (square * (1.0 - 1e-9), *start);
            }
        }
        run.start = best.1;
    }
    Ok(())
}

/// Mean square of measurement less prediction over the scored samples, about `offset` or their mean.
fn mean_square(run: &Run, predicted: &[f64], offset: Option<f64>) -> f64 {
    let residuals = || {
        let samples = run.spans.iter().flat_map(|span| span.samples.clone());
        samples.map(|k| run.displacement[k] - predicted[k])
    };
    let count = residuals().count().max(1) as f64;
    let about = offset.unwrap_or_else(|| residuals().sum::<f64>() / count);
    residuals().map(|e| (e - about).powi(2)).sum::<f64>() / count
}
