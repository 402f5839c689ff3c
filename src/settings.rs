//! Settings of the target: amplifier, sensor, limits, sample rate.

use serde::{Deserialize, Serialize};

use crate::control::Output;
use crate::safety::Limits;
use crate::{dac, sensor};

/// Version of [`Settings`]; a record of another one is refused.
pub const VERSION: u16 = 1;

/// Everything that depends on the bench and not on the stage's hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// [`VERSION`].
    pub version: u16,
    /// Samples a second, 100 to 20,000.
    pub sample_rate_hz: f32,
    /// Converter that drives the amplifier.
    pub dac: dac::Kind,
    /// Drive per converter volt, V/V; not zero.
    pub amplifier_gain: f32,
    /// Drive at zero converter volts, V.
    pub amplifier_offset_v: f32,
    /// Displacement per sensor volt, um/V; not zero.
    pub sensor_um_per_v: f32,
    /// Displacement at zero sensor volts, um.
    pub sensor_offset_um: f32,
    /// Lowest drive, V.
    pub drive_min_v: f32,
    /// Highest drive, V.
    pub drive_max_v: f32,
    /// Drive at rest and after a fault, V.
    pub drive_rest_v: f32,
    /// Fastest change of the drive, V/s.
    pub slew_v_per_s: f32,
    /// Change of the drive in soft start and ramp-down, V/s; at most the slew limit.
    pub ramp_v_per_s: f32,
    /// How long a stream that ran dry is waited for, s, 0 to 60.
    pub stale_s: f32,
    /// Late samples after a start that are no fault yet.
    pub miss_limit: u16,
}

/// A field of [`Settings`] that is out of its bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum SettingsError {
    /// Another version.
    Version,
    /// `sample_rate_hz`.
    SampleRate,
    /// `amplifier_gain`, `amplifier_offset_v`, or a drive range that the converter cannot reach.
    Amplifier,
    /// `sensor_um_per_v` or `sensor_offset_um`.
    Sensor,
    /// `drive_min_v`, `drive_max_v`: not finite or not in this order.
    DriveRange,
    /// `drive_rest_v`: not within the range.
    Rest,
    /// `slew_v_per_s`: not positive.
    Slew,
    /// `ramp_v_per_s`: too small to ever arrive, or above the slew limit.
    Ramp,
    /// `stale_s`.
    Stale,
}

/// Settings in the form that the interrupt uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Valid {
    /// Limits of the drive.
    pub limits: Limits,
    /// Drive to codes.
    pub dac: dac::Scale,
    /// Codes to displacement.
    pub sensor: sensor::Scale,
    /// Time between two samples, s.
    pub sample_time: f32,
    /// As in [`Settings`].
    pub miss_limit: u16,
}

impl Default for Settings {
    /// The internal converter and an amplifier of ten, slow and narrow: safe to power up with.
    fn default() -> Self {
        Self {
            version: VERSION,
            sample_rate_hz: 10_000.0,
            dac: dac::Kind::Internal12,
            amplifier_gain: 10.0,
            amplifier_offset_v: 0.0,
            sensor_um_per_v: 10.0,
            sensor_offset_um: 0.0,
            drive_min_v: 0.0,
            drive_max_v: 30.0,
            drive_rest_v: 0.0,
            slew_v_per_s: 20_000.0,
            ramp_v_per_s: 50.0,
            stale_s: 0.1,
            miss_limit: 3,
        }
    }
}

impl Valid {
    /// The output at rest: what is put out first, and when nothing else can be trusted.
    pub fn at_rest(&self) -> Output {
        Output {
            dac: self.dac.kind(),
            code: self.dac.code(self.limits.rest),
            driver_enabled: false,
        }
    }
}

impl Settings {
    /// The settings in the form that the interrupt uses.
    ///
    /// # Errors
    /// The first field that is out of its bounds.
    pub fn validate(&self) -> Result<Valid, SettingsError> {
        use SettingsError as E;
        let ensure = |holds: bool, error| if holds { Ok(()) } else { Err(error) };
        ensure(self.version == VERSION, E::Version)?;
        let rate = self.sample_rate_hz;
        ensure((100.0..=20_000.0).contains(&rate), E::SampleRate)?;
        let sample_time = 1.0 / rate;
        let (lowest, highest) = (self.drive_min_v, self.drive_max_v);
        let ordered = lowest < highest && lowest.is_finite() && highest.is_finite();
        ensure(ordered, E::DriveRange)?;
        let rest = self.drive_rest_v;
        ensure((lowest..=highest).contains(&rest), E::Rest)?;
        let (slew, ramp) = (self.slew_v_per_s, self.ramp_v_per_s);
        ensure(slew.is_finite() && slew * sample_time > 0.0, E::Slew)?;
        // A step that rounding swallows would never arrive.
        let largest = crate::math::max(lowest.abs(), highest.abs());
        let arrives = ramp * sample_time > 4.0 * f32::EPSILON * largest;
        ensure(arrives && ramp <= slew, E::Ramp)?;
        ensure((0.0..=60.0).contains(&self.stale_s), E::Stale)?;
        let (gain, offset) = (self.amplifier_gain, self.amplifier_offset_v);
        let dac = dac::Scale::new(self.dac, gain, offset, (lowest, highest)).ok_or(E::Amplifier)?;
        let sensor = sensor::Scale::new(self.sensor_um_per_v, self.sensor_offset_um);
        Ok(Valid {
            limits: Limits {
                lowest,
                highest,
                rest,
                slew: slew * sample_time,
                ramp: ramp * sample_time,
                stale: (self.stale_s * rate) as u32,
            },
            dac,
            sensor: sensor.ok_or(E::Sensor)?,
            sample_time,
            miss_limit: self.miss_limit,
        })
    }
}
