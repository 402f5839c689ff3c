//! Which effects are named: the most promising paths are followed together.

use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::joint::Lead;
use crate::identify::rounding::outside;
use crate::identify::{Source, noise};

use super::baseline::with_wide_plays;
use super::diagnosis::{Ablation, Verdict, excess};
use super::search::{Candidate, Ground, most_promising, one_more};

/// Gain on the select records below which an effect is not worth its name, over the noise, where no
/// bootstrap has been asked for.
pub const BAR: f64 = 0.5;
/// Share of that bar which is enough beside effects that are known.
const BESIDE: f64 = 0.5;
/// Excess on the select records below which effects explain it all, over the noise: correlated noise
/// reads too low by up to a fifth where it is estimated from repeats.
pub(super) const EXPLAINED: f64 = 0.7;
/// The same below which nothing more is searched for: what an effect has to leave to be found is twice that.
const QUIET: f64 = 0.5;
/// The same below which nothing can be said to be missing where no effect is found.
const MISSING: f64 = 1.0;
/// Least share of the excess before that an effect has to close, squares taken.
pub const WORTH: f64 = 0.3;
/// The same of an effect that others must make up for.
const ALONE: f64 = 0.1;
/// The same of all of these together, and how many they may be at most, without and beside names.
const ALL: f64 = 0.5;
const TOGETHER: (usize, usize) = (3, 2);
/// Shares of the square of what is left of the fit records: an effect that takes the first is followed
/// whatever share of the select records it takes, one that takes the second even where it does harm there.
const FITTING: (f64, f64) = (0.3, 0.5);
/// How much more of the select records such an effect may leave than was left before.
const SPOILT: f64 = 1.5;
/// What may be left over where the effects are said to explain it all.
pub(super) const NAMED: f64 = 0.35;
/// What may be left over where they are said to explain a part.
const PARTIAL: f64 = 0.7;
/// How much more than the best another effect may leave over and still be possible.
const AMBIGUOUS: f64 = 1.5;
/// Effects at most.
pub(super) const MOST: usize = 4;
/// How often the search goes on where holding the names has changed them.
const RESUMED: usize = 2;
/// Paths that are followed together.
const BEAM: usize = 3;
/// How much more than the best a path may leave over and still be followed.
const FOLLOWABLE: f64 = 2.5;
/// Noise before a rounding that a path has to live with at least, over the step.
const SHARP_STEPS: f64 = 0.02;
/// Excess outside of known steps below which nothing is searched for, over the noise there: the stage is
/// no more like the plays than that.
const PAST_STEPS: f64 = 1.5;

/// A step of a path.
#[derive(Clone)]
pub struct Step {
    /// The effect that was added.
    pub effect: Effect,
    /// The other members of the ambiguity set.
    pub rivals: Vec<Candidate>,
    /// Rms on the select records before it, in um.
    pub before_um: f64,
    /// Excess after it over the excess before.
    pub left_over: f64,
    /// The histories on which it was found.
    pub ground: Ground,
}

/// Effects found one after the other, with the model that holds them.
#[derive(Clone)]
pub struct Path {
    /// The histories.
    pub ground: Ground,
    /// The model.
    pub found: Candidate,
    /// The steps that led to it.
    pub steps: Vec<Step>,
}

impl Path {
    /// How many effects are known beside the steps of the reading.
    pub(super) fn names(&self) -> usize {
        let effects = self.steps.iter().map(|step| step.effect);
        effects.filter(|&e| e != Effect::Quantisation).count()
    }
}

