//! What the outcomes of many cases come to.

use schemars::JsonSchema;
use serde::Serialize;

use crate::discover::Verdict;
use crate::plant::hidden::Effect;

use super::outcome::{Outcome, REVEALED};

/// Edges of the detection curve's bins: what the baseline leaves over the noise.
const EDGES: [f64; 8] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0];
/// Standard deviations on either side in an interval of 95 %.
const SIDES: f64 = 1.96;
/// Rows and columns of the confusion matrix that are no effects.
const NOTHING: [&str; 4] = ["none", "partial", "unknown", "error"];

/// So many of so many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(into = "Shown")]
pub struct Share {
    /// How many have the property.
    pub count: usize,
    /// Of how many.
    pub of: usize,
}

/// Least, middle and largest of some figures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    /// Least.
    pub least: f64,
    /// Median.
    pub median: f64,
    /// Largest.
    pub largest: f64,
}

/// Truth against answer, cases with one effect or none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Confusion {
    /// What was hidden, one a row.
    pub truths: Vec<String>,
    /// What was answered, one a column.
    pub answers: Vec<String>,
    /// Cases, by row and column.
    pub counts: Vec<Vec<usize>>,
}

/// The figures of one effect over the cases that reveal it.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ByEffect {
    /// The effect.
    pub effect: String,
    /// Cases that were found as they should be.
    pub solved: Share,
    /// Cases in which it is a name or a look-alike of one.
    pub in_set: Share,
    /// Cases in which leaving out its template gives `unknown` or `partial`.
    pub flagged: Share,
}

/// A bin of the detection curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Bin {
    /// Least reach.
    pub from: f64,
    /// Reach of the next bin, `None` for the last.
    pub to: Option<f64>,
    /// Cases solved.
    pub solved: Share,
}

/// What the outcomes come to.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Scores {
    /// Diagnoses that ended in an error.
    pub errors: Share,
    /// Cases whose effects move what the baseline leaves by as much as the noise.
    pub revealed: Share,
    /// Revealed cases with one effect: verdict `named`, and the first name is the truth.
    pub top_1: Share,
    /// The same with verdict `partial` allowed.
    pub top_1_or_partial: Share,
    /// Revealed cases: every truth is a name or a look-alike of one.
    pub in_set: Share,
    /// Mean size of the first name's set over the revealed cases that name anything.
    pub mean_set_size: Option<f64>,
    /// Revealed cases whose names are all the truth and nothing else.
    pub exact: Share,
    /// Revealed cases with more names than effects.
    pub surplus: Share,
    /// Cases not revealed that are solved all the same.
    pub solved_below: Share,
    /// Cases not revealed in which the first name is wrong.
    pub misnamed_below: Share,
    /// Cases without effect in which something is named.
    pub false_names: Share,
    /// Cases without effect with the verdict `unknown`.
    pub false_alarms: Share,
    /// Revealed cases that are flagged without the template of the truth.
    pub flagged: Share,
    /// Gap closed on the report records of revealed cases.
    pub closed: Option<Spread>,
    /// Processor time of a diagnosis on one core in s.
    pub seconds: Option<Spread>,
    /// By hidden effect.
    pub by_effect: Vec<ByEffect>,
    /// Solved against the reach.
    pub detection: Vec<Bin>,
    /// Truth against answer.
    pub confusion: Confusion,
}

impl Scores {
    /// The scores of these outcomes.
    pub fn new(outcomes: &[Outcome]) -> Self {
        let hiding = || outcomes.iter().filter(|one| one.hides());
        let revealed = || hiding().filter(|one| one.revealed());
        let single = || revealed().filter(|one| one.truth.len() == 1);
        let below = || hiding().filter(|one| one.answer.is_ok() && !one.revealed());
        let none = || outcomes.iter().filter(|one| !one.hides());
        let answers = |one: &Outcome| one.answer.as_ref().ok().cloned();
        let sizes: Vec<f64> = revealed()
            .filter_map(|one| one.named().first())
            .map(|first| 1.0 + first.also_possible.len() as f64)
            .collect();
        let closed = revealed().filter_map(|one| answers(one)?.closed);
        let seconds = outcomes
            .iter()
            .filter_map(|one| Some(answers(one)?.seconds));
        Self {
            errors: Share::new(outcomes.iter(), |one| one.answer.is_err()),
            revealed: Share::new(hiding(), Outcome::revealed),
            top_1: Share::new(single(), Outcome::top_1),
            top_1_or_partial: Share::new(single(), Outcome::first_is_true),
            in_set: Share::new(revealed(), Outcome::in_set),
            mean_set_size: (!sizes.is_empty())
                .then(|| sizes.iter().sum::<f64>() / sizes.len() as f64),
            exact: Share::new(revealed(), Outcome::exact),
            surplus: Share::new(revealed(), Outcome::surplus),
            solved_below: Share::new(below(), Outcome::solved),
            misnamed_below: Share::new(below(), |one| {
                one.named()
                    .first()
                    .is_some_and(|first| !one.truth.contains(&first.name))
            }),
            false_names: Share::new(none(), |one| !one.named().is_empty()),
            false_alarms: Share::new(none(), |one| {
                answers(one).is_some_and(|answer| answer.verdict == Verdict::Unknown)
            }),
            flagged: flagged(single()),
            closed: Spread::new(closed.collect()),
            seconds: Spread::new(seconds.collect()),
            by_effect: by_effect(outcomes),
            detection: detection(outcomes),
            confusion: Confusion::new(outcomes),
        }
    }
}

