//! Digital-to-analogue converter.

use super::error::{StageError, require};

/// A uniform converter between codes `0..2^bits` and volts at the actuator.
///
/// The amplifier's gain is taken as part of the range, so both ends are volts at the actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dac {
    /// Resolution, 1 to 32 bits.
    pub bits: u32,
    /// Output at code 0, V.
    pub min_v: f64,
    /// Output at the highest code, V.
    pub max_v: f64,
}

impl Dac {
    /// Checks resolution and range.
    ///
    /// # Errors
    /// [`StageError::Parameter`] with the field's name.
    pub fn validate(&self) -> Result<(), StageError> {
        require(
            (1..=32).contains(&self.bits),
            "dac.bits",
            f64::from(self.bits),
            "must be 1 to 32",
        )?;
        require(
            self.min_v.abs() <= 1e6,
            "dac.min_v",
            self.min_v,
            "must be within +-1e6 V",
        )?;
        require(
            self.max_v <= 1e6 && self.max_v > self.min_v,
            "dac.max_v",
            self.max_v,
            "must be above dac.min_v and at most 1e6 V",
        )
    }

    /// The highest code.
    fn top(&self) -> u32 {
        u32::MAX >> (32 - self.bits)
    }

    /// Step from one code to the next, V.
    pub fn lsb_v(&self) -> f64 {
        (self.max_v - self.min_v) / f64::from(self.top())
    }

    /// The code nearest to a voltage; beyond the range, the end of the range.
    pub fn code(&self, drive_v: f64) -> u32 {
        let code = ((drive_v - self.min_v) / self.lsb_v()).round();
        // The cast saturates at zero and at u32::MAX.
        (code as u32).min(self.top())
    }

    /// Output at a code, V; codes above the highest saturate.
    pub fn volts(&self, code: u32) -> f64 {
        self.min_v + self.lsb_v() * f64::from(code.min(self.top()))
    }

    /// What the converter puts out when this voltage is asked for, V.
    pub fn quantise(&self, drive_v: f64) -> f64 {
        self.volts(self.code(drive_v))
    }
}
