//! Steps of the reading in a search: what they explain needs no search, and what is left outside of them may.

use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::joint::SETTLED;

use super::diagnosis::excess;
use super::naming::{EXPLAINED, NAMED, Search, Step};
use super::search::Candidate;

impl Search {
    /// Steps of the reading, where they matter beside the noise: known before anything is searched for.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub(super) fn know_steps_of_reading(&mut self) -> Result<(), Error> {
        let effect = Effect::Quantisation;
        let fit = self.best.ground.fit();
        let start = effect.template().starts(fit.seen()).into_iter().next();
        let Some(start) = start.filter(|_| !self.best.found.joint.terms.has(effect)) else {
            return Ok(());
        };
        let before_um = self.best.found.select;
        let mut joint = self.best.found.joint.clone();
        joint.terms = joint.terms.with(effect, start);
        fit.settle(&mut joint, SETTLED.0)?;
        let mut order = self.best.found.order.clone();
        order.push(effect);
        let found = Candidate::new(&fit, joint, order)?;
        self.best.steps.push(Step {
            effect,
            rivals: Vec::new(),
            before_um,
            left_over: excess(found.select, self.noise.0)
                / excess(before_um, self.noise.0).max(1e-300),
            ground: self.best.ground.clone(),
        });
        self.best.found = found;
        self.read = Some(self.best.clone());
        Ok(())
    }

    /// Beside steps of the reading only what explains most of what they leave is named.
    pub(super) fn let_steps_explain(&mut self) {
        let Some(read) = &self.read else {
            return;
        };
        let noise = self.heard(read);
        let left = excess(self.best.found.select, noise);
        if left > NAMED * excess(read.found.select, noise) && left > EXPLAINED * noise {
            self.best = read.clone();
            self.ablation.clear();
        }
    }
}
