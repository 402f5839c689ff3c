//! Rate-dependent hysteresis: a density of play thresholds over one memory curve.

use super::error::{StageError, require};
use super::memory::MemoryCurve;

/// Play weight spread evenly over a range of thresholds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Smallest threshold, V, at least 0.
    pub from_v: f64,
    /// Largest threshold, V; equal to `from_v` for a single play.
    pub to_v: f64,
    /// Summed weight of all plays of the band, um/V.
    pub weight_um_per_v: f64,
}

impl Band {
    /// A single play with one threshold in V.
    pub const fn play(threshold_v: f64, weight_um_per_v: f64) -> Self {
        Self {
            from_v: threshold_v,
            to_v: threshold_v,
            weight_um_per_v,
        }
    }

    /// Contribution of the plays with thresholds in `(start, end]` whose outputs are
    /// `level + slope * r`, um.
    fn over(&self, (start, end, level, slope): (f64, f64, f64, f64)) -> f64 {
        let (share, mean_v) = if self.from_v == self.to_v {
            let inside = start < self.from_v && self.from_v <= end;
            (f64::from(u8::from(inside)), self.from_v)
        } else {
            let (start, end) = (start.max(self.from_v), end.min(self.to_v));
            (
                (end - start).max(0.0) / (self.to_v - self.from_v),
                0.5 * (start + end),
            )
        };
        self.weight_um_per_v * share * (level + slope * mean_v)
    }
}

/// `v = a_0 u + integral of p(r) z_r dr`, thresholds widened by `beta |u'|`.
#[derive(Debug, Clone, PartialEq)]
pub struct Hysteresis {
    /// Weight a_0 of the drive itself, um/V.
    pub gain_um_per_v: f64,
    /// The density p(r) as a sum of bands, which may overlap.
    pub bands: Vec<Band>,
    /// Widening beta of every threshold, V per V/s, 0 to 1.
    pub rate_widening_s: f64,
}

impl Hysteresis {
    /// Checks that weights are finite and that every band is an ordered range of thresholds.
    ///
    /// # Errors
    /// [`StageError::Parameter`] with the field's name.
    pub fn validate(&self) -> Result<(), StageError> {
        let weight = |field: String, value: f64| {
            require(
                value.abs() <= 1e6,
                field,
                value,
                "must be finite and within +-1e6 um/V",
            )
        };
        weight("hysteresis.gain_um_per_v".into(), self.gain_um_per_v)?;
        require(
            (0.0..=1.0).contains(&self.rate_widening_s),
            "hysteresis.rate_widening_s",
            self.rate_widening_s,
            "must be 0 to 1",
        )?;
        for (index, band) in self.bands.iter().enumerate() {
            let field = |name| format!("hysteresis.bands[{index}].{name}");
            weight(field("weight_um_per_v"), band.weight_um_per_v)?;
            require(
                band.to_v > 0.0 && band.to_v <= 1e6,
                field("to_v"),
                band.to_v,
                "must be above 0 and at most 1e6 V",
            )?;
            require(
                (0.0..=band.to_v).contains(&band.from_v),
                field("from_v"),
                band.from_v,
                "must be 0 to to_v",
            )?;
        }
        Ok(())
    }

    /// The largest threshold without widening, V; 0 without bands.
    fn largest_threshold_v(&self) -> f64 {
        self.bands
            .iter()
            .fold(0.0, |largest, band| largest.max(band.to_v))
    }

    /// The plays of a stage that has come from the virgin state to rest at `drive_v`.
    pub(super) fn at_rest(&self, drive_v: f64) -> MemoryCurve {
        let mut memory = MemoryCurve::new(self.largest_threshold_v());
        memory.apply(drive_v, drive_v);
        memory
    }

    /// Moves the plays under a drive in V that changes at `rate` V/s.
    pub(super) fn advance(&self, memory: &mut MemoryCurve, drive_v: f64, rate: f64) {
        let widening = self.rate_widening_s * rate.abs();
        memory.apply(drive_v - widening, drive_v + widening);
    }

    /// Displacement with the plays as they are, um.
    pub(super) fn displacement_um(&self, memory: &MemoryCurve, drive_v: f64) -> f64 {
        let plays: f64 = memory
            .pieces()
            .map(|piece| self.bands.iter().map(|band| band.over(piece)).sum::<f64>())
            .sum();
        self.gain_um_per_v * drive_v + plays
    }
}
