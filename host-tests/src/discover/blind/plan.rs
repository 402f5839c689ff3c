//! Which cases are hidden.

use std::str::FromStr;

use rand_distr::{Distribution, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::error::{Error, quoted};
use crate::plant::hidden::{Choice, Effect, HiddenCase, Protocol, Tier};

/// Least and largest strength of an effect where none is given, percent of the stroke, and how many
/// times the noise it is at least.
const STRENGTH: (f64, f64) = (0.3, 3.0);
const OVER_NOISE: f64 = 3.0;

/// A value, or two that values are drawn between, uniform in the logarithm; percent of the stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Least value, above 0.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

/// What is hidden in bulk.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// How many cases.
    pub cases: usize,
    /// How far the truth is from the models.
    pub tier: Tier,
    /// Seed of the first case; each further case has the next one.
    pub seed: u64,
    /// Noise of each case.
    pub noise: Range,
    /// Strength of the effects of each case; where not given, from three times the noise, at least
    /// 0.3 %, to 3 % of the stroke.
    pub strength: Option<Range>,
    /// Effects in a case: one, each of the library in turn; or more, drawn by the seed.
    pub effects: usize,
    /// What is recorded.
    pub protocol: Protocol,
    /// Share of cases without an effect, 0 to 1.
    pub none_share: f64,
    /// Whether each case with a single effect is diagnosed once more without that effect's template.
    pub leave_out: bool,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            cases: 40,
            tier: Tier::Same,
            seed: 1,
            noise: Range {
                low: 0.02,
                high: 0.5,
            },
            strength: None,
            effects: 1,
            protocol: Protocol::Full,
            none_share: 0.1,
            leave_out: false,
        }
    }
}

impl Plan {
    /// The cases, each the same whatever the number of cases.
    ///
    /// # Errors
    /// Numbers out of range.
    pub fn draw(&self) -> Result<Vec<HiddenCase>, Error> {
        self.check()?;
        let share = |count: usize| (count as f64 * self.none_share).floor();
        let mut in_turn = Effect::ALL.into_iter().cycle();
        Ok((0..self.cases)
            .map(|index| {
                let seed = self.seed + index as u64;
                let choice = if share(index + 1) > share(index) {
                    Choice::Named(Vec::new())
                } else if self.effects == 1 {
                    Choice::Named(in_turn.next().into_iter().collect())
                } else {
                    Choice::Random(self.effects)
                };
                let mut random = Pcg64::seed_from_u64(seed);
                let noise_percent = self.noise.draw(&mut random);
                let low = STRENGTH.0.max(OVER_NOISE * noise_percent);
                let strength = self.strength.unwrap_or(Range {
                    low,
                    high: STRENGTH.1.max(low),
                });
                HiddenCase {
                    choice,
                    seed,
                    tier: self.tier,
                    strength: strength.draw(&mut random),
                    noise_percent,
                    protocol: self.protocol,
                    rate_term: None,
                }
            })
            .collect())
    }

    fn check(&self) -> Result<(), Error> {
        let in_range = |name: &str, range: Range, least: f64, most: f64| {
            if range.low >= least && range.high <= most && range.low <= range.high {
                return Ok(());
            }
            Err(Error::request(format!(
                "{name} {}..{} is out of range; take {least} to {most} percent of the stroke, the \
                 smaller first",
                range.low, range.high
            )))
        };
        in_range("noise", self.noise, 1e-3, 10.0)?;
        if let Some(strength) = self.strength {
            in_range("strength", strength, 1e-3, 20.0)?;
        }
        if !(0.0..=1.0).contains(&self.none_share) {
            return Err(Error::request(format!(
                "a share of {} without effect is none; take 0 to 1",
                self.none_share
            )));
        }
        if !(1..=Effect::MOST_TOGETHER).contains(&self.effects) {
            return Err(Error::request(format!(
                "{} effects cannot be hidden together; ask for 1 to {}",
                self.effects,
                Effect::MOST_TOGETHER
            )));
        }
        if self.cases == 0 {
            return Err(Error::request("ask for one case at least".to_owned()));
        }
        if self.seed.saturating_add(self.cases as u64) > i64::MAX as u64 {
            return Err(Error::request(format!(
                "seed {} leaves no seeds for {} cases; take a smaller one",
                self.seed, self.cases
            )));
        }
        Ok(())
    }
}

impl Range {
    /// A value of three significant digits, so that a command can repeat it.
    fn draw(self, random: &mut Pcg64) -> f64 {
        let share: f64 = StandardUniform.sample(random);
        let value = self.low * (self.high / self.low).powf(share);
        let unit = 10f64.powf(value.log10().floor() - 2.0);
        let rounded = (value / unit).round() * unit;
        // As a person would write it: no trace of the binary unit.
        let short = format!("{rounded:.2e}").parse().unwrap_or(rounded);
        f64::clamp(short, self.low, self.high)
    }
}

impl FromStr for Range {
    type Err = Error;

    /// A number, or two as `low..high`.
    fn from_str(text: &str) -> Result<Self, Error> {
        let number = |part: &str| {
            let value: Option<f64> = part.trim().parse().ok();
            value.filter(|value| *value > 0.0).ok_or_else(|| {
                Error::request(format!(
                    "{} is no positive number or range; write 0.1 or 0.02..0.5",
                    quoted(text)
                ))
            })
        };
        let (low, high) = text.split_once("..").unwrap_or((text, text));
        Ok(Self {
            low: number(low)?,
            high: number(high)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_take_turns_and_do_not_depend_on_their_number() {
        let plan = Plan {
            cases: 20,
            ..Plan::default()
        };
        let cases = plan.draw().unwrap();
        let none = |case: &&HiddenCase| case.choice == Choice::Named(Vec::new());
        assert_eq!(cases.iter().filter(none).count(), 2);
        let named: Vec<Effect> = cases
            .iter()
            .flat_map(|case| case.choice.effects(case.seed).unwrap())
            .collect();
        assert_eq!(named, Effect::ALL);
        for case in &cases {
            assert!((0.02..=0.5).contains(&case.noise_percent));
            assert!(case.strength >= 0.3 && case.strength >= 2.99 * case.noise_percent);
            assert!(case.strength <= 3.0);
        }
        let fewer = Plan { cases: 7, ..plan };
        assert_eq!(fewer.draw().unwrap()[..], cases[..7]);
    }

    #[test]
    fn ranges_are_read_and_refused() {
        let read = |text: &str| text.parse::<Range>();
        let range = read("0.02..0.5").unwrap();
        assert_eq!((range.low, range.high), (0.02, 0.5));
        assert_eq!(read("0.1").unwrap().high, 0.1);
        for text in ["", "0", "-1", "0.1..", "a..b", "nan"] {
            assert!(read(text).is_err(), "{text}");
        }
        let swapped = Plan {
            noise: read("0.5..0.02").unwrap(),
            ..Plan::default()
        };
        assert!(swapped.draw().is_err());
    }
}