fn flagged<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> Share {
    let mut share = Share::default();
    for one in outcomes {
        if let Some(verdict) = one.answer.as_ref().ok().and_then(|answer| answer.left_out) {
            share.of += 1;
            share.count += usize::from(matches!(verdict, Verdict::Unknown | Verdict::Partial));
        }
    }
    share
}

fn by_effect(outcomes: &[Outcome]) -> Vec<ByEffect> {
    Effect::ALL
        .into_iter()
        .map(Effect::name)
        .filter_map(|effect| {
            let having = || {
                let having = outcomes.iter().filter(|one| one.revealed());
                having.filter(|one| one.truth.iter().any(|truth| truth == effect))
            };
            having().next()?;
            Some(ByEffect {
                effect: effect.to_owned(),
                solved: Share::new(having(), Outcome::solved),
                in_set: Share::new(having(), |one| one.possible(effect)),
                flagged: flagged(having()),
            })
        })
        .collect()
}

fn detection(outcomes: &[Outcome]) -> Vec<Bin> {
    let ends = EDGES.into_iter().map(Some).chain([None]);
    let starts = [0.0].into_iter().chain(EDGES);
    starts
        .zip(ends)
        .filter_map(|(from, to)| {
            let inside = outcomes.iter().filter(|one| {
                one.hides()
                    && one.answer.as_ref().is_ok_and(|answer| {
                        answer.reach >= from && to.is_none_or(|to| answer.reach < to)
                    })
            });
            let solved = Share::new(inside, Outcome::solved);
            (solved.of > 0).then_some(Bin { from, to, solved })
        })
        .collect()
}

impl Bin {
    /// Where its point is drawn: the middle in the logarithm, a factor of two where an end is open.
    pub fn middle(&self) -> f64 {
        let to = self.to.unwrap_or(4.0 * self.from);
        let from = if self.from > 0.0 {
            self.from
        } else {
            0.25 * to
        };
        (from * to).sqrt()
    }

    /// Whether its effects must be found.
    pub fn revealed(&self) -> bool {
        self.from >= REVEALED
    }
}

impl Confusion {
    fn new(outcomes: &[Outcome]) -> Self {
        let pairs: Vec<(String, String)> = outcomes
            .iter()
            .filter(|one| one.truth.len() <= 1)
            .map(|one| {
                let word = one.answer.as_ref().map_or("error", |answer| answer.word());
                (one.hidden(), word.to_owned())
            })
            .collect();
        // In the order of the library; names that only the diagnosis has come behind its effects.
        let ordered = |mut words: Vec<String>| {
            let place = |word: &String| {
                let effect = Effect::ALL.iter().position(|e| e.name() == word);
                let nothing = NOTHING.iter().position(|name| name == word);
                let after = nothing.map_or(0, |i| 1 + i);
                effect.unwrap_or(Effect::ALL.len() + after)
            };
            words.sort_by(|a, b| place(a).cmp(&place(b)).then_with(|| a.cmp(b)));
            words.dedup();
            words
        };
        let truths = ordered(pairs.iter().map(|(truth, _)| truth.clone()).collect());
        let answers = ordered(pairs.iter().map(|(_, answer)| answer.clone()).collect());
        let counts = truths
            .iter()
            .map(|truth| {
                let count = |answer: &String| {
                    let same = |pair: &&(String, String)| pair.0 == *truth && pair.1 == *answer;
                    pairs.iter().filter(same).count()
                };
                answers.iter().map(count).collect()
            })
            .collect();
        Self {
            truths,
            answers,
            counts,
        }
    }
}

impl Share {
    /// How many of `outcomes` have a property.
    pub fn new<'a>(
        outcomes: impl Iterator<Item = &'a Outcome>,
        property: impl Fn(&Outcome) -> bool,
    ) -> Self {
        outcomes.fold(Self::default(), |share, one| Self {
            count: share.count + usize::from(property(one)),
            of: share.of + 1,
        })
    }

    /// The share, 0 to 1; `None` of nothing.
    pub fn rate(self) -> Option<f64> {
        (self.of > 0).then(|| self.count as f64 / self.of as f64)
    }

    /// Wilson's interval of 95 % around it.
    pub fn interval(self) -> Option<(f64, f64)> {
        let (rate, n) = (self.rate()?, self.of as f64);
        let square = SIDES * SIDES;
        let middle = rate + square / (2.0 * n);
        let side = SIDES * (rate * (1.0 - rate) / n + square / (4.0 * n * n)).sqrt();
        let scale = 1.0 + square / n;
        // Rounding may lead beyond the ends, or to a zero with a sign.
        let within = |share: f64| (share / scale).clamp(0.0, 1.0) + 0.0;
        Some((within(middle - side), within(middle + side)))
    }
}

/// A share with its rate and Wilson's interval of 95 % around it, both null of nothing.
#[derive(Serialize, JsonSchema)]
struct Shown {
    /// How many have the property.
    count: usize,
    /// Of how many.
    of: usize,
    /// The share, 0 to 1.
    rate: Option<f64>,
    /// Low and high.
    interval: Option<(f64, f64)>,
}

impl From<Share> for Shown {
    fn from(share: Share) -> Self {
        Self {
            count: share.count,
            of: share.of,
            rate: share.rate(),
            interval: share.interval(),
        }
    }
}

impl Spread {
    /// Of these figures; `None` of none.
    pub fn new(mut figures: Vec<f64>) -> Option<Self> {
        figures.sort_by(f64::total_cmp);
        let half = figures.len() / 2;
        let upper = *figures.get(half)?;
        let median = if figures.len() % 2 == 1 {
            upper
        } else {
            0.5 * (figures[half - 1] + upper)
        };
        Some(Self {
            least: figures[0],
            median,
            largest: figures[figures.len() - 1],
        })
    }
}
