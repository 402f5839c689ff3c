//! A model on its way to the target: the stages of a `model.toml` in single precision.
//!
//! The stages are a list in the order of the signal, drive to displacement, so that a new effect is a
//! new kind of [`Stage`] and needs no new message. A record is judged whole by
//! [`ModelRecord::build`]; nothing of a bad one comes into force.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::compensator::Compensator;
use crate::effect::asymmetry::{Asymmetry, Side};
use crate::error::ParameterError;
use crate::hysteresis::Parameters;
use crate::model::Model;

/// Plays that the target has room for.
pub const PLAYS: usize = 16;
/// Weights: one more than plays.
pub const WEIGHTS: usize = PLAYS + 1;
/// Dead zones on each side of the asymmetry map that the target has room for.
pub const DEAD_ZONES: usize = 4;
/// Slopes on each side: one more than dead zones.
pub const SLOPES: usize = DEAD_ZONES + 1;
/// Stages that a record has room for.
pub const STAGES: usize = 4;

/// The model of the target.
pub type TargetModel = Model<f32, PLAYS, DEAD_ZONES>;
/// The compensator of the target.
pub type TargetCompensator = Compensator<f32, PLAYS, DEAD_ZONES>;

/// A model as an ordered list of stages.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelRecord {
    /// `hysteresis`, then `asymmetry` and `output` where there are any.
    pub stages: Vec<Stage, STAGES>,
}

/// One stage; names and keys as in `model.toml`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub enum Stage {
    /// The rate-dependent Prandtl-Ishlinskii operator.
    Hysteresis {
        /// `alpha_1..alpha_n` in V.
        thresholds_v: Vec<f32, PLAYS>,
        /// `a_0..a_n`.
        weights: Vec<f32, WEIGHTS>,
        /// `beta` in s.
        beta_s: f32,
    },
    /// The map of one-sided dead zones.
    Asymmetry {
        /// For arguments `>= 0`.
        positive: Zones,
        /// For arguments `< 0`.
        negative: Zones,
    },
    /// What turns volts into micrometres; gain 1 and offset 0 without it.
    Output {
        /// Gain in um/V.
        gain_um_per_v: f32,
        /// Displacement at rest in um.
        offset_um: f32,
    },
}

/// One side of the asymmetry map.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Zones {
    /// `rho_1..rho_m`.
    pub thresholds: Vec<f32, DEAD_ZONES>,
    /// `g_0..g_m`.
    pub slopes: Vec<f32, SLOPES>,
}

/// Why a record is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RecordError {
    /// A stage is missing, comes twice or in the wrong place; its index from zero.
    Order(u8),
    /// A parameter is wrong.
    Parameter(ParameterError),
}

impl From<ParameterError> for RecordError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl ModelRecord {
    /// The model for samples that are `sample_time` seconds apart.
    ///
    /// # Errors
    /// See [`RecordError`].
    pub fn build(&self, sample_time: f32) -> Result<TargetModel, RecordError> {
        let mut stages = self.stages.iter().peekable();
        let Some(Stage::Hysteresis {
            thresholds_v,
            weights,
            beta_s,
        }) = stages.next()
        else {
            return Err(RecordError::Order(0));
        };
        let mut index = 1;
        let mut asymmetry = None;
        if let Some(Stage::Asymmetry { positive, negative }) =
            stages.next_if(|stage| matches!(stage, Stage::Asymmetry { .. }))
        {
            asymmetry = Some(Asymmetry::new(positive.side(), negative.side())?);
            index += 1;
        }
        let (mut gain, mut offset) = (1.0, 0.0);
        if let Some(&Stage::Output {
            gain_um_per_v,
            offset_um,
        }) = stages.next_if(|stage| matches!(stage, Stage::Output { .. }))
        {
            (gain, offset) = (gain_um_per_v, offset_um);
            index += 1;
        }
        if stages.next().is_some() {
            return Err(RecordError::Order(index));
        }
        let hysteresis = Parameters {
            weights,
            thresholds: thresholds_v,
            beta: *beta_s,
        };
        Ok(Model::new(
            hysteresis.build(sample_time)?,
            asymmetry,
            gain,
            offset,
        )?)
    }
}

impl Zones {
    fn side(&self) -> Side<'_, f32> {
        Side {
            slopes: &self.slopes,
            thresholds: &self.thresholds,
        }
    }
}
