//! The search for the structure: how many plays, which of the optional terms.

use std::ops::Range;

use rayon::prelude::*;

use crate::dataset::{Dataset, Role};
use crate::error::Error;
use crate::metrics::hysteresis_percent;
use crate::model_file::ModelFile;

use super::catalogue::Effect;
use super::cycles::{range, turning_points};
use super::fit::{Fit, Fitted, Thresholds};
use super::joint::{JointFit, Terms};
use super::map::Map;
use super::noise;
use super::outcome::{Findings, Identification, model_file};
use super::plays::Plays;
use super::run::Runs;
use super::score::{choose_starts, predict, score};

/// Numbers of plays that are tried.
const PLAYS: [usize; 13] = [1, 2, 3, 4, 5, 6, 8, 10, 12, 14, 16, 20, 24];
/// Plays that effects are fitted beside: enough that what is left over is not the hysteresis.
const PLAYS_WITH_EFFECTS: usize = 12;
/// Starts of an effect that are followed to their end.
const FOLLOWED: usize = 2;
/// Rows used while searching, and for the final fit.
const ROWS: Range<usize> = 4_000..200_000;
/// By how much a richer structure must lower the score on the records for selection.
const WORTH_A_PLAY: f64 = 0.99;
const WORTH_A_TERM: f64 = 0.97;
/// Frequencies the records must span for beta to be told from a delay: a decade.
const DECADE: f64 = 10.0;

/// Up to so many plays their spacing is fitted, and freed if that helps; more of them lie close
/// enough together to take any shape by their weights alone.
const FEW: usize = 6;

/// How records of different rates are weighed against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum RecordWeights {
    /// Each record the same.
    #[default]
    Equal,
    /// In proportion to its hysteresis percent, A_p of (J 45).
    Hysteresis,
}

/// What may be fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Number of plays; `None` chooses.
    pub plays: Option<usize>,
    /// Parametrisation of the thresholds; `None` chooses between spaced and free ones.
    pub thresholds: Option<Thresholds>,
    /// Whether beta is fitted; `None` fits it where the records can show it.
    pub beta: Option<bool>,
    /// Whether the asymmetry map may be added.
    pub asymmetry: bool,
    /// Weights of the records.
    pub weights: RecordWeights,
    /// Effects to fit together with the hysteresis; then there is no search, and no map.
    pub effects: Vec<Effect>,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            plays: None,
            thresholds: None,
            beta: None,
            asymmetry: true,
            weights: RecordWeights::Equal,
            effects: Vec::new(),
        }
    }
}

