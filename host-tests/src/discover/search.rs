//! The search: which effects, one after the other or together, explain what the baseline leaves over.

use rayon::prelude::*;

use crate::dataset::Role;
use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::joint::{Element, Joint, JointFit, Lead, SETTLED, Terms};
use crate::identify::run::Runs;

use super::baseline::{Histories, choose_starts, crowded, judged};

/// Modes that a model may have.
const MODES: usize = 3;
/// The most promising effects, of which so many starts are tried with plays that make room for them.
const ROOMY: usize = 3;
const WEIGHED: usize = 9;
/// Plays beside which effects are looked at.
pub const PLAYS: usize = 28;
/// Share of a threshold that lies between it and the next.
const APART: f64 = 1e-3;
/// Effects that are fitted, and those that are fitted again to histories chosen by the best of them.
const CLOSER: (usize, usize) = (6, 4);
/// How often histories are chosen again at most.
const ROUNDS: usize = 2;

/// The best of those whose thresholds are sharpened, how often at most, and beside how many plays.
const SHARPENED: usize = 4;
/// How much more than the best a candidate may leave over for that.
const HOPELESS: f64 = 2.0;
const SHARPER: usize = 8;
/// Relative gain below which thresholds are sharp.
const SHARP: f64 = 0.005;
const MOST_PLAYS: usize = 64;

/// Share of what is left over that a number of an effect must take away to be worth it.
const PRICE: f64 = 0.006;

/// A model with what it leaves over.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// The model.
    pub joint: Joint,
    /// Effects in the order in which they were found.
    pub order: Vec<Effect>,
    /// Rms on the select records in um.
    pub select: f64,
}

impl Candidate {
    /// A fitted model as it is judged.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn new(fit: &JointFit<'_>, joint: Joint, order: Vec<Effect>) -> Result<Self, Error> {
        let select = judged(fit, &joint)?;
        Ok(Self {
            joint,
            order,
            select,
        })
    }

    /// Moves the thresholds closer to those of the stage.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn sharpen(&mut self, fit: &JointFit<'_>) -> Result<(), Error> {
        for _ in 0..SHARPER {
            let before = self.joint.rms;
            fit.sharpen(&mut self.joint, MOST_PLAYS)?;
            if self.joint.rms > (1.0 - SHARP) * before {
                break;
            }
        }
        self.select = judged(fit, &self.joint)?;
        Ok(())
    }

    /// What candidates are compared by: the rms on the select records, with that on the fit records
    /// where it is a draw, and a price on each number of the effects.
    pub fn judged(&self) -> f64 {
        let numbers: usize = self.joint.terms.iter().map(|t| t.numbers.len()).sum();
        self.select.hypot(0.5 * self.joint.rms) * (1.0 + PRICE * numbers as f64)
    }

    /// The effect that was added last.
    pub fn newest(&self) -> Option<Effect> {
        self.order.last().copied()
    }
}

/// The data of a search: runs with their histories.
#[derive(Clone)]
pub struct Ground {
    /// The runs.
    pub runs: Runs,
    /// How histories are chosen.
    pub histories: Histories,
}

impl Ground {
    /// Fits on this ground.
    pub fn fit(&self) -> JointFit<'_> {
        JointFit::new(&self.runs)
    }

    /// The same with the histories that a model explains best.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn seen_by(&self, joint: &Joint) -> Result<Self, Error> {
        let mut other = self.clone();
        choose_starts(&mut other.runs, joint, self.histories)?;
        Ok(other)
    }

    /// A model with its plays, and its elements if it has some, among many others, fitted anew.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn refit(&self, base: &Candidate) -> Result<Candidate, Error> {
        let elements = base.joint.core.active().elements;
        self.refit_among(base, elements)
    }

    /// The same with elements of Bouc and Wen beside the plays, sharpened.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn with_elements(&self, base: &Candidate) -> Result<Candidate, Error> {
        let mut elements = Element::menu(self.runs.drive_range);
        elements.extend(base.joint.core.active().elements);
        let mut found = self.refit_among(base, elements)?;
        let fit = self.fit();
        found.sharpen(&fit)?;
        fit.merge(&mut found.joint)?;
        found.sharpen(&fit)?;
        Ok(found)
    }

    fn refit_among(&self, base: &Candidate, elements: Vec<Element>) -> Result<Candidate, Error> {
        let fit = self.fit();
        let mut thresholds = crowded(&fit, PLAYS);
        thresholds.extend(base.joint.core.active().thresholds);
        thresholds.sort_by(f64::total_cmp);
        thresholds.dedup_by(|a, b| *a - *b < APART * *a);
        let mut joint = fit.weights(thresholds, elements, base.joint.terms.clone())?;
        fit.settle(&mut joint, SETTLED.1)?;
        Candidate::new(&fit, joint, base.order.clone())
    }
}