/// What a search found.
pub struct Search {
    /// The baseline's histories.
    pub ground: Ground,
    /// The baseline.
    pub base: Candidate,
    /// The noise floor in um, and its source.
    pub noise: (f64, Source),
    /// Gain on the select records below which an effect is not worth its name, over the noise.
    pub bar: f64,
    /// The core that the search began with, without effects; the baseline unless a richer one was tried.
    pub core: Candidate,
    /// The best path.
    pub best: Path,
    /// The core with the steps of the reading alone, where it has some.
    pub(super) read: Option<Path>,
    /// The effect alone that explains most of the fit records, worth its name or not.
    pub hint: Option<Path>,
    /// What each effect alone leaves over on the select records in um.
    pub screened: Vec<(Effect, f64)>,
    /// What leaving out each effect does.
    pub ablation: Vec<Ablation>,
}

impl Search {
    /// Searches from a baseline, or on from a path that begins with a richer core.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn run(
        ground: Ground,
        base: Candidate,
        start: Option<Path>,
        (noise, bar): ((f64, Source), f64),
        library: &[Effect],
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<Self, Error> {
        // A single name was compared where it was found, unless the core has changed since.
        let enough = if start.as_ref().is_some_and(|path| !path.steps.is_empty()) {
            1
        } else {
            2
        };
        let best = start.unwrap_or_else(|| Path {
            ground: ground.clone(),
            found: base.clone(),
            steps: Vec::new(),
        });
        // Where effects were there already, nobody knows the richer core without them.
        let core = if best.steps.is_empty() {
            best.found.clone()
        } else {
            base.clone()
        };
        let mut search = Self {
            ground,
            base,
            core,
            noise,
            bar,
            best,
            read: None,
            hint: None,
            screened: Vec::new(),
            ablation: Vec::new(),
        };
        if library.contains(&Effect::Quantisation) {
            search.know_steps_of_reading()?;
        }
        // Names that have changed may leave room for one more.
        for _ in 0..RESUMED {
            search.follow(library, progress)?;
            if search.best.names() < enough || !search.hold_all(library, enough, progress)? {
                break;
            }
        }
        if let [only] = &mut search.best.steps[..]
            && !search.ablation.is_empty()
        {
            // What it left was counted while another one stood beside it.
            let left = |candidate: &Candidate| excess(candidate.select, search.noise.0);
            only.left_over = left(&search.best.found) / left(&search.core).max(1e-300);
        }
        search.let_steps_explain();
        Ok(search)
    }

    /// The noise that a path has to live with: rounding is noise to every model that does not know it,
    /// and of one that does, what lies outside of the steps that were read.
    pub(super) fn heard(&self, path: &Path) -> f64 {
        let runs = &path.ground.runs;
        match runs.step_um {
            Some(step) if path.found.joint.terms.has(Effect::Quantisation) => {
                outside(step, runs.noise_before_steps_um.max(SHARP_STEPS * step))
            }
            Some(step) => self.noise.0.max(step / 12f64.sqrt()),
            None => self.noise.0,
        }
    }

