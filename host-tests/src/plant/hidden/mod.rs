//! Hidden data: a stage with a chosen effect that a diagnosis has to find, and the truth about it.
//!
//! Nothing here comes from the core crate or from the fits. `docs/hidden-data.md` states the tiers, the
//! strength, the records and the law of every effect.
//!
//! ```
//! use hysteron_host::plant::hidden::{Choice, Effect, HiddenCase};
//!
//! let case = HiddenCase {
//!     choice: Choice::Named(vec![Effect::Creep]),
//!     seed: 7,
//!     ..HiddenCase::default()
//! };
//! let hidden = case.make()?;
//! assert_eq!(hidden.truth.effects, ["creep"]);
//! let displacement_um = hidden.plant.run(&[0.0, 0.1, 0.2], 1e-3);
//! assert_eq!(displacement_um.len(), 3);
//! # Ok::<(), hysteron_host::error::Error>(())
//! ```

mod case;
mod chain;
mod core;
mod draw;
mod effect;
mod law;
mod parts;
mod protocol;
mod session;
mod setup;
mod shape;
mod truth;

pub use case::{Hidden, HiddenCase};
pub use chain::HiddenPlant;
pub use core::{Core, Family};
pub use effect::{Choice, Effect};
pub use law::Law;
pub use protocol::Protocol;
pub use setup::{Baseline, Setup};
pub use truth::{EffectTruth, Roles, StageTruth, Truth};

use crate::error::Error;

/// How far the truth is from a model of plays at the record's own rate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tier {
    /// Tier 1: the same structure, at the record's own rate.
    #[default]
    Same,
    /// Tier 2: the same structure, computed 8 times finer.
    Finer,
    /// Tier 3: twelve irregular plays, 8 times finer, coloured noise.
    Irregular,
    /// Tier 4: relays or Bouc and Wen's equation, other laws of creep, drift and contact, a mode by
    /// Runge and Kutta's method, coloured noise.
    Other,
}

impl Tier {
    /// 1 to 4.
    pub fn number(self) -> u8 {
        match self {
            Self::Same => 1,
            Self::Finer => 2,
            Self::Irregular => 3,
            Self::Other => 4,
        }
    }

    fn coloured(self) -> bool {
        matches!(self, Self::Irregular | Self::Other)
    }
}

impl TryFrom<u8> for Tier {
    type Error = Error;

    fn try_from(number: u8) -> Result<Self, Error> {
        [Self::Same, Self::Finer, Self::Irregular, Self::Other]
            .into_iter()
            .find(|tier| tier.number() == number)
            .ok_or_else(|| Error::request(format!("there is no tier {number}; name 1 to 4")))
    }
}
