//! The loop: baseline, search, verdict.

use crate::dataset::{Dataset, Role};
use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::noise;
use crate::identify::run::Runs;
use crate::identify::{Source, joint_model};

use super::baseline::{Baseline, Histories, saturate};
use super::bootstrap;
use super::diagnosis::{
    Diagnosis, FoundEffect, RecordResiduals, Residuals, Roles, Verdict, excess,
};
use super::naming::{BAR, EXPLAINED, Path, Search, WORTH};
use super::own_model;
use super::search::{Candidate, Ground, rms};

/// Least share of the excess on the report records that the effects must close.
const CONFIRMED: f64 = 0.1;

/// Most of what the baseline leaves over that elements beside the plays may leave to be searched beside.
const OTHER_FAMILY: f64 = 0.85;

/// Most of what the baseline leaves over of the fit records that an effect may leave to be tried
/// together with such elements.
const HINT: f64 = 0.9;

/// What a diagnosis may do.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// What the data are held against.
    pub baseline: Baseline,
    /// Effects of the library that may be named.
    pub library: Vec<Effect>,
    /// Sets of records without effect that are drawn to find the bar for a name; none: half the noise.
    pub bootstrap: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            baseline: Baseline::default(),
            library: Effect::ALL.to_vec(),
            bootstrap: 0,
        }
    }
}

