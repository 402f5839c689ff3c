//! Effects in a fit: which ones, and their numbers.

use crate::model_file::Stage;

use super::super::catalogue::{Effect, Seen};

/// An effect with its numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// The effect.
    pub effect: Effect,
    /// Its numbers, see [`Template`](super::super::catalogue::Template).
    pub numbers: Vec<f64>,
}

/// Effects in the order in which they act.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Terms(Vec<Term>);

impl Terms {
    /// No effects.
    pub fn none() -> Self {
        Self::default()
    }

    /// The terms.
    pub fn iter(&self) -> impl Iterator<Item = &Term> {
        self.0.iter()
    }

    /// Whether the effect is among them.
    pub fn has(&self, effect: Effect) -> bool {
        self.0.iter().any(|term| term.effect == effect)
    }

    /// With one more, behind those that act before or with it.
    pub fn with(&self, effect: Effect, numbers: Vec<f64>) -> Self {
        let mut terms = self.0.clone();
        let place = terms.partition_point(|term| term.effect <= effect);
        terms.insert(place, Term { effect, numbers });
        Self(terms)
    }

    /// Without the term at `index`.
    pub fn without(&self, index: usize) -> Self {
        let mut terms = self.0.clone();
        if index < terms.len() {
            terms.remove(index);
        }
        Self(terms)
    }

    /// Term and place in it of every number that a fit may move: none of an effect that the records
    /// cannot show.
    pub fn free(&self, seen: &Seen) -> Vec<(usize, usize)> {
        let mut free = Vec::new();
        for (i, term) in self.0.iter().enumerate() {
            let template = term.effect.template();
            if template.hidden(seen).is_some() {
                continue;
            }
            let bounds = template.bounds(seen, &term.numbers);
            for (j, (low, high)) in bounds.into_iter().enumerate() {
                if low < high {
                    free.push((i, j));
                }
            }
        }
        free
    }

    /// With one number changed by `change`, held within its bounds; one that is beyond them, as a model
    /// may come, goes no further.
    pub fn moved(&self, (term, number): (usize, usize), change: f64, seen: &Seen) -> Self {
        let mut moved = self.clone();
        if let Some(term) = moved.0.get_mut(term) {
            let bounds = term.effect.template().bounds(seen, &term.numbers);
            if let (Some(value), Some(&(low, high))) =
                (term.numbers.get_mut(number), bounds.get(number))
            {
                *value = (*value + change).clamp(low.min(*value), high.max(*value));
            }
        }
        moved
    }

    /// Half a step of the reading in um, where there are steps.
    pub fn half_step(&self, seen: &Seen) -> Option<f64> {
        let steps = self.0.iter().find(|t| t.effect == Effect::Quantisation)?;
        Some(0.5 * steps.numbers.first()? * seen.displacement_um)
    }

    /// Whether a number acts on what comes out of the hysteresis only.
    pub fn is_behind(&self, (term, _): (usize, usize)) -> bool {
        let term = self.0.get(term);
        term.is_some_and(|term| term.effect >= Effect::Asymmetry)
    }

    /// A number.
    pub fn number(&self, (term, number): (usize, usize)) -> f64 {
        let numbers = self.0.get(term).map(|term| &term.numbers);
        numbers.and_then(|n| n.get(number)).copied().unwrap_or(0.0)
    }

    /// The stages of a model file whose hysteresis has the given gain in um/V.
    pub fn stages(&self, seen: &Seen, gain: f64) -> Vec<Stage> {
        let stage = |term: &Term| term.effect.template().stage(&term.numbers, seen, gain);
        self.0.iter().filter_map(stage).collect()
    }

    /// The rate coefficient in seconds: of the power law, volts per power of V/s.
    pub fn beta(&self, seen: &Seen) -> f64 {
        let number = |effect| {
            let term = self.0.iter().find(|term| term.effect == effect)?;
            term.numbers.first().copied()
        };
        let share = number(Effect::RateDependence).unwrap_or(0.0);
        let exponent = 1.0 + number(Effect::RateLaw).unwrap_or(0.0);
        if share > 0.0 && seen.rate_v_per_s > 0.0 {
            share * seen.threshold_v / seen.rate_v_per_s.powf(exponent)
        } else {
            0.0
        }
    }
}
