//! A model on its way to the target: the stages of a `model.toml` in single precision.
//!
//! The stages are a list in the order of the signal, drive to displacement, so that a new effect is a
//! new kind of [`Stage`] and needs no new message. A record is judged whole by
//! [`ModelRecord::compensator`]; nothing of a bad one comes into force.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::compensator::Compensator;
use crate::dim::{self, Dim, Law};
use crate::effect::asymmetry::{Asymmetry, Side};
use crate::error::{ParameterError, SampleError};
use crate::hysteresis::modified_play::{
    BasisParameters, Harmonics, LinearPlane, ModifiedPlay, Terms,
};
use crate::hysteresis::{self, Parameters};
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

/// How far the sample time of a modified play model may be from that of the settings, over it.
pub const SAMPLE_TIME_TOLERANCE: f32 = 1e-4;

/// A compensator of the target and its state.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub enum TargetCompensator {
    /// Inverses of the stages in reverse order.
    Inverse(
        Compensator<f32, PLAYS, DEAD_ZONES>,
        hysteresis::State<f32, PLAYS>,
    ),
    /// Direct inverse multiplication.
    Dim(
        Dim<f32, PLAYS, LinearPlane<f32, PLAYS>>,
        dim::State<f32, PLAYS>,
    ),
}

impl TargetCompensator {
    /// Drive (V) for the next reference sample (um), `at_rest` as if the reference had stood there
    /// before.
    ///
    /// # Errors
    /// A reference that is turned away; the state is unchanged.
    #[inline(always)]
    pub fn step_from(&mut self, reference: f32, at_rest: bool) -> Result<f32, SampleError> {
        match self {
            Self::Inverse(compensator, state) => compensator.step_from(state, reference, at_rest),
            Self::Dim(dim, state) => dim.step_from(state, reference, at_rest),
        }
    }

    /// A reference begins with the next sample: so does the angle of harmonic terms.
    #[inline(always)]
    pub fn begin(&mut self) {
        if let Self::Dim(dim, state) = self {
            dim.reset_angle(state);
        }
    }
}

/// A model as an ordered list of stages.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelRecord {
    /// `hysteresis`, then `asymmetry` and `output` where there are any; or `modified-play` alone.
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
    /// The modified play model with all its terms: a whole model, drive to displacement.
    ModifiedPlay {
        /// Largest drive of the plane in V.
        u_max_v: f32,
        /// `2A` and the slopes of the plays `1..N-1`, in um/V.
        slopes_um_per_v: Vec<f32, PLAYS>,
        /// Offset of the plane in um.
        offset_um: f32,
        /// `alpha` in s.
        alpha_s: f32,
        /// `beta` in s.
        beta_s: f32,
        /// `g` in 1/V.
        interleaving_per_v: f32,
        /// `c_1..c_3`.
        feedback: [f32; 3],
        /// Frequency of the harmonic terms in Hz.
        frequency_hz: f32,
        /// Their form.
        harmonics: Harmonics,
        /// `A_11`, `A_31`, `A_51`.
        sine: [f32; 3],
        /// `A_12`, `A_32`, `A_52`.
        cosine: [f32; 3],
        /// Time between the samples that the model was identified with, in s.
        sample_time_s: f32,
        /// How it is inverted.
        law: Law,
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
    /// A modified play model was identified at another sample time than that of the settings.
    SampleTime,
}

impl From<ParameterError> for RecordError {
    fn from(error: ParameterError) -> Self {
        Self::Parameter(error)
    }
}

impl ModelRecord {
    /// The compensator for samples that are `sample_time` seconds apart, at rest.
    ///
    /// # Errors
    /// See [`RecordError`].
    pub fn compensator(&self, sample_time: f32) -> Result<TargetCompensator, RecordError> {
        let mut place = None;
        self.put_compensator(sample_time, &mut place)?;
        place.ok_or(RecordError::Order(0))
    }

    /// As [`ModelRecord::compensator`], right into its place: it takes a good part of the target's
    /// stack.
    ///
    /// # Errors
    /// See [`RecordError`]; the place is as it was.
    pub fn put_compensator(
        &self,
        sample_time: f32,
        place: &mut Option<TargetCompensator>,
    ) -> Result<(), RecordError> {
        match self.stages.split_first() {
            Some((Stage::ModifiedPlay { .. }, [_, ..])) => Err(RecordError::Order(1)),
            Some((stage @ Stage::ModifiedPlay { .. }, [])) => stage.put_dim(sample_time, place),
            _ => self.put_inverse(sample_time, place),
        }
    }

    // Neither this nor its counterpart is inlined: their frames would add up.
    #[inline(never)]
    fn put_inverse(
        &self,
        sample_time: f32,
        place: &mut Option<TargetCompensator>,
    ) -> Result<(), RecordError> {
        let compensator = self.model(sample_time)?.compensator()?;
        // The first step takes the plays from zero to its sample.
        let state = compensator.hysteresis().start(0.0);
        *place = Some(TargetCompensator::Inverse(compensator, state));
        Ok(())
    }

    fn model(&self, sample_time: f32) -> Result<Model<f32, PLAYS, DEAD_ZONES>, RecordError> {
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

impl Stage {
    /// The compensator of a modified play model.
    #[inline(never)]
    fn put_dim(
        &self,
        sample_time: f32,
        place: &mut Option<TargetCompensator>,
    ) -> Result<(), RecordError> {
        let Self::ModifiedPlay {
            u_max_v,
            ref slopes_um_per_v,
            offset_um,
            alpha_s,
            beta_s,
            interleaving_per_v,
            feedback,
            frequency_hz,
            harmonics,
            sine,
            cosine,
            sample_time_s,
            law,
        } = *self
        else {
            return Err(RecordError::Order(0));
        };
        let apart = (sample_time_s - sample_time).abs();
        // A NaN is no match either.
        let matches = apart <= SAMPLE_TIME_TOLERANCE * sample_time;
        if !matches {
            return Err(RecordError::SampleTime);
        }
        let basis = BasisParameters {
            u_max: u_max_v,
            divisions: slopes_um_per_v.len(),
            alpha: alpha_s,
            beta: beta_s,
            harmonics,
            frequency: frequency_hz,
        }
        .build(sample_time)?;
        let plane = LinearPlane::new(basis.grid(), slopes_um_per_v, offset_um)?;
        let terms = Terms {
            interleaving: interleaving_per_v,
            feedback,
            sine,
            cosine,
        };
        let model = ModifiedPlay::new(&basis, plane, terms)?;
        let dim = match law {
            Law::Printed => Dim::printed(model)?,
            Law::Exact => Dim::exact(model)?,
        };
        let state = dim.start();
        *place = Some(TargetCompensator::Dim(dim, state));
        Ok(())
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
