//! The search: which effects, one after the other or together, explain what the baseline leaves over.

use rayon::prelude::*;

use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::joint::{Joint, JointFit};

use super::baseline::judged;

/// Modes that a model may have.
const MODES: usize = 3;
/// Starts of an effect that are followed to their end.
const FOLLOWED: usize = 2;

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

    /// Numbers that were fitted for its effects.
    pub fn numbers(&self, fit: &JointFit<'_>) -> usize {
        self.joint.terms.free(fit.seen()).len()
    }
}

/// Effects that may be added to a model.
pub fn possible(fit: &JointFit<'_>, base: &Candidate) -> Vec<Effect> {
    let terms = &base.joint.terms;
    let count = |effect| terms.iter().filter(|term| term.effect == effect).count();
    Effect::ALL
        .into_iter()
        .filter(|&effect| {
            effect.template().hidden(fit.seen()).is_none()
                && !effect.template().starts(fit.seen()).is_empty()
                && match effect {
                    Effect::Resonance => count(effect) < MODES,
                    Effect::RateLaw => terms.has(Effect::RateDependence) && !terms.has(effect),
                    // Without a mode it is the same as the one before the modes.
                    Effect::OutputQuadratic => terms.has(Effect::Resonance) && !terms.has(effect),
                    _ => !terms.has(effect),
                }
        })
        .collect()
}

/// `base` with each of the `effects`, fitted anew, the best on the select records first.
///
/// # Errors
/// Numbers that the core refuses.
pub fn expand(
    fit: &JointFit<'_>,
    base: &Candidate,
    effects: &[Effect],
) -> Result<Vec<Candidate>, Error> {
    let mut found: Vec<Candidate> = effects
        .par_iter()
        .map(|&effect| {
            let Some(joint) = fit.add(&base.joint, effect, FOLLOWED)? else {
                return Ok(None);
            };
            let mut order = base.order.clone();
            order.push(effect);
            Candidate::new(fit, joint, order).map(Some)
        })
        .filter_map(Result::transpose)
        .collect::<Result<_, Error>>()?;
    found.sort_by(|a, b| a.select.total_cmp(&b.select));
    Ok(found)
}
