//! What a diagnosis answered to a case, and whether that is right.

use crate::discover::Verdict;
use crate::plant::hidden::HiddenCase;

/// A named effect with the others that may be meant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// The rest of the ambiguity set.
    pub also_possible: Vec<String>,
}

/// The answer of a diagnosis.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// What it says.
    pub verdict: Verdict,
    /// What it names, in the order of discovery.
    pub named: Vec<Named>,
    /// Estimated noise over the true one.
    pub noise_ratio: f64,
    /// How far the effect moves what the refitted baseline leaves on the select records, over the true noise;
    /// of several effects the least, each hidden alone; without any, what it leaves beyond the noise.
    pub reach: f64,
    /// The share of the gap on the report records that the extended model closes.
    pub closed: Option<f64>,
    /// The verdict without the template of the hidden effect, where that was asked for.
    pub left_out: Option<Verdict>,
    /// Processor time of the diagnosis on one core in s.
    pub seconds: f64,
}

/// A case with its truth and the answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The case.
    pub case: HiddenCase,
    /// The hidden effects, in the order of the signal.
    pub truth: Vec<String>,
    /// Whether one of them has reached its bound and is weaker than asked for.
    pub bounded: bool,
    /// The answer, or why there is none.
    pub answer: Result<Answer, String>,
}

/// The least reach of an effect that must be found.
pub const REVEALED: f64 = 1.0;

/// The verdict as it is written in files.
pub fn verdict_name(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Named => "named",
        Verdict::Partial => "partial",
        Verdict::Unknown => "unknown",
        Verdict::None => "none",
    }
}

impl Answer {
    /// What it comes to in a word: the first name, or the verdict where that names nothing for sure.
    pub fn word(&self) -> &str {
        match (self.verdict, self.named.first()) {
            (Verdict::Named, Some(first)) => &first.name,
            (verdict, _) => verdict_name(verdict),
        }
    }

    /// Whether it names anything, rightly or not.
    pub fn names(&self) -> bool {
        !self.named.is_empty() && matches!(self.verdict, Verdict::Named | Verdict::Partial)
    }
}

impl Outcome {
    /// Whether there is anything to find.
    pub fn hides(&self) -> bool {
        !self.truth.is_empty()
    }

    /// Whether the effects move what the baseline leaves by as much as the noise, so that they must be found.
    pub fn revealed(&self) -> bool {
        self.hides() && self.answer.as_ref().is_ok_and(|a| a.reach >= REVEALED)
    }

    /// Whether the verdict is `named` and the first name is the one hidden effect.
    pub fn top_1(&self) -> bool {
        self.says(Verdict::Named) && self.first_is_true()
    }

    /// Whether the first name is the one hidden effect, the verdict `named` or `partial`.
    pub fn first_is_true(&self) -> bool {
        let first = self.named().first().map(|first| &first.name);
        self.truth.len() == 1 && first == self.truth.first()
    }

    /// Whether every hidden effect is a name or a look-alike of one.
    pub fn in_set(&self) -> bool {
        self.hides() && self.truth.iter().all(|truth| self.possible(truth))
    }

    /// Whether this effect is a name or a look-alike of one.
    pub fn possible(&self, effect: &str) -> bool {
        self.named().iter().any(|named| {
            named.name == effect || named.also_possible.iter().any(|one| one == effect)
        })
    }

    /// Whether the verdict is `named` and the names are the hidden effects, no more and no fewer.
    pub fn exact(&self) -> bool {
        let mut names: Vec<&str> = self.named().iter().map(|one| one.name.as_str()).collect();
        let mut truth: Vec<&str> = self.truth.iter().map(String::as_str).collect();
        names.sort_unstable();
        truth.sort_unstable();
        self.says(Verdict::Named) && names == truth
    }

    /// Whether it names more effects than are hidden.
    pub fn surplus(&self) -> bool {
        self.named().len() > self.truth.len()
    }

    /// Whether the case counts as solved: nothing named where nothing is hidden, the effect in the
    /// first place where it is one, all of several.
    pub fn solved(&self) -> bool {
        match self.truth.len() {
            0 => self.says(Verdict::None),
            1 => self.top_1(),
            _ => self.exact(),
        }
    }

    /// What is named; nothing where the verdict names nothing.
    pub fn named(&self) -> &[Named] {
        match &self.answer {
            Ok(answer) if answer.names() => &answer.named,
            _ => &[],
        }
    }

    /// The answer in words.
    pub fn in_words(&self) -> String {
        let answer = match &self.answer {
            Ok(answer) => answer,
            Err(error) => return format!("error: {error}"),
        };
        let names: Vec<String> = self
            .named()
            .iter()
            .map(|one| {
                if one.also_possible.is_empty() {
                    one.name.clone()
                } else {
                    format!("{} (or {})", one.name, one.also_possible.join(", "))
                }
            })
            .collect();
        match (answer.verdict, names.is_empty()) {
            (verdict, true) => verdict_name(verdict).to_owned(),
            (Verdict::Named, false) => names.join(", "),
            (verdict, false) => format!("{}: {}", verdict_name(verdict), names.join(", ")),
        }
    }

    /// The names of the hidden effects, `none` without any.
    pub fn hidden(&self) -> String {
        if self.truth.is_empty() {
            "none".to_owned()
        } else {
            self.truth.join(",")
        }
    }

    /// The command that writes this case's data.
    pub fn command(&self) -> String {
        let case = &self.case;
        format!(
            "hysteron hide --effect {} --seed {} --tier {} --strength {} --noise {} --protocol {} \
             --out out/case",
            self.hidden(),
            case.seed,
            case.tier.number(),
            case.strength,
            case.noise_percent,
            case.protocol.name(),
        )
    }

    fn says(&self, verdict: Verdict) -> bool {
        self.answer.as_ref().is_ok_and(|a| a.verdict == verdict)
    }
}