/// Identifies the stage behind a data set. `progress` is told what is done now.
///
/// # Errors
/// Records from which nothing can be learned: a drive or displacement that does not move.
pub fn identify(
    dataset: &Dataset,
    options: &Options,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Identification, Error> {
    let mut runs = Runs::new(dataset)?;
    let emphasis = emphasis(dataset, options.weights)?;
    let noise = noise::floor(&runs.runs);
    let beta_visible = runs.frequency_span >= DECADE;
    let with_beta = options.beta.unwrap_or(beta_visible);

    if !options.effects.is_empty() {
        return with_effects(dataset, runs, options, with_beta, noise, progress);
    }
    progress("states at the start of the records");
    for plays in [4, 8] {
        let fit = Fit {
            runs: &runs,
            emphasis: &emphasis,
            most_rows: ROWS.start,
        };
        let fitted = spaced(&fit, plays, with_beta);
        choose_starts(&fitted, &mut runs);
    }

    let mut fitted = choose_plays(&runs, &emphasis, options, with_beta, progress);
    let fit = Fit {
        runs: &runs,
        emphasis: &emphasis,
        most_rows: ROWS.start,
    };
    let judge = |fitted: &Fitted| judge(fitted, &runs);
    let mut best = judge(&fitted);
    let few = fitted.plays.thresholds.len() <= FEW;
    let mut thresholds = if few {
        Thresholds::Spaced
    } else {
        Thresholds::Fixed
    };
    if options
        .thresholds
        .map_or(few, |wanted| wanted == Thresholds::Free)
    {
        progress("free thresholds");
        let free = fit.minimise(&fitted, Thresholds::Free, with_beta);
        let free_score = judge(&free);
        if options.thresholds.is_some() || free_score < WORTH_A_TERM * best {
            (fitted, best, thresholds) = (free, free_score, Thresholds::Free);
        }
    }
    let mut beta_fitted = with_beta;
    if with_beta && options.beta.is_none() {
        progress("rate term");
        let mut without = fitted.clone();
        without.plays.beta = 0.0;
        let without = fit.minimise(&without, thresholds, false);
        let without_score = judge(&without);
        if best > WORTH_A_PLAY * without_score {
            (fitted, best, beta_fitted) = (without, without_score, false);
        }
    }
    if options.asymmetry {
        progress("asymmetry");
        let symmetric = fitted.clone();
        for corners in 0..=4 {
            let Some(map) = straight_map(&symmetric, &runs, corners) else {
                continue;
            };
            let start = Fitted {
                map: Some(map),
                ..symmetric.clone()
            };
            let shaped = fit.weights(&fitted.plays, Some(&start), start.map.clone());
            let shaped_score = judge(&shaped);
            if shaped_score < WORTH_A_TERM * best {
                (fitted, best) = (shaped, shaped_score);
            }
        }
    }

    progress("final fit");
    choose_starts(&fitted, &mut runs);
    runs.give_back();
    let fit = Fit {
        runs: &runs,
        emphasis: &emphasis,
        most_rows: ROWS.end,
    };
    fitted = fit.minimise(&fitted, thresholds, beta_fitted).pruned();
    let findings = Findings {
        fitted,
        effects: Vec::new(),
        thresholds,
        beta_visible,
        beta_fitted,
        noise,
    };
    Identification::new(dataset, &runs, findings)
}

/// Fits the effects that were asked for together with the hysteresis.
fn with_effects(
    dataset: &Dataset,
    mut runs: Runs,
    options: &Options,
    with_beta: bool,
    noise: Option<(f64, noise::Source)>,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Identification, Error> {
    let beta_visible = runs.frequency_span >= DECADE;
    progress("hysteresis and effects together");
    runs.give_back();
    let fit = JointFit::new(&runs);
    let thresholds = fit.even_thresholds(options.plays.unwrap_or(PLAYS_WITH_EFFECTS));
    let mut effects = options.effects.clone();
    effects.sort();
    let mut joint = fit.weights(thresholds, Vec::new(), Terms::none())?;
    let with_rate = with_beta.then_some(Effect::RateDependence);
    // A mode is looked for where nothing else can take its place; then all is fitted together.
    for effect in effects.into_iter().rev().chain(with_rate) {
        progress(effect.name());
        let leads = fit.leads(&joint, &[effect])?;
        let starts = leads.first().map_or(&[][..], |lead| &lead.starts[..]);
        let starts = &starts[..starts.len().min(FOLLOWED)];
        joint = fit
            .add(&joint, effect, starts, starts.len())?
            .ok_or_else(|| {
                Error::request(format!(
                    "the effect {} cannot be fitted to these records",
                    effect.name()
                ))
            })?;
    }
    let fitted = joint.fitted();
    let gain = fitted.weights.iter().sum();
    let findings = Findings {
        effects: joint.terms.stages(fit.seen(), gain),
        fitted,
        thresholds: Thresholds::Fixed,
        beta_visible,
        beta_fitted: with_beta,
        noise,
    };
    Identification::new(dataset, &runs, findings)
}

/// What a structure is chosen by: its score on the records for selection. Where there are none and
/// none could be held back, that on the records for fitting; [`WORTH_A_PLAY`] and [`WORTH_A_TERM`]
/// then stand alone against overfitting.
fn judge(fitted: &Fitted, runs: &Runs) -> f64 {
    score(fitted, runs, Role::Select)
        .or_else(|| score(fitted, runs, Role::Fit))
        .unwrap_or(f64::INFINITY)
}

/// Fits a given structure without any search: so many plays on one spacing, symmetric; `emphasis`
/// holds A_p of (J 44) for each record of the data set. Returns the stage and the root of its
/// weighted mean square residual over the fit records, in micrometres.
///
/// # Errors
/// As [`identify`]; an emphasis for another number of records.
pub fn fit_spaced(
    dataset: &Dataset,
    plays: usize,
    with_beta: bool,
    emphasis: &[f64],
) -> Result<(ModelFile, f64), Error> {
    if emphasis.len() != dataset.records.len() {
        return Err(Error::request("the emphasis must have one entry a record"));
    }
    let runs = Runs::new(dataset)?;
    let fit = Fit {
        runs: &runs,
        emphasis,
        most_rows: ROWS.end,
    };
    let fitted = spaced(&fit, plays.max(1), with_beta);
    Ok((
        model_file(&dataset.name, &fitted, &[], fitted.gain(), runs.sign),
        fitted.rms,
    ))
}

/// The best model with the fewest plays on one spacing.
fn choose_plays(
    runs: &Runs,
    emphasis: &[f64],
    options: &Options,
    with_beta: bool,
    progress: &(dyn Fn(&str) + Sync),
) -> Fitted {
    let fit = Fit {
        runs,
        emphasis,
        most_rows: ROWS.start,
    };
    let numbers = match &options.plays {
        Some(plays) => std::slice::from_ref(plays),
        None => &PLAYS[..],
    };
    let candidates: Vec<(f64, Fitted)> = numbers
        .par_iter()
        .map(|&plays| {
            let fitted = spaced(&fit, plays, with_beta);
            progress(&format!("{plays} plays"));
            (judge(&fitted, runs), fitted)
        })
        .collect();
    let lowest = candidates
        .iter()
        .map(|(score, _)| *score)
        .fold(f64::INFINITY, f64::min);
    // Data without noise can be met to rounding; there is nothing to gain below a millionth.
    let enough = 1e-6 * runs.mean_gain() * runs.drive_range;
    candidates
        .into_iter()
        .find(|(score, _)| WORTH_A_PLAY * score <= lowest || *score <= enough)
        .map_or_else(|| spaced(&fit, 1, with_beta), |(_, fitted)| fitted)
}

/// A fit of so many plays on one spacing, started from an even spread over the drive's range.
fn spaced(fit: &Fit<'_>, plays: usize, with_beta: bool) -> Fitted {
    let widest = fit.runs.widest_threshold();
    let thresholds = (1..=plays)
        .map(|i| widest * i as f64 / plays as f64)
        .collect();
    let beta = if with_beta {
        0.1 * widest / fit.runs.highest_rate()
    } else {
        0.0
    };
    let start = fit.weights(&Plays { thresholds, beta }, None, None);
    let thresholds = if plays <= FEW {
        Thresholds::Spaced
    } else {
        Thresholds::Fixed
    };
    fit.minimise(&start, thresholds, with_beta)
}

/// A straight map over the range that the fitted hysteresis reaches; `None` if it has no free slope.
fn straight_map(fitted: &Fitted, runs: &Runs, corners: usize) -> Option<Map> {
    let bare = Fitted {
        map: None,
        ..fitted.clone()
    };
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for (_, run, span) in runs.scored(Role::Fit) {
        for w in &predict(&bare, run)[span.samples.clone()] {
            (low, high) = (low.min(*w), high.max(*w));
        }
    }
    let map = Map::straight(low, high, corners);
    (map.free_slopes() > 0).then_some(map)
}

/// Emphasis of each record: equal, or A_p, its hysteresis percent over that of the first (J 45).
fn emphasis(dataset: &Dataset, weights: RecordWeights) -> Result<Vec<f64>, Error> {
    if weights == RecordWeights::Equal {
        return Ok(vec![1.0; dataset.records.len()]);
    }
    let percents: Vec<f64> = dataset
        .records
        .iter()
        .map(|record| {
            if record.role != Role::Fit {
                return Ok(1.0);
            }
            let turns = turning_points(&record.drive_v, range(&record.drive_v));
            let cycle = match turns[..] {
                [.., from, _, to] => from..to,
                _ => 0..record.drive_v.len(),
            };
            hysteresis_percent(&record.drive_v[cycle.clone()], &record.displacement_um[cycle])
                .map_err(|reason| {
                    Error::request(format!(
                        "record {}: its hysteresis percent cannot be taken ({reason}); use --record-weights equal",
                        record.name
                    ))
                })
        })
        .collect::<Result<_, _>>()?;
    let first = dataset
        .records
        .iter()
        .zip(&percents)
        .find(|(record, _)| record.role == Role::Fit)
        .map_or(1.0, |(_, percent)| *percent);
    Ok(percents.iter().map(|percent| percent / first).collect())
}
