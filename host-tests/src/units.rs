//! Units of the three quantities a record holds, and how they reach volts, micrometres and seconds.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A unit that files may use for one quantity.
pub(crate) trait Unit: Copy + 'static {
    /// Every unit of the quantity, the internal one first.
    const ALL: &'static [Self];

    /// The unit as data sets write it.
    fn symbol(self) -> &'static str;

    /// The factor that takes a value in this unit to the internal one.
    fn scale(self) -> Scale;

    /// The unit's name at the end of a column name: its symbol in lower case.
    fn suffix(self) -> String {
        self.symbol().to_ascii_lowercase()
    }
}

/// A factor to the internal unit. Powers of ten below one are divided by, which rounds only once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scale {
    /// Multiply by the number.
    Times(f64),
    /// Divide by the number.
    Over(f64),
}

impl Scale {
    /// The value in the internal unit.
    pub(crate) fn apply(self, value: f64) -> f64 {
        match self {
            Self::Times(factor) => value * factor,
            Self::Over(divisor) => value / divisor,
        }
    }

    /// The value in the file's unit of a value in the internal one.
    pub(crate) fn undo(self, value: f64) -> f64 {
        match self {
            Self::Times(factor) => value / factor,
            Self::Over(divisor) => value * divisor,
        }
    }
}

/// Unit of a time column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum TimeUnit {
    /// Seconds.
    #[serde(rename = "s")]
    Second,
    /// Milliseconds.
    #[serde(rename = "ms")]
    Millisecond,
    /// Microseconds.
    #[serde(rename = "us")]
    Microsecond,
}

impl Unit for TimeUnit {
    const ALL: &'static [Self] = &[Self::Second, Self::Millisecond, Self::Microsecond];

    fn symbol(self) -> &'static str {
        match self {
            Self::Second => "s",
            Self::Millisecond => "ms",
            Self::Microsecond => "us",
        }
    }

    fn scale(self) -> Scale {
        match self {
            Self::Second => Scale::Times(1.0),
            Self::Millisecond => Scale::Over(1e3),
            Self::Microsecond => Scale::Over(1e6),
        }
    }
}

/// Unit of a drive column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum VoltageUnit {
    /// Volts.
    #[serde(rename = "V")]
    Volt,
    /// Millivolts.
    #[serde(rename = "mV")]
    Millivolt,
}

impl Unit for VoltageUnit {
    const ALL: &'static [Self] = &[Self::Volt, Self::Millivolt];

    fn symbol(self) -> &'static str {
        match self {
            Self::Volt => "V",
            Self::Millivolt => "mV",
        }
    }

    fn scale(self) -> Scale {
        match self {
            Self::Volt => Scale::Times(1.0),
            Self::Millivolt => Scale::Over(1e3),
        }
    }
}

/// Unit of a displacement or reference column, and of the figures reported about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum LengthUnit {
    /// Micrometres.
    #[serde(rename = "um")]
    Micrometre,
    /// Nanometres.
    #[serde(rename = "nm")]
    Nanometre,
    /// Millimetres.
    #[serde(rename = "mm")]
    Millimetre,
    /// Metres.
    #[serde(rename = "m")]
    Metre,
}

impl LengthUnit {
    /// The unit as data sets write it: `um`, `nm`, `mm` or `m`.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Micrometre => "um",
            Self::Nanometre => "nm",
            Self::Millimetre => "mm",
            Self::Metre => "m",
        }
    }

    /// A length given in micrometres, in this unit.
    pub fn from_um(self, length_um: f64) -> f64 {
        self.scale().undo(length_um)
    }

    /// A length given in this unit, in micrometres.
    pub fn to_um(self, length: f64) -> f64 {
        self.scale().apply(length)
    }
}

impl std::fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.symbol())
    }
}

impl Unit for LengthUnit {
    const ALL: &'static [Self] = &[
        Self::Micrometre,
        Self::Nanometre,
        Self::Millimetre,
        Self::Metre,
    ];

    fn symbol(self) -> &'static str {
        LengthUnit::symbol(self)
    }

    fn scale(self) -> Scale {
        match self {
            Self::Micrometre => Scale::Times(1.0),
            Self::Nanometre => Scale::Over(1e3),
            Self::Millimetre => Scale::Times(1e3),
            Self::Metre => Scale::Times(1e6),
        }
    }
}

/// Finds the unit of a column called `stem_unit`, in any letter case; `None` for any other name.
pub(crate) fn unit_of_column<U: Unit>(header: &str, stem: &str) -> Option<U> {
    let header = header.to_ascii_lowercase();
    let suffix = header.strip_prefix(stem)?.strip_prefix('_')?;
    U::ALL.iter().copied().find(|unit| unit.suffix() == suffix)
}

/// The column names that would do for a stem, as in `drive_v or drive_mv`.
pub(crate) fn column_names<U: Unit>(stem: &str) -> String {
    let names: Vec<_> = U::ALL
        .iter()
        .map(|unit| format!("{stem}_{}", unit.suffix()))
        .collect();
    match names.split_last() {
        Some((last, rest)) if !rest.is_empty() => format!("{} or {last}", rest.join(", ")),
        _ => names.concat(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_round_once() {
        // Exact operands, so that one rounding gives what the compiler makes of the decimal literal.
        assert_eq!(TimeUnit::Millisecond.scale().apply(0.375), 0.000_375);
        assert_eq!(TimeUnit::Microsecond.scale().apply(33.25), 0.000_033_25);
        assert_eq!(VoltageUnit::Millivolt.scale().apply(1234.5), 1.2345);
        assert_eq!(LengthUnit::Nanometre.to_um(123_456.75), 123.456_75);
        assert_eq!(LengthUnit::Millimetre.to_um(0.25), 250.0);
        assert_eq!(LengthUnit::Metre.to_um(2e-6), 2.0);
        assert_eq!(LengthUnit::Nanometre.from_um(0.0625), 62.5);
        assert_eq!(LengthUnit::Metre.from_um(1.0), 0.000_001);
    }

    #[test]
    fn column_suffix_gives_the_unit() {
        assert_eq!(
            unit_of_column("Drive_mV", "drive"),
            Some(VoltageUnit::Millivolt)
        );
        assert_eq!(
            unit_of_column("time_us", "time"),
            Some(TimeUnit::Microsecond)
        );
        assert_eq!(
            unit_of_column::<LengthUnit>("position_m", "position"),
            Some(LengthUnit::Metre)
        );
        assert_eq!(unit_of_column::<LengthUnit>("position", "position"), None);
        assert_eq!(
            unit_of_column::<LengthUnit>("position_km", "position"),
            None
        );
        assert_eq!(
            column_names::<TimeUnit>("time"),
            "time_s, time_ms or time_us"
        );
    }
}
