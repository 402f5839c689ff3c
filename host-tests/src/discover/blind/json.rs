//! `blind.json`: the types that it is written from, and their JSON Schema.

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use crate::discover::Verdict;
use crate::error::Error;

use super::outcome::{self, Outcome};
use super::plan::{self, Plan};
use super::run::Blind;
use super::scores::Scores;

/// What `hysteron blind` hid and what it was answered.
#[derive(Serialize, JsonSchema)]
#[schemars(title = "hysteron blind trials")]
struct File<'a> {
    /// What was asked for.
    plan: Asked,
    /// What the cases come to.
    scores: &'a Scores,
    /// The cases in the order of their seeds.
    cases: Vec<Case<'a>>,
}

/// What was asked for.
#[derive(Serialize, JsonSchema)]
struct Asked {
    /// Number of cases.
    cases: u64,
    /// How far the truth is from the models.
    #[schemars(range(min = 1, max = 4))]
    tier: u8,
    /// Seed of the first case.
    seed: u64,
    /// Percent of the stroke.
    noise_percent: Range,
    /// Percent of the stroke; null where it follows the noise.
    strength: Option<Range>,
    /// Effects in a case.
    effects: u64,
    /// What is recorded.
    protocol: &'static str,
    /// Share of cases without effect.
    none_share: f64,
    /// Whether each diagnosis is repeated without the template of the hidden effect.
    leave_out: bool,
}

/// From low to high.
#[derive(Serialize, JsonSchema)]
struct Range {
    /// Least.
    low: f64,
    /// Largest.
    high: f64,
}

/// A case.
#[derive(Serialize, JsonSchema)]
struct Case<'a> {
    /// The hidden effects, in the order of the signal.
    truth: &'a [String],
    /// Its seed.
    seed: u64,
    /// Rms of the noise, percent of the stroke.
    noise_percent: f64,
    /// Size of each effect, percent of the stroke.
    strength: f64,
    /// Whether an effect is weaker than that because it has reached its bound.
    bounded: bool,
    /// Whether the answer is what it should be.
    solved: bool,
    /// What writes its data.
    command: String,
    #[serde(flatten)]
    answer: Answer<'a>,
}

/// The answer, or why there is none.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum Answer<'a> {
    Failed {
        /// Why the diagnosis failed.
        error: &'a str,
    },
    Given {
        /// What it says.
        verdict: Verdict,
        /// What it names, in the order of discovery.
        effects: Vec<Named<'a>>,
        /// Estimated noise over the true one.
        noise_ratio: f64,
        /// How far the effect moves what the baseline leaves, over the true noise; of several the least;
        /// without any, what it leaves beyond the noise.
        reach: f64,
        /// Share of the gap on the report records that is closed.
        closed: Option<f64>,
        /// The verdict without the template of the hidden effect.
        left_out_verdict: Option<Verdict>,
        /// Processor time on one thread.
        seconds: f64,
    },
}

/// A named effect.
#[derive(Serialize, JsonSchema)]
struct Named<'a> {
    /// Its name.
    name: &'a str,
    /// The rest of the ambiguity set.
    also_possible: &'a [String],
}

impl Blind {
    /// The contents of `blind.json`.
    ///
    /// # Errors
    /// None that a run could cause; those of the serialiser.
    pub fn to_json(&self) -> Result<Value, Error> {
        let file = File {
            plan: Asked::new(&self.plan),
            scores: &self.scores,
            cases: self.outcomes.iter().map(Case::new).collect(),
        };
        serde_json::to_value(file)
            .map_err(|refused| Error::request(format!("blind.json: {refused}")))
    }
}

impl Asked {
    fn new(plan: &Plan) -> Self {
        let range = |range: plan::Range| Range {
            low: range.low,
            high: range.high,
        };
        Self {
            cases: plan.cases as u64,
            tier: plan.tier.number(),
            seed: plan.seed,
            noise_percent: range(plan.noise),
            strength: plan.strength.map(range),
            effects: plan.effects as u64,
            protocol: plan.protocol.name(),
            none_share: plan.none_share,
            leave_out: plan.leave_out,
        }
    }
}

impl<'a> Case<'a> {
    fn new(outcome: &'a Outcome) -> Self {
        Self {
            truth: &outcome.truth,
            seed: outcome.case.seed,
            noise_percent: outcome.case.noise_percent,
            strength: outcome.case.strength,
            bounded: outcome.bounded,
            solved: outcome.solved(),
            command: outcome.command(),
            answer: match &outcome.answer {
                Ok(answer) => Answer::given(answer),
                Err(error) => Answer::Failed { error },
            },
        }
    }
}

impl<'a> Answer<'a> {
    fn given(answer: &'a outcome::Answer) -> Self {
        let named = answer.named.iter().map(|one| Named {
            name: &one.name,
            also_possible: &one.also_possible,
        });
        Self::Given {
            verdict: answer.verdict,
            effects: named.collect(),
            noise_ratio: answer.noise_ratio,
            reach: answer.reach,
            closed: answer.closed,
            left_out_verdict: answer.left_out,
            seconds: answer.seconds,
        }
    }
}

/// The text of `docs/blind.schema.json`.
pub fn schema_text() -> String {
    crate::schema_file::text(&schemars::schema_for!(File<'static>))
}