/// Effects that may be added to a model, of those allowed.
fn possible(fit: &JointFit<'_>, terms: &Terms, allowed: &[Effect]) -> Vec<Effect> {
    let count = |effect| terms.iter().filter(|term| term.effect == effect).count();
    allowed
        .iter()
        .copied()
        .filter(|&effect| {
            let template = effect.template();
            template.hidden(fit.seen()).is_none()
                && !template.starts(fit.seen()).is_empty()
                && match effect {
                    Effect::Resonance => count(effect) < MODES,
                    Effect::RateLaw => terms.has(Effect::RateDependence) && !terms.has(effect),
                    // Read off the readings: nothing is to be searched for.
                    Effect::Quantisation => false,
                    // Without a mode it is the same as the one before the modes.
                    Effect::OutputQuadratic => terms.has(Effect::Resonance) && !terms.has(effect),
                    _ => !terms.has(effect),
                }
        })
        .collect()
}

/// `base` with each of the effects that `leads` name, fitted anew, the best on the select records first.
///
/// # Errors
/// Numbers that the core refuses.
pub fn expand(
    fit: &JointFit<'_>,
    base: &Candidate,
    leads: &[Lead],
) -> Result<Vec<Candidate>, Error> {
    let mut found: Vec<Candidate> = leads
        .par_iter()
        .enumerate()
        .map(|(rank, lead)| {
            let weighed = if rank < ROOMY { WEIGHED } else { 0 };
            let Some(joint) = fit.add(&base.joint, lead.effect, &lead.starts, weighed)? else {
                return Ok(None);
            };
            let mut order = base.order.clone();
            order.push(lead.effect);
            Candidate::new(fit, joint, order).map(Some)
        })
        .filter_map(Result::transpose)
        .collect::<Result<_, Error>>()?;
    sort(&mut found);
    let near = found.first().map_or(0.0, |first| HOPELESS * first.select);
    found
        .par_iter_mut()
        .take(SHARPENED)
        .filter(|candidate| candidate.select <= near)
        .try_for_each(|candidate| candidate.sharpen(fit))?;
    sort(&mut found);
    Ok(found)
}

/// The best first.
fn sort(candidates: &mut [Candidate]) {
    candidates.sort_by(|a, b| a.judged().total_cmp(&b.judged()));
}

/// The most promising of the possible effects beside a model.
///
/// # Errors
/// Numbers that the core refuses.
pub fn most_promising(
    ground: &Ground,
    base: &Candidate,
    allowed: &[Effect],
) -> Result<Vec<Lead>, Error> {
    let fit = ground.fit();
    let effects = possible(&fit, &base.joint.terms, allowed);
    let mut leads = fit.leads(&base.joint, &effects)?;
    leads.truncate(CLOSER.0);
    Ok(leads)
}

/// One effect more: the most promising of the possible ones, fitted; where histories are chosen, once
/// more on those that the best makes likely. The best first.
///
/// # Errors
/// Numbers that the core refuses.
pub fn one_more(
    ground: &Ground,
    base: &Candidate,
    allowed: &[Effect],
    looked_at: &(dyn Fn(&str) + Sync),
) -> Result<(Ground, Vec<Candidate>), Error> {
    looked_at("screening effects");
    let mut ground = ground.clone();
    let mut rich = ground.refit(base)?;
    let mut leads = most_promising(&ground, &rich, allowed)?;
    looked_at("fitting the most promising effects");
    let mut found = expand(&ground.fit(), &rich, &leads)?;
    if ground.histories == Histories::Each {
        for _ in 0..ROUNDS {
            let Some(best) = found.first().cloned() else {
                break;
            };
            let other = ground.seen_by(&best.joint)?;
            if other.runs.starts().eq(ground.runs.starts()) {
                break;
            }
            looked_at("fitting again on likelier histories");
            ground = other;
            rich = ground.refit(base)?;
            let close: Vec<Effect> = found.iter().filter_map(Candidate::newest).collect();
            leads.retain(|lead| close.iter().take(CLOSER.1).any(|e| *e == lead.effect));
            found = expand(&ground.fit(), &rich, &leads)?;
            if found
                .first()
                .is_some_and(|first| first.joint.rms > 0.98 * best.joint.rms)
            {
                break;
            }
        }
    }
    Ok((ground, found))
}

/// Rms of a model on the records of a role, in um.
///
/// # Errors
/// Numbers that the core refuses.
pub fn rms(ground: &Ground, candidate: &Candidate, role: Role) -> Result<Option<f64>, Error> {
    let joint = &candidate.joint;
    let rms = ground.fit().rms(&joint.core, &joint.terms, role)?;
    Ok(rms.is_finite().then_some(rms))
}