    fn follow(
        &mut self,
        library: &[Effect],
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<(), Error> {
        let noise = self.heard(&self.best);
        let known = self.read.is_some() && self.best.names() == 0;
        if known && excess(self.best.found.select, noise) < PAST_STEPS * noise {
            return Ok(());
        }
        let mut beam = vec![self.best.clone()];
        // Effects of the same size may each take too little to be worth it alone.
        let mut together = 0;
        for _ in self.best.steps.len()..MOST {
            let noise = self.heard(&self.best);
            let left = excess(self.best.found.select, noise);
            if self.best.names() > 0 && left < QUIET * noise {
                break;
            }
            let mut next: Vec<Path> = Vec::new();
            for (rank, path) in beam.iter().enumerate() {
                let noise = self.heard(path);
                let promises = || {
                    // A third of what is wanted: a start promises less than its fit holds.
                    let wanted = 0.3 * (BESIDE * self.bar * noise).powi(2);
                    let gain = |lead: &Lead| path.found.joint.rms.powi(2) - lead.rms.powi(2);
                    let leads = most_promising(&path.ground, &path.found, library)?;
                    Ok::<_, Error>(leads.iter().any(|lead| gain(lead) > wanted))
                };
                if path.names() > 0 && !promises()? {
                    if rank == 0 && together == 0 {
                        break;
                    }
                    continue;
                }
                let (ground, found) = one_more(&path.ground, &path.found, library, progress)?;
                if self.screened.is_empty() {
                    self.screened = found
                        .iter()
                        .filter_map(|c| Some((c.newest()?, c.select)))
                        .collect();
                }
                if self.hint.is_none() && path.steps.is_empty() {
                    let least =
                        |a: &&Candidate, b: &&Candidate| a.joint.rms.total_cmp(&b.joint.rms);
                    let best = found.iter().min_by(least);
                    self.hint = best.and_then(|best| self.step(path, &ground, &found, best));
                }
                next.extend(self.extended(path, &ground, &found));
            }
            next.sort_by(|a, b| a.found.judged().total_cmp(&b.found.judged()));
            let mut seen: Vec<Vec<Effect>> = Vec::new();
            next.retain(|path| {
                let mut set = path.found.order.clone();
                set.sort();
                let new = !seen.contains(&set);
                seen.push(set);
                new
            });
            let Some(first) = next.first().cloned() else {
                break;
            };
            let noise = self.heard(&first);
            // A path of more effects must be worth them against the best of fewer.
            let worth = if together > 0 { ALL } else { WORTH };
            let (before, after) = (self.best.found.select, first.found.select);
            if !self.worth(worth, before, after, noise, self.best.names() > 0) {
                together += 1;
                let most = match self.best.names() {
                    0 => TOGETHER.0,
                    _ => TOGETHER.1,
                };
                if together == most {
                    break;
                }
                next.truncate(BEAM);
                beam = next;
                continue;
            }
            together = 0;
            self.learn_noise(&first)?;
            for path in next.iter_mut().take(BEAM) {
                self.judge_newest(path);
                self.look_closer(path)?;
            }
            let first = next.first().cloned().unwrap_or(first);
            let noise = self.heard(&first);
            let left = |path: &Path| excess(path.found.select, noise);
            let limit = (FOLLOWABLE * left(&first)).max(noise);
            next.retain(|path| left(path) <= limit);
            next.truncate(BEAM);
            self.best = first;
            beam = next;
        }
        Ok(())
    }

    /// A path with each of the effects that are worth it.
    fn extended(&self, path: &Path, ground: &Ground, found: &[Candidate]) -> Vec<Path> {
        let noise = self.heard(path);
        let before = &path.found;
        let named = self.best.names() > 0;
        let worth = |c: &&Candidate| {
            let left = (c.joint.rms / before.joint.rms).powi(2);
            // Others may have to make up for it: in a single record it may do harm without them.
            let trusted = left < 1.0 - FITTING.1 && c.select < SPOILT * before.select;
            let share = match named {
                true => WORTH,
                false if left < 1.0 - FITTING.0 => 0.0,
                false => ALONE,
            };
            trusted || self.worth(share, before.select, c.select, noise, named)
        };
        let followed = found.iter().filter(worth).take(BEAM);
        followed
            .filter_map(|candidate| self.step(path, ground, found, candidate))
            .collect()
    }

    /// A path with one effect more, that of a candidate among those `found`.
    fn step(
        &self,
        path: &Path,
        ground: &Ground,
        found: &[Candidate],
        candidate: &Candidate,
    ) -> Option<Path> {
        let effect = candidate.newest()?;
        let others = found.iter().filter(|c| c.newest() != Some(effect));
        let mut steps = path.steps.clone();
        steps.push(Step {
            effect,
            rivals: others.cloned().collect(),
            before_um: path.found.select,
            left_over: 1.0,
            ground: ground.clone(),
        });
        let mut longer = Path {
            ground: ground.clone(),
            found: candidate.clone(),
            steps,
        };
        self.judge_newest(&mut longer);
        Some(longer)
    }

    /// What the last step of a path leaves over, and which of its rivals are possible beside it, as the
    /// noise is known now.
    fn judge_newest(&self, path: &mut Path) {
        let noise = self.heard(path);
        let found = path.found.select;
        if let Some(step) = path.steps.last_mut() {
            let before = excess(step.before_um, noise).max(1e-300);
            step.left_over = excess(found, noise) / before;
            let limit = ambiguous(step.left_over);
            let possible = |c: &Candidate| excess(c.select, noise) / before <= limit;
            step.rivals.retain(possible);
        }
    }

    /// Where a path leaves more than the noise, looks for plays wider than every loop and moves the
    /// thresholds once more: beside all that was missing before they may not have shown.
    fn look_closer(&self, path: &mut Path) -> Result<(), Error> {
        let noise = self.heard(path);
        if excess(path.found.select, noise) > EXPLAINED * noise {
            let fit = path.ground.fit();
            let joint = with_wide_plays(&fit, path.found.joint.clone())?;
            path.found = Candidate::new(&fit, joint, path.found.order.clone())?;
            // A play between two of the spread takes a round to be both, and one to be itself.
            for _ in 0..2 {
                path.found.sharpen(&fit)?;
            }
        }
        Ok(())
    }

    /// Lowers the noise floor to what the model's own residuals repeat: what it explains is no noise.
    fn learn_noise(&mut self, path: &Path) -> Result<(), Error> {
        let joint = &path.found.joint;
        if joint.terms.has(Effect::Quantisation) {
            return Ok(());
        }
        let predicted = path.ground.fit().predicted(&joint.core, &joint.terms)?;
        let mut runs = path.ground.runs.runs.clone();
        for (run, predicted) in runs.iter_mut().zip(predicted) {
            for (y, predicted) in run.displacement.iter_mut().zip(predicted) {
                *y -= predicted;
            }
        }
        if let Some(found) = noise::floor(&runs).filter(|found| found.0 < self.noise.0) {
            self.noise = found;
        }
        Ok(())
    }

    /// Whether an effect that lowers the rms on the select records so far, by that share of the squared
    /// excess at least, is worth its name.
    /// Beside others the bar is lower: that something is missing is known then.
    pub(super) fn worth(
        &self,
        share: f64,
        before: f64,
        after: f64,
        noise: f64,
        beside: bool,
    ) -> bool {
        let gain = before * before - after * after;
        let bar = if beside { BESIDE } else { 1.0 } * self.bar * noise;
        gain > bar * bar && gain > share * excess(before, noise).powi(2)
    }

    /// Whether this search explains more than another.
    pub fn better_than(&self, other: &Self) -> bool {
        let rms = |search: &Self| {
            let found = &search.best.found;
            found.select.hypot(found.joint.rms)
        };
        rms(self) < 0.95 * rms(other)
    }

    /// Whether nothing beyond the noise is left over.
    pub fn explains_all(&self) -> bool {
        excess(self.best.found.select, self.noise.0) < EXPLAINED * self.noise.0
    }

    /// What to say where nothing is named.
    pub fn unnamed(&self) -> Verdict {
        if excess(self.base.select, self.noise.0) < MISSING * self.noise.0 {
            Verdict::None
        } else {
            Verdict::Unknown
        }
    }

    /// What to say of it all.
    pub fn verdict(&self) -> Verdict {
        let noise = self.noise.0;
        let before = excess(self.base.select, noise);
        let left = excess(self.best.found.select, noise) / before.max(1e-300);
        if self.best.steps.is_empty() {
            self.unnamed()
        } else if left <= NAMED || self.explains_all() {
            Verdict::Named
        } else if left <= PARTIAL {
            Verdict::Partial
        } else {
            Verdict::Unknown
        }
    }
}

/// What a candidate may leave over to be possible beside one that leaves `left`.
pub(super) fn ambiguous(left: f64) -> f64 {
    (AMBIGUOUS * left).max(left + 0.02)
}
