//! What stands between a computed drive and the amplifier.
//!
//! Whatever the target does, the output stays in its range and moves no faster than its slew limit.
//! A target that is not finite is a fault; one that stays away is waited for, then the output ramps
//! to rest. A new target is joined without a jump: the distance between it and the present output is
//! carried as a bias that fades at the ramp rate, which is also the soft start.
//!
//! ```text
//! Off   --run, hold-->  Run, Hold         the output leaves from where it stands
//! Run   --no target for longer than stale-->  Off
//! any   --off-->  Off                     ramps to rest, then the driver may be disabled
//! any   --fault-->  Fault  --clear-->  Off    ramps to rest; only clear leaves it
//! ```
//!
//! A step has no division, no panic and a bounded number of instructions.

use serde::{Deserialize, Serialize};

/// What the output does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum State {
    /// At rest or ramping there.
    Off,
    /// Standing still.
    Hold,
    /// Following the target.
    Run,
    /// As [`State::Off`], until the fault is cleared.
    Fault,
}

/// Why the output went to [`State::Fault`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Cause {
    /// A target was infinite or NaN.
    NotFinite,
    /// More samples came too late than the settings allow.
    Deadline,
    /// A compensated reference was to be followed without a model.
    NoModel,
}

/// Limits of the output, in volts of drive and samples; all of them validated by
/// [`crate::settings::Settings::validate`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Lowest drive in V.
    pub lowest: f32,
    /// Highest drive in V.
    pub highest: f32,
    /// Drive at rest in V, within the range.
    pub rest: f32,
    /// Largest step in V a sample.
    pub slew: f32,
    /// Step of a ramp in V a sample.
    pub ramp: f32,
    /// Samples that a target may stay away before the output ramps to rest.
    pub stale: u32,
}

/// State of the output and what happened to it.
#[derive(Clone, Copy, Debug)]
pub struct Safety {
    state: State,
    cause: Option<Cause>,
    output: f32,
    bias: f32,
    /// The next target starts a new motion and is to be joined.
    join: bool,
    missing: u32,
    underruns: u32,
    limited: u32,
}

/// `from` moved towards `to` by at most `step`; never past it.
#[inline(always)]
fn towards(from: f32, to: f32, step: f32) -> f32 {
    let (up, down) = (from + step, from - step);
    if to > up {
        up
    } else if to < down {
        down
    } else {
        to
    }
}

impl Safety {
    /// Off, at rest.
    pub fn new(limits: &Limits) -> Self {
        Self {
            state: State::Off,
            cause: None,
            output: limits.rest,
            bias: 0.0,
            join: true,
            missing: 0,
            underruns: 0,
            limited: 0,
        }
    }

    /// Puts the output to rest at once: for new limits while the driver is disabled.
    pub fn reset_output(&mut self, limits: &Limits) {
        self.output = limits.rest;
        self.bias = 0.0;
    }

    /// Follows the target, which is joined from the present output. Without effect in a fault.
    pub fn run(&mut self) {
        if self.state != State::Fault {
            self.state = State::Run;
            self.join = true;
            self.missing = 0;
        }
    }

    /// Stands still. Without effect in a fault.
    pub fn hold(&mut self) {
        if self.state != State::Fault {
            self.state = State::Hold;
        }
    }

    /// Ramps to rest. Without effect in a fault, which ramps there already.
    pub fn off(&mut self) {
        if self.state != State::Fault {
            self.state = State::Off;
        }
    }

    /// Ramps to rest and stays there until [`Safety::clear`]; the first cause is kept.
    pub fn fault(&mut self, cause: Cause) {
        if self.state != State::Fault {
            self.state = State::Fault;
            self.cause = Some(cause);
        }
    }

    /// Leaves a fault for [`State::Off`].
    pub fn clear(&mut self) {
        if self.state == State::Fault {
            self.state = State::Off;
            self.cause = None;
        }
    }

    /// The next target comes from elsewhere, say from another model: it is joined without a jump.
    pub fn join(&mut self) {
        self.join = true;
    }

    /// Whether the next target starts a new motion and will be joined.
    #[inline(always)]
    pub fn joins(&self) -> bool {
        self.join
    }

    /// The drive to put out, in V, for the target of this sample, `None` if it did not come in time.
    /// The target counts in [`State::Run`] only.
    #[inline(always)]
    pub fn step(&mut self, limits: &Limits, target: Option<f32>) -> f32 {
        match (self.state, target) {
            (State::Run, Some(target)) => self.follow(limits, target),
            _ => self.stay(limits),
        }
        self.output
    }

    /// [`Safety::step`] without a target.
    #[inline(always)]
    pub(crate) fn stay(&mut self, limits: &Limits) {
        match self.state {
            State::Run => self.wait(limits),
            State::Hold => {}
            State::Off | State::Fault => {
                self.output = towards(self.output, limits.rest, limits.ramp);
            }
        }
    }

    /// [`Safety::step`] with a target in [`State::Run`].
    #[inline(always)]
    pub(crate) fn follow(&mut self, limits: &Limits, target: f32) {
        self.missing = 0;
        if self.join {
            self.join = false;
            self.bias = self.output - target;
        } else if self.bias != 0.0 {
            self.bias = towards(self.bias, 0.0, limits.ramp);
        }
        let wanted = target + self.bias;
        if !wanted.is_finite() {
            // The output keeps its last good value in this sample and ramps from there.
            self.fault(Cause::NotFinite);
            return;
        }
        let within = if wanted > limits.highest {
            limits.highest
        } else if wanted < limits.lowest {
            limits.lowest
        } else {
            wanted
        };
        self.output = towards(self.output, within, limits.slew);
        if self.output != wanted {
            self.limited = self.limited.wrapping_add(1);
        }
    }

    #[inline(always)]
    fn wait(&mut self, limits: &Limits) {
        if self.missing == 0 {
            self.underruns = self.underruns.wrapping_add(1);
        }
        self.join = true;
        if self.missing >= limits.stale {
            self.state = State::Off;
        } else {
            self.missing += 1;
        }
    }

    /// What the output does.
    #[inline(always)]
    pub fn state(&self) -> State {
        self.state
    }

    /// Why it is in a fault.
    #[inline(always)]
    pub fn cause(&self) -> Option<Cause> {
        self.cause
    }

    /// The drive that was put out last, in V.
    #[inline(always)]
    pub fn output(&self) -> f32 {
        self.output
    }

    /// Whether the amplifier is to be driven: not when the output is off and has come to rest.
    #[inline(always)]
    pub fn driver_enabled(&self, limits: &Limits) -> bool {
        matches!(self.state, State::Run | State::Hold) || self.output != limits.rest
    }

    /// How often the target began to stay away; wraps.
    #[inline(always)]
    pub fn underruns(&self) -> u32 {
        self.underruns
    }

    /// Samples in which range or slew held the output back; wraps.
    #[inline(always)]
    pub fn limited(&self) -> u32 {
        self.limited
    }
}
