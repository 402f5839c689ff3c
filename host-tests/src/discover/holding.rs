//! Names held against others once the rest is known; two are changed at once where that explains more, or
//! hardly less with fewer.

use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::joint::{JointFit, SETTLED};

use super::diagnosis::{Ablation, excess};
use super::naming::{EXPLAINED, MOST, Search, Step, WORTH, ambiguous};
use super::search::{Candidate, expand, most_promising};

/// Effects that a name must hold against.
const AGAINST: usize = 4;
/// How often names may change places.
const SWAPS: usize = 3;
/// Share by which another name must be better.
const BETTER: f64 = 0.01;
/// How often two names may be changed at once.
const EXCHANGES: usize = 2;
/// Others in place of the first name of two that are tried, and of the second beside each.
const EXCHANGED: (usize, usize) = (3, 2);

/// What each name was held against: the rest of the model with others in its place, the best first.
type Held = Vec<Vec<Candidate>>;

impl Search {
    /// Holds the names, while there are `enough`, against the others one by one, then two at once. Whether
    /// any have changed.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub(super) fn hold_all(
        &mut self,
        library: &[Effect],
        enough: usize,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<bool, Error> {
        progress("holding each name against the others");
        let names = |search: &Self| -> Vec<Effect> {
            let mut names = search.best.found.order.clone();
            names.sort();
            names
        };
        let before = names(self);
        let mut held = self.hold(library, enough, false)?;
        for _ in 0..EXCHANGES {
            if self.best.names() < 2 {
                break;
            }
            progress("holding two names at once against the others");
            if !self.do_with_fewer()? && !self.exchange(&held, library)? {
                break;
            }
            held = self.hold(library, 1, true)?;
        }
        Ok(names(self) != before)
    }

    /// Holds every name against the others beside the rest of the model: the better one stays, those
    /// nearly as good are its ambiguity set, and one that is not missed goes; while there are `enough`.
    /// Names that have `changed` leave over what they do beside all others.
    fn hold(
        &mut self,
        library: &[Effect],
        enough: usize,
        mut changed: bool,
    ) -> Result<Held, Error> {
        let mut swaps = 0;
        let mut place = 0;
        let mut held = Held::new();
        self.ablation.clear();
        // Those that change must be held to the end.
        while place < self.best.steps.len() && (changed || self.best.names() >= enough) {
            let ground = self.best.ground.clone();
            let fit = ground.fit();
            let noise = self.heard(&self.best);
            let effect = self.best.steps[place].effect;
            let without = self.without(&fit, &self.best.found, place)?;
            if let Some(without) = &without {
                self.ablation.push(Ablation {
                    effect,
                    select_um: without.select,
                });
            }
            // Steps are read off the readings and have no rivals.
            let Some(without) = without.filter(|_| effect != Effect::Quantisation) else {
                self.best.steps[place].rivals.clear();
                held.push(Vec::new());
                place += 1;
                continue;
            };
            if !self.worth(WORTH, without.select, self.best.found.select, noise, true) {
                changed = true;
                self.best.found = without;
                self.best.steps.remove(place);
                self.ablation.clear();
                held.clear();
                place = 0;
                continue;
            }
            let mut leads = most_promising(&ground, &without, &others(library, &[effect]))?;
            leads.truncate(AGAINST);
            let against = expand(&fit, &without, &leads)?;
            let found = &self.best.found;
            let better = against
                .first()
                .filter(|c| c.judged() < (1.0 - BETTER) * found.judged())
                .cloned();
            match better {
                Some(better) if swaps < SWAPS => {
                    swaps += 1;
                    changed = true;
                    // The newest is the last one of the order.
                    let mut step = self.best.steps.remove(place);
                    step.effect = better.newest().unwrap_or(effect);
                    self.best.steps.push(step);
                    self.best.found = better;
                    self.ablation.clear();
                    held.clear();
                    place = 0;
                }
                _ => {
                    let before = excess(without.select, noise).max(1e-300);
                    let left = |c: &Candidate| excess(c.select, noise) / before;
                    let left_over = left(found);
                    let limit = ambiguous(left_over);
                    let step = &mut self.best.steps[place];
                    step.rivals = against
                        .iter()
                        .filter(|c| left(c) <= limit)
                        .cloned()
                        .collect();
                    step.before_um = without.select;
                    step.ground = ground.clone();
                    if changed {
                        step.left_over = left_over;
                    }
                    held.push(against);
                    place += 1;
                }
            }
        }
        Ok(held)
    }

