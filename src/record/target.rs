//! The compensators of the target, one at a time in force.

use super::{DEAD_ZONES, PLAYS, WINDOW};
use crate::cascade::{Cascade, CascadeState};
use crate::compensator::Compensator;
use crate::dim::{self, Dim};
use crate::error::SampleError;
use crate::hysteresis::modified_play::LinearPlane;
use crate::hysteresis::{self, RateDependentPi};

/// A compensator of the target and its state.
#[derive(Clone, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub enum TargetCompensator {
    /// The explicit inverse.
    Inverse(Parts<Compensator<f32, PLAYS, DEAD_ZONES>, hysteresis::State<f32, PLAYS>>),
    /// Direct inverse multiplication.
    Dim(Parts<Dim<f32, PLAYS, LinearPlane<f32, PLAYS>>, dim::State<f32, PLAYS>>),
    /// What looks ahead: the preview inverse alone, or among the inverses of effects.
    Ahead(Ahead),
}

/// What is built once, and what a sample changes.
#[derive(Clone, Debug)]
pub struct Parts<C, S> {
    pub(super) compensator: C,
    pub(super) state: S,
}

/// A cascade that fits the target.
pub type Ahead = Parts<Cascade<f32, PLAYS, DEAD_ZONES, WINDOW>, CascadeState<f32, PLAYS, WINDOW>>;

/// How a sample of the reference follows the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// A sample time after it.
    Goes,
    /// After a pause.
    Resumes,
    /// Not at all: the reference has rested at this sample until now.
    Begins,
}

impl TargetCompensator {
    /// Samples between a reference sample going in and its drive coming out.
    pub fn latency(&self) -> usize {
        match self {
            Self::Inverse(_) | Self::Dim(_) => 0,
            Self::Ahead(ahead) => ahead.compensator.latency(),
        }
    }

    /// Drive (V) of the reference sample that came [`TargetCompensator::latency`] samples ago, for the
    /// next one (um).
    ///
    /// # Errors
    /// A reference that is turned away; the state is unchanged.
    #[inline(always)]
    pub fn step(&mut self, reference: f32, motion: Motion) -> Result<f32, SampleError> {
        // The rate of a sample that follows none is unknown and taken as zero.
        let at_rest = motion != Motion::Goes;
        match self {
            Self::Inverse(Parts { compensator, state }) => {
                compensator.step_from(state, reference, at_rest)
            }
            Self::Dim(Parts { compensator, state }) => {
                compensator.step_from(state, reference, at_rest)
            }
            Self::Ahead(ahead) => ahead.step(reference, motion),
        }
    }

    /// A reference begins with the next sample: so does the angle of harmonic terms.
    #[inline(always)]
    pub fn begin(&mut self) {
        if let Self::Dim(Parts { compensator, state }) = self {
            compensator.reset_angle(state);
        }
    }

    /// Takes the plays over from the compensator before, in mid-motion, if both invert the same
    /// hysteresis; `last` is the reference (um) of the latest drive. Tells how the motion follows.
    #[inline(never)]
    pub(crate) fn take_over(&mut self, before: &mut Self, last: f32) -> Motion {
        let same = match (self.inverse(), before.inverse()) {
            (Some(after), Some(before)) => {
                let (after, before) = (after.bank(), before.bank());
                after.thresholds() == before.thresholds() && after.weights() == before.weights()
            }
            _ => false,
        };
        if !same {
            return Motion::Begins;
        }
        match (self, before) {
            (Self::Inverse(after), before) => {
                match before {
                    Self::Inverse(before) => after.state = before.state,
                    before => {
                        if let Some(state) = before.started(after.compensator.hysteresis()) {
                            after.state = state;
                        }
                    }
                }
                match after.compensator.rest_at(&mut after.state, last) {
                    Ok(()) => Motion::Goes,
                    Err(_) => Motion::Begins,
                }
            }
            (Self::Ahead(after), before) => {
                let plays = before.plays();
                let len = after.compensator.inverse().bank().len();
                if let Some(outputs) = plays.as_ref().and_then(|plays| plays.get(..len)) {
                    // Plays that rounding made inadmissible begin at zero, as those of a new model.
                    let _ = after.compensator.put_plays(&mut after.state, outputs);
                }
                Motion::Begins
            }
            (Self::Dim(_), _) => Motion::Begins,
        }
    }

    /// The inverse hysteresis operator.
    fn inverse(&self) -> Option<&RateDependentPi<f32, PLAYS>> {
        match self {
            Self::Inverse(parts) => Some(parts.compensator.hysteresis()),
            Self::Ahead(ahead) => Some(ahead.compensator.inverse()),
            Self::Dim(_) => None,
        }
    }

    /// Outputs of its plays at the latest drive.
    fn plays(&mut self) -> Option<[f32; PLAYS]> {
        match self {
            Self::Inverse(Parts { compensator, state }) => {
                Some(state.plays().outputs(compensator.hysteresis().bank()))
            }
            Self::Ahead(Parts { compensator, state }) => Some(compensator.plays(state)),
            Self::Dim(_) => None,
        }
    }

    /// The state of the explicit `inverse` with the plays of this compensator.
    fn started(
        &mut self,
        inverse: &RateDependentPi<f32, PLAYS>,
    ) -> Option<hysteresis::State<f32, PLAYS>> {
        let plays = self.plays()?;
        let outputs = plays.get(..inverse.bank().len())?;
        inverse.start_from(0.0, outputs).ok()
    }
}

impl Ahead {
    pub(super) fn new(
        compensator: Cascade<f32, PLAYS, DEAD_ZONES, WINDOW>,
        state: CascadeState<f32, PLAYS, WINDOW>,
    ) -> Self {
        Self { compensator, state }
    }

    // Not inlined: the explicit inverse keeps its registers.
    #[inline(never)]
    fn step(&mut self, reference: f32, motion: Motion) -> Result<f32, SampleError> {
        let Self { compensator, state } = self;
        match motion {
            // What it has looked at still holds after a pause.
            Motion::Goes | Motion::Resumes => compensator.step(state, reference),
            Motion::Begins => compensator.rest_at(state, reference),
        }
    }
}