/// Finds what the baseline misses of a data set. `progress` is told what is done now.
///
/// # Errors
/// Records from which nothing can be learned.
pub fn diagnose(
    dataset: &Dataset,
    options: &Options,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Diagnosis, Error> {
    let runs = Runs::new(dataset)?;
    let noise = noise::floor(&runs.runs).unwrap_or((0.0, Source::HighPass));
    progress("saturating the baseline");
    let grounds = grounds(&runs, &options.baseline)?;
    let mut best: Option<Search> = None;
    for (ground, base) in grounds {
        let bar = match options.bootstrap {
            draws if draws > 0 && noise.0 > 0.0 => {
                let library = &options.library;
                bootstrap::bar(&ground, &base, noise.0, library, draws, progress)? / noise.0
            }
            _ => BAR,
        };
        let library = &options.library;
        let mut search = Search::run(ground, base, None, (noise, bar), library, progress)?;
        if !search.explains_all()
            && let Some(other) = another_family(&search, (noise, bar), library, progress)?
        {
            search = other;
        }
        let settled = search.explains_all();
        if best.as_ref().is_none_or(|best| search.better_than(best)) {
            best = Some(search);
        }
        if settled {
            break;
        }
    }
    let search = best.ok_or_else(|| Error::request("there is nothing to diagnose".to_owned()))?;
    progress("opening the report records");
    let ground = search.ground.clone();
    let mut found = search.conclude(dataset)?;
    if let Baseline::Model(model) = &options.baseline {
        own_model::report(model, &ground, dataset, &mut found)?;
    }
    Ok(found)
}

/// What the saturated baseline leaves over of every record.
///
/// # Errors
/// Records from which nothing can be learned.
pub fn baseline_alone(dataset: &Dataset, baseline: &Baseline) -> Result<Residuals, Error> {
    let grounds = grounds(&Runs::new(dataset)?, baseline)?;
    let best = grounds
        .iter()
        .min_by(|(_, a), (_, b)| a.select.total_cmp(&b.select));
    let (ground, base) =
        best.ok_or_else(|| Error::request("there is nothing to diagnose".to_owned()))?;
    residuals(dataset, ground, base)
}

/// What is found beside elements of Bouc and Wen, or on from what was found without them, where these
/// explain much of what is left over; the search that explains most, if it is one of these.
fn another_family(
    search: &Search,
    noise_and_bar: ((f64, Source), f64),
    library: &[Effect],
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Option<Search>, Error> {
    progress("trying a hysteresis of another family");
    let rms = |candidate: &Candidate| candidate.select.hypot(candidate.joint.rms);
    let bare = Path {
        ground: search.ground.clone(),
        found: search.base.clone(),
        steps: Vec::new(),
    };
    // Steps of the reading come last, once all else is known.
    let steps = &search.best.steps;
    let read = steps.iter().any(|step| step.effect == Effect::Quantisation);
    let with_effects = if steps.is_empty() {
        // An effect may show only beside the right loops.
        let base = search.base.joint.rms;
        let explains = |hint: &&Path| hint.found.joint.rms < HINT * base;
        search.hint.as_ref().filter(explains).cloned()
    } else {
        (!read).then(|| search.best.clone())
    };
    let mut best: Option<Search> = None;
    for mut start in [Some(bare), with_effects].into_iter().flatten() {
        let richer = start.ground.with_elements(&start.found)?;
        if rms(&richer) > OTHER_FAMILY * rms(&start.found) {
            continue;
        }
        start.found = richer;
        let (ground, base) = (search.ground.clone(), search.base.clone());
        let mut other = Search::run(ground, base, Some(start), noise_and_bar, library, progress)?;
        // The page shows what each effect does to the baseline itself.
        other.screened.clone_from(&search.screened);
        if other.better_than(best.as_ref().unwrap_or(search)) {
            best = Some(other);
        }
        if best.as_ref().is_some_and(Search::explains_all) {
            break;
        }
    }
    Ok(best)
}

/// The saturated baseline on each of the two kinds of histories, where both are likely.
fn grounds(runs: &Runs, baseline: &Baseline) -> Result<Vec<(Ground, Candidate)>, Error> {
    let mut grounds = Vec::new();
    for histories in [Histories::Session, Histories::Each] {
        let mut runs = runs.clone();
        let joint = saturate(&mut runs, baseline, histories)?;
        let ground = Ground { runs, histories };
        let fit = ground.fit();
        let mut base = Candidate::new(&fit, joint, Vec::new())?;
        base.sharpen(&fit)?;
        drop(fit);
        grounds.push((ground, base));
    }
    let rms = |(_, base): &(Ground, Candidate)| base.select.hypot(base.joint.rms);
    if let [session, each] = &grounds[..] {
        if rms(session) < 1.1 * rms(each) {
            grounds.truncate(1);
        } else if rms(session) > 20.0 * rms(each) {
            grounds.remove(0);
        }
    }
    Ok(grounds)
}

impl Search {
    /// What the figures rest on.
    fn notes(&self, confirmed: bool, named: bool) -> Vec<String> {
        let histories = match self.ground.histories {
            Histories::Session => {
                "The plays at the start of a record are taken to stand where the record before it in \
                 time left them: as one session the records are explained best."
            }
            Histories::Each => {
                "The plays at the start of a record are taken from a short menu of histories, the one \
                 that explains the record best; records that move over less than 70 % of the drive's \
                 range have an offset of their own, for wide plays do not move along them."
            }
        };
        let mut notes = vec![
            histories.to_owned(),
            "The first cycle of a record of four or more turning points is left out of every figure."
                .to_owned(),
            "Records at rest have an offset of their own.".to_owned(),
            format!(
                "An effect is added where it lowers the mean square on the select records by more than the \
                 square of {:.2} times the noise and by {:.0} % of the squared excess.",
                self.bar,
                100.0 * WORTH
            ),
        ];
        if self
            .best
            .steps
            .iter()
            .any(|s| s.effect == Effect::Quantisation)
        {
            notes.push(
                "The readings are whole steps apart. With quantisation in the model, a residual is what \
                 the prediction lies outside of the step that was read."
                    .to_owned(),
            );
        }
        if !self.best.found.joint.core.elements.is_empty() {
            let model = if named {
                "in the model, too"
            } else {
                "not in the model, which is the baseline"
            };
            let alone = if self.core.joint.core.elements.is_empty() {
                String::new()
            } else {
                let left = 100.0 * self.core.select / self.base.select.max(f64::MIN_POSITIVE);
                format!(" leave {left:.0} % of what plays leave on the select records, and")
            };
            notes.push(format!(
                "The loops are no sum of plays: elements of Bouc and Wen beside them{alone} are {model}. \
                 Effects were searched for beside both."
            ));
        }
        if !confirmed {
            let found: Vec<&str> = self.best.steps.iter().map(|s| s.effect.name()).collect();
            notes.push(format!(
                "The select records spoke for {}, the report records do not: less than {:.0} % of the gap \
                 closes there, or there is none and harm is done. Nothing is named.",
                found.join(" and "),
                100.0 * CONFIRMED
            ));
        }
        notes
    }

    /// Whether the report records, opened for this once, bear the names out: records that nothing was
    /// chosen by.
    fn is_confirmed(&self) -> Result<bool, Error> {
        let noise = self.noise.0;
        let left = |ground: &Ground, candidate: &Candidate| {
            Ok::<_, Error>(rms(ground, candidate, Role::Report)?.map(|rms| excess(rms, noise)))
        };
        let before = left(&self.ground, &self.core)?;
        let after = left(&self.best.ground, &self.best.found)?;
        let seen = self.bar * noise;
        Ok(match (before, after) {
            (Some(before), Some(after)) if before > seen => after <= (1.0 - CONFIRMED) * before,
            // What these records do not show must not do harm there.
            (Some(_), Some(after)) => after <= seen.max(EXPLAINED * noise),
            _ => true,
        } || self.best.steps.is_empty())
    }

    fn conclude(self, dataset: &Dataset) -> Result<Diagnosis, Error> {
        let confirmed = self.is_confirmed()?;
        let verdict = if confirmed {
            self.verdict()
        } else {
            self.unnamed()
        };
        let bare = verdict == Verdict::Unknown || !confirmed;
        let (ground, found) = if bare {
            (&self.ground, &self.base)
        } else {
            (&self.best.ground, &self.best.found)
        };
        let fit = ground.fit();
        let seen = *fit.seen();
        let gain: f64 = found.joint.core.weights.iter().sum();
        let steps = if bare { &[] } else { &self.best.steps[..] };
        let intervals = match steps {
            [] => Vec::new(),
            _ => fit.intervals(&found.joint)?,
        };
        let model = |ground: &Ground, candidate: &Candidate| {
            let fit = ground.fit();
            joint_model(&dataset.name, &candidate.joint, &fit)
        };
        let mut counted: Vec<Effect> = Vec::new();
        let effects = steps
            .iter()
            .map(|step| {
                // Modes come more than once, in the order of the terms, the baseline's own first.
                let own = self.base.joint.terms.iter();
                let own = own.filter(|t| t.effect == step.effect).count();
                let earlier = own + counted.iter().filter(|e| **e == step.effect).count();
                counted.push(step.effect);
                let term = found
                    .joint
                    .terms
                    .iter()
                    .enumerate()
                    .filter(|(_, t)| t.effect == step.effect)
                    .nth(earlier);
                let rivals = step.rivals.iter().map(|rival| model(&step.ground, rival));
                Ok(FoundEffect {
                    effect: step.effect,
                    also_possible: step.rivals.iter().filter_map(Candidate::newest).collect(),
                    rivals: rivals.collect::<Result<_, Error>>()?,
                    left_over: step.left_over,
                    stage: term
                        .and_then(|(_, t)| t.effect.template().stage(&t.numbers, &seen, gain))
                        .map(|stage| stage.signed(ground.runs.sign)),
                    intervals: term
                        .and_then(|(index, _)| intervals.get(index).cloned())
                        .unwrap_or_default(),
                    numbers: match step.effect {
                        Effect::RateDependence => vec![("beta_s", found.joint.core.beta)],
                        _ => Vec::new(),
                    },
                })
            })
            .collect::<Result<_, Error>>()?;
        Ok(Diagnosis {
            name: dataset.name.clone(),
            unit: dataset.output_unit,
            verdict,
            effects,
            noise: self.noise,
            baseline: roles(&self.ground, &self.base)?,
            refitted: None,
            extended: roles(ground, found)?,
            bar_um: self.bar * self.noise.0,
            screened: self.screened.clone(),
            ablation: if steps.is_empty() {
                Vec::new()
            } else {
                self.ablation.clone()
            },
            baseline_model: model(&self.ground, &self.base)?,
            model: model(ground, found)?,
            before: residuals(dataset, &self.ground, &self.base)?,
            after: residuals(dataset, ground, found)?,
            next_record: None,
            whole: None,
            notes: self.notes(confirmed, !bare),
        })
    }
}

/// Rms of a model by role.
pub(super) fn roles(ground: &Ground, candidate: &Candidate) -> Result<Roles, Error> {
    Ok(Roles {
        fit: rms(ground, candidate, Role::Fit)?,
        select: rms(ground, candidate, Role::Select)?,
        report: rms(ground, candidate, Role::Report)?,
    })
}

/// What a model leaves over of every record's scored samples.
pub(super) fn residuals(
    dataset: &Dataset,
    ground: &Ground,
    candidate: &Candidate,
) -> Result<Residuals, Error> {
    let fit = ground.fit();
    let runs = &ground.runs;
    let predicted = fit.predicted(&candidate.joint.core, &candidate.joint.terms)?;
    let offsets = crate::identify::score::offsets(runs, &predicted);
    let mut records: Vec<(usize, RecordResiduals)> = Vec::new();
    for (i, run) in runs.runs.iter().enumerate() {
        for (_, span) in run.whole_spans() {
            let record = &dataset.records[span.record];
            let samples = span.samples.clone();
            let sign = runs.sign;
            records.push((
                span.record,
                RecordResiduals {
                    name: record.name.clone(),
                    role: record.role,
                    sample_time_s: run.sample_time_s,
                    start_s: run.start_s + samples.start as f64 * run.sample_time_s,
                    drive_v: run.drive[samples.clone()].to_vec(),
                    displacement_um: samples
                        .clone()
                        .map(|k| sign * run.displacement[k])
                        .collect(),
                    residual_um: samples
                        .map(|k| sign * (run.displacement[k] - predicted[i][k] - offsets[i]))
                        .collect(),
                },
            ));
        }
    }
    records.sort_by_key(|(index, _)| *index);
    Ok(Residuals {
        records: records.into_iter().map(|(_, record)| record).collect(),
    })
}