    /// A model without the effect at a place of its order, fitted anew.
    fn without(
        &self,
        fit: &JointFit<'_>,
        from: &Candidate,
        place: usize,
    ) -> Result<Option<Candidate>, Error> {
        let Some(&effect) = from.order.get(place) else {
            return Ok(None);
        };
        // Modes come more than once, in the order of the terms, the baseline's own first.
        let own = self.base.joint.terms.iter();
        let own = own.filter(|term| term.effect == effect).count();
        let earlier = from.order[..place].iter();
        let earlier = own + earlier.filter(|e| **e == effect).count();
        let terms = &from.joint.terms;
        let mut of_effect = terms.iter().enumerate().filter(|(_, t)| t.effect == effect);
        let Some((index, _)) = of_effect.nth(earlier) else {
            return Ok(None);
        };
        let mut joint = from.joint.clone();
        joint.terms = terms.without(index);
        joint.core.beta = joint.terms.beta(fit.seen());
        fit.settle(&mut joint, SETTLED.0)?;
        let mut order = from.order.clone();
        order.remove(place);
        Candidate::new(fit, joint, order).map(Some)
    }

    /// Whether a look-alike of one name makes another one needless; then it takes their place.
    fn do_with_fewer(&mut self) -> Result<bool, Error> {
        let ground = self.best.ground.clone();
        let fit = ground.fit();
        let noise = self.heard(&self.best);
        let found = self.best.found.select;
        let mut best: Option<Change> = None;
        for (place, step) in self.best.steps.iter().enumerate() {
            for rival in &step.rivals {
                for other in replaceable(rival) {
                    let Some(fewer) = self.without(&fit, rival, other)? else {
                        continue;
                    };
                    if !self.worth(WORTH, fewer.select, found, noise, true) {
                        let change = Change {
                            found: fewer,
                            place,
                            other: Some(other),
                        };
                        best = Some(change.or_better(best));
                    }
                }
            }
        }
        Ok(self.take(best))
    }

    /// Where more than the noise is left over: tries another effect in place of each, with one more or with
    /// another one in place of a second; whether that explains more.
    fn exchange(&mut self, held: &Held, library: &[Effect]) -> Result<bool, Error> {
        let ground = self.best.ground.clone();
        let fit = ground.fit();
        let noise = self.heard(&self.best);
        let found = self.best.found.clone();
        if excess(found.select, noise) < EXPLAINED * noise {
            return Ok(false);
        }
        let mut best: Option<Change> = None;
        for (place, against) in held.iter().enumerate() {
            let was = self.best.steps[place].effect;
            for rival in against.iter().take(EXCHANGED.0) {
                let mut starts = Vec::new();
                if self.best.steps.len() < MOST {
                    starts.push((rival.clone(), None, vec![was]));
                }
                for other in replaceable(rival) {
                    if let Some(without) = self.without(&fit, rival, other)? {
                        starts.push((without, Some(other), vec![was, rival.order[other]]));
                    }
                }
                for (start, other, used) in starts {
                    let mut leads = most_promising(&ground, &start, &others(library, &used))?;
                    leads.truncate(EXCHANGED.1);
                    let worth = |c: &Candidate| match other {
                        None => self.worth(WORTH, found.select, c.select, noise, true),
                        Some(_) => c.judged() < (1.0 - BETTER) * found.judged(),
                    };
                    let tried = expand(&fit, &start, &leads)?;
                    if let Some(found) = tried.into_iter().find(worth) {
                        let change = Change {
                            found,
                            place,
                            other,
                        };
                        best = Some(change.or_better(best));
                    }
                }
            }
        }
        Ok(self.take(best))
    }

    /// Makes a change, if there is one.
    fn take(&mut self, change: Option<Change>) -> bool {
        let Some(Change {
            found,
            place,
            other,
        }) = change
        else {
            return false;
        };
        for gone in std::iter::once(place).chain(other) {
            self.best.steps.remove(gone);
        }
        let kept = self.best.steps.len();
        for &effect in found.order.iter().skip(kept) {
            self.best.steps.push(Step {
                effect,
                rivals: Vec::new(),
                before_um: self.best.found.select,
                left_over: 1.0,
                ground: self.best.ground.clone(),
            });
        }
        self.best.found = found;
        true
    }
}

/// A model in place of the best one. Its order is that of the steps without one place, then without the
/// `other` one of what that leaves, then what is new.
struct Change {
    found: Candidate,
    place: usize,
    other: Option<usize>,
}

impl Change {
    fn or_better(self, before: Option<Self>) -> Self {
        match before {
            Some(before) if before.found.judged() <= self.found.judged() => before,
            _ => self,
        }
    }
}

/// The places in a rival's order beside its own, the last one, that are no steps of the reading.
fn replaceable(rival: &Candidate) -> Vec<usize> {
    let beside = rival.order.iter().enumerate().rev().skip(1).rev();
    let places = beside.filter(|(_, effect)| **effect != Effect::Quantisation);
    places.map(|(place, _)| place).collect()
}

/// The library without some of it.
fn others(library: &[Effect], without: &[Effect]) -> Vec<Effect> {
    let others = library.iter().copied();
    others.filter(|effect| !without.contains(effect)).collect()
}
