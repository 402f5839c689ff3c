//! From volts of drive to codes of a digital-to-analog converter.
//!
//! ```text
//! drive = amplifier gain x converter output + amplifier offset
//! ```
//!
//! The internal converter needs no part; an AD5761R has the +-5 V that piezo amplifiers expect.

use embedded_hal::spi::SpiDevice;
use serde::{Deserialize, Serialize};

/// A kind of converter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kind {
    /// The microcontroller's own: 12 bit, 0 V to 3.3 V.
    Internal12,
    /// AD5761R and its kin at +-5 V: 16 bit straight binary.
    Bipolar16,
}

impl Kind {
    /// Largest code.
    pub const fn max_code(self) -> u16 {
        match self {
            Self::Internal12 => 4095,
            Self::Bipolar16 => u16::MAX,
        }
    }

    /// Output at code zero in V, and volts a code.
    pub const fn scale(self) -> (f32, f32) {
        match self {
            // The buffered output does not quite reach its rails; see docs/hardware.md.
            Self::Internal12 => (0.0, 3.3 / 4096.0),
            Self::Bipolar16 => (-5.0, 10.0 / 65_536.0),
        }
    }
}

/// Straight line from drive to code; made by [`Scale::new`], validated with the settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    kind: Kind,
    codes_per_v: f32,
    code_at_zero: f32,
    /// Codes within the range of the drive, inclusive.
    lowest: u16,
    highest: u16,
}

impl Scale {
    /// For an amplifier of `gain` (V/V, either sign) and `offset` (V of drive), with codes kept inside
    /// `range` (V of drive).
    ///
    /// `None` when the range is empty, reaches beyond the converter, or something is not finite.
    pub fn new(kind: Kind, gain: f32, offset: f32, range: (f32, f32)) -> Option<Self> {
        let (at_zero, per_code) = kind.scale();
        let v_per_code = f64::from(gain) * f64::from(per_code);
        let drive_at_zero = f64::from(gain) * f64::from(at_zero) + f64::from(offset);
        let exact = |drive: f32| (f64::from(drive) - drive_at_zero) / v_per_code;
        let (a, b) = (exact(range.0), exact(range.1));
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        let max = f64::from(kind.max_code());
        // An 1e-3 of a code forgives the rounding of settings that name a full range.
        if !(low >= -1e-3 && high <= max + 1.0 + 1e-3 && range.0 < range.1) {
            return None;
        }
        // Inwards, so that a rounded code is never beyond the range; casts saturate.
        let floor = (low - 1e-3).max(0.0) as u16;
        let lowest = if f64::from(floor) < low - 1e-3 {
            floor.saturating_add(1)
        } else {
            floor
        };
        let highest = (high + 1e-3).min(max) as u16;
        let scale = Self {
            kind,
            codes_per_v: (1.0 / v_per_code) as f32,
            code_at_zero: (-drive_at_zero / v_per_code) as f32,
            lowest,
            highest,
        };
        let usable = scale.codes_per_v.is_finite() && scale.code_at_zero.is_finite();
        (usable && lowest <= highest).then_some(scale)
    }

    /// The converter.
    #[inline(always)]
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// The code nearest to `drive` (V) within the range.
    #[inline(always)]
    pub fn code(&self, drive: f32) -> u16 {
        // A float-to-integer cast saturates and takes NaN to zero, in hardware on the target.
        let code = (drive * self.codes_per_v + self.code_at_zero + 0.5) as i32;
        if code < i32::from(self.lowest) {
            self.lowest
        } else if code > i32::from(self.highest) {
            self.highest
        } else {
            code as u16
        }
    }

    /// The drive (V) that a code gives.
    pub fn drive(&self, code: u16) -> f32 {
        (f32::from(code) - self.code_at_zero) / self.codes_per_v
    }
}

/// AD5761, AD5761R, AD5721, AD5721R over SPI: mode 1 or 2, at most 50 MHz, three bytes a transfer.
pub struct Ad5761r<S> {
    spi: S,
}

/// Register addresses of the converter.
mod register {
    pub const WRITE_AND_UPDATE: u8 = 0x3;
    pub const CONTROL: u8 = 0x4;
    pub const FULL_RESET: u8 = 0xf;
}

/// The bytes that put out `code`, for who has no bus any more.
pub const fn frame(code: u16) -> [u8; 3] {
    let [high, low] = code.to_be_bytes();
    [register::WRITE_AND_UPDATE, high, low]
}

impl<S: SpiDevice> Ad5761r<S> {
    /// Takes over the bus; nothing is sent yet.
    pub fn new(spi: S) -> Self {
        Self { spi }
    }

    /// Resets the converter and sets it to +-5 V, straight binary, clear and power-up at mid-scale,
    /// internal reference on; then puts out `code`. The part ignores codes before this.
    ///
    /// # Errors
    /// Those of the bus.
    pub fn start(&mut self, code: u16) -> Result<(), S::Error> {
        const CLEAR_AT_MID_SCALE: u16 = 0b01 << 9;
        const SHUT_DOWN_WHEN_HOT: u16 = 1 << 6;
        const INTERNAL_REFERENCE: u16 = 1 << 5;
        const POWER_UP_AT_MID_SCALE: u16 = 0b01 << 3;
        const PLUS_MINUS_5_V: u16 = 0b010;
        self.send(register::FULL_RESET, 0)?;
        self.send(
            register::CONTROL,
            CLEAR_AT_MID_SCALE
                | SHUT_DOWN_WHEN_HOT
                | INTERNAL_REFERENCE
                | POWER_UP_AT_MID_SCALE
                | PLUS_MINUS_5_V,
        )?;
        self.put(code)
    }

    /// Puts out `code`.
    ///
    /// # Errors
    /// Those of the bus.
    #[inline(always)]
    pub fn put(&mut self, code: u16) -> Result<(), S::Error> {
        self.send(register::WRITE_AND_UPDATE, code)
    }

    #[inline(always)]
    fn send(&mut self, register: u8, data: u16) -> Result<(), S::Error> {
        self.spi.write(&[register, (data >> 8) as u8, data as u8])
    }

    /// Gives the bus back.
    pub fn release(self) -> S {
        self.spi
    }
}
