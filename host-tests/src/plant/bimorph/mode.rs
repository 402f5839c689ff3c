//! What lies between the relays and the sensor: one bending mode and a bend that favours one side.

use nalgebra::{Matrix4, Vector2};

use crate::plant::amplifier::Amplifier;
use crate::plant::error::{StageError, require};

/// A bending mode, `x'' + 2 zeta w x' + w^2 x = w^2 v`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// Frequency w / 2 pi of the undamped mode, Hz.
    pub frequency_hz: f64,
    /// Damping ratio zeta.
    pub damping: f64,
}

impl Mode {
    /// Checks both values.
    ///
    /// # Errors
    /// [`StageError::Parameter`] with the field's name.
    pub fn validate(&self) -> Result<(), StageError> {
        require(
            self.frequency_hz > 0.0 && self.frequency_hz <= 1e6,
            "mode.frequency_hz",
            self.frequency_hz,
            "must be above 0 and at most 1e6 Hz",
        )?;
        require(
            self.damping > 0.0 && self.damping <= 10.0,
            "mode.damping",
            self.damping,
            "must be above 0 and at most 10",
        )
    }
}

/// The mode in steps, exact for an input that is linear over a step.
#[derive(Debug, Clone)]
pub(in crate::plant) struct Vibration {
    /// What one step makes of (x, x' / w, input, slope of the input times the step).
    step: Matrix4<f64>,
    /// (x, x' / w), um.
    state: Vector2<f64>,
    input_um: f64,
}

impl Vibration {
    /// The mode at rest at 0 um.
    pub(in crate::plant) fn new(mode: Mode, step_s: f64) -> Self {
        let turn = std::f64::consts::TAU * mode.frequency_hz * step_s;
        let damp = 2.0 * mode.damping * turn;
        #[rustfmt::skip]
        let rates = Matrix4::new(
            0.0,   turn,  0.0,  0.0,
            -turn, -damp, turn, 0.0,
            0.0,   0.0,   0.0,  1.0,
            0.0,   0.0,   0.0,  0.0,
        );
        Self {
            step: rates.exp(),
            state: Vector2::zeros(),
            input_um: 0.0,
        }
    }

    /// Advances one step while the input goes in a straight line to `input_um`; returns x, um.
    pub(in crate::plant) fn advance(&mut self, input_um: f64) -> f64 {
        let (from, slope) = (self.input_um, input_um - self.input_um);
        self.state = self.step.fixed_view::<2, 2>(0, 0) * self.state
            + self.step.fixed_view::<2, 2>(0, 2) * Vector2::new(from, slope);
        self.input_um = input_um;
        self.state.x
    }
}

/// The even nonlinearity: a bend reads larger to one side than to the other, by
/// `share (sqrt(x^2 + knee^2) - knee)` behind a first-order lag, as of a clamp that yields to one
/// side and takes its time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asymmetry {
    /// By how much the slopes far to either side differ from their mean, relative.
    pub share: f64,
    /// Where the slope turns from one to the other, um.
    pub knee_um: f64,
    /// Time constant of the lag, s.
    pub relaxation_s: f64,
}

impl Asymmetry {
    /// Checks all values.
    ///
    /// # Errors
    /// [`StageError::Parameter`] with the field's name.
    pub fn validate(&self) -> Result<(), StageError> {
        require(
            self.share.abs() < 1.0,
            "asymmetry.share",
            self.share,
            "must be within +-1",
        )?;
        require(
            (0.0..=1e6).contains(&self.knee_um),
            "asymmetry.knee_um",
            self.knee_um,
            "must be 0 to 1e6 um",
        )?;
        require(
            (0.0..=1e3).contains(&self.relaxation_s),
            "asymmetry.relaxation_s",
            self.relaxation_s,
            "must be 0 to 1000 s",
        )
    }
}

/// The asymmetry in steps.
#[derive(Debug, Clone)]
pub(super) struct Bend {
    asymmetry: Asymmetry,
    lag: Amplifier,
    even_um: f64,
}

impl Bend {
    pub(super) fn new(asymmetry: Asymmetry, step_s: f64) -> Self {
        Self {
            asymmetry,
            lag: Amplifier::new(asymmetry.relaxation_s, step_s, 0.0),
            even_um: 0.0,
        }
    }

    /// Advances one step that ends with the mode at `x_um`; returns the bend there, um.
    pub(super) fn advance(&mut self, x_um: f64) -> f64 {
        let Asymmetry { share, knee_um, .. } = self.asymmetry;
        let even_um = share * (x_um.hypot(knee_um) - knee_um);
        let lagged = self.lag.advance(self.even_um, even_um);
        self.even_um = even_um;
        x_um + lagged
    }
}
