//! Codes of the analog-to-digital converter that reads the displacement sensor.

/// Largest code of the converter: 12 bit.
pub const MAX_CODE: u16 = 4095;

/// Volts a code at a reference of 3.3 V.
pub const V_PER_CODE: f32 = 3.3 / 4096.0;

/// Straight line from sensor volts to displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    um_per_code: f32,
    offset_um: f32,
}

impl Scale {
    /// `displacement = um_per_v x sensor voltage + offset_um`; `um_per_v` of either sign.
    ///
    /// `None` when it is zero or something is not finite.
    pub fn new(um_per_v: f32, offset_um: f32) -> Option<Self> {
        let um_per_code = um_per_v * V_PER_CODE;
        (um_per_code.is_normal() && offset_um.is_finite()).then_some(Self {
            um_per_code,
            offset_um,
        })
    }

    /// Displacement in um.
    pub fn displacement(&self, code: u16) -> f32 {
        f32::from(code) * self.um_per_code + self.offset_um
    }

    /// The code nearest to a displacement in um, at the ends where it is out of range: what an ideal
    /// sensor and converter would read.
    pub fn code(&self, displacement: f32) -> u16 {
        // The cast saturates and takes NaN to zero.
        let code = ((displacement - self.offset_um) / self.um_per_code + 0.5) as u16;
        code.min(MAX_CODE)
    }
}
