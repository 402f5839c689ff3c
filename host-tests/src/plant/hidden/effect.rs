//! The effects that can be hidden, by name.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, quoted};

use super::draw::{Draw, Stream};

/// An effect, in the order of the signal chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names are the documentation")]
pub enum Effect {
    Saturation,
    SlewLimit,
    AmplifierLag,
    TransportDelay,
    RateDependence,
    RateLaw,
    Congruency,
    Asymmetry,
    Quadratic,
    Cubic,
    Backlash,
    Resonance,
    Creep,
    Interleaving,
    SensorLag,
    Drift,
    MainsHum,
    Quantisation,
}

use Effect::*;

/// Sets of effects of which a random draw takes one at most: no ordinary record tells them apart
/// once they overlap.
const ALIKE: [&[Effect]; 3] = [
    &[AmplifierLag, TransportDelay, SensorLag],
    &[Quadratic, Interleaving],
    &[Saturation, SlewLimit],
];

impl Effect {
    /// All effects in the order of the signal chain.
    pub const ALL: [Self; 18] = [
        Saturation,
        SlewLimit,
        AmplifierLag,
        TransportDelay,
        RateDependence,
        RateLaw,
        Congruency,
        Asymmetry,
        Quadratic,
        Cubic,
        Backlash,
        Resonance,
        Creep,
        Interleaving,
        SensorLag,
        Drift,
        MainsHum,
        Quantisation,
    ];

    /// Most effects that a random draw can take together.
    pub const MOST_TOGETHER: usize = 13;

    /// The name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Saturation => "saturation",
            SlewLimit => "slew-limit",
            AmplifierLag => "amplifier-lag",
            TransportDelay => "transport-delay",
            RateDependence => "rate-dependence",
            RateLaw => "rate-law",
            Congruency => "congruency",
            Asymmetry => "asymmetry",
            Quadratic => "quadratic",
            Cubic => "cubic",
            Backlash => "backlash",
            Resonance => "resonance",
            Creep => "creep",
            Interleaving => "interleaving",
            SensorLag => "sensor-lag",
            Drift => "drift",
            MainsHum => "mains-hum",
            Quantisation => "quantisation",
        }
    }

    fn alike(self, other: Self) -> bool {
        self == other
            || ALIKE
                .iter()
                .any(|set| set.contains(&self) && set.contains(&other))
    }
}

impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Effect {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        Self::ALL
            .into_iter()
            .find(|effect| effect.name() == text)
            .ok_or_else(|| {
                let names = Self::ALL.map(Self::name).join(", ");
                Error::request(format!(
                    "{} is no effect; name none, random, random,N or any of {names}",
                    quoted(text)
                ))
            })
    }
}

/// Which effects to hide.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Choice {
    /// These, none where the list is empty.
    Named(Vec<Effect>),
    /// As many, drawn by the seed from all but `rate-dependence`, which the usual baseline has
    /// already; no two that ordinary records cannot tell apart.
    Random(usize),
}

impl Choice {
    /// The effects in the order of the chain.
    ///
    /// # Errors
    /// An effect named twice, `rate-law` together with `rate-dependence`, more than
    /// [`Effect::MOST_TOGETHER`] at random.
    pub fn effects(&self, seed: u64) -> Result<Vec<Effect>, Error> {
        let mut effects = match self {
            Self::Named(effects) => effects.clone(),
            Self::Random(count) => draw(*count, seed)?,
        };
        effects.sort();
        if let Some(twice) = effects.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(Error::request(format!(
                "{} is named twice; name it once",
                twice[0]
            )));
        }
        if effects.contains(&RateLaw) && effects.contains(&RateDependence) {
            return Err(Error::request(
                "rate-law changes the rate term that rate-dependence adds; hide one of the two",
            ));
        }
        Ok(effects)
    }
}

fn draw(count: usize, seed: u64) -> Result<Vec<Effect>, Error> {
    if count > Effect::MOST_TOGETHER {
        return Err(Error::request(format!(
            "{count} effects cannot be hidden together; ask for {} at most",
            Effect::MOST_TOGETHER
        )));
    }
    let mut random = Draw::new(seed, Stream::Choice, 0);
    let mut left: Vec<_> = Effect::ALL
        .into_iter()
        .filter(|&effect| effect != RateDependence)
        .collect();
    let mut drawn = Vec::with_capacity(count);
    while drawn.len() < count {
        let one = left[random.whole(0, left.len() - 1)];
        left.retain(|other| !one.alike(*other));
        drawn.push(one);
    }
    Ok(drawn)
}

impl FromStr for Choice {
    type Err = Error;

    /// `none`, `random`, `random,N` or names joined by commas.
    fn from_str(text: &str) -> Result<Self, Error> {
        let parts: Vec<_> = text.split(',').map(str::trim).collect();
        match parts.as_slice() {
            ["none"] => Ok(Self::Named(Vec::new())),
            ["random"] => Ok(Self::Random(1)),
            ["random", count] => match count.parse() {
                Ok(count @ 1..) => Ok(Self::Random(count)),
                _ => Err(Error::request(format!(
                    "{} is no number of effects; write random,N with N from 1 to {}",
                    quoted(count),
                    Effect::MOST_TOGETHER
                ))),
            },
            names => Ok(Self::Named(
                names
                    .iter()
                    .map(|name| name.parse())
                    .collect::<Result<_, _>>()?,
            )),
        }
    }
}
