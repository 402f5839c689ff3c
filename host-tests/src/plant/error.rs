//! What can be wrong with a simulated stage or its input.

/// Why a stage cannot be simulated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StageError {
    /// A configuration value is out of its range.
    #[error("{field} = {value}: {requirement}")]
    Parameter {
        /// Path of the field, for example `hysteresis.bands[1].weight_um_per_v`.
        field: String,
        /// The value found there.
        value: f64,
        /// What it has to be.
        requirement: &'static str,
    },
    /// A drive sample is NaN, infinite or beyond what the simulation's arithmetic is meant for.
    #[error("drive sample {index} is {value} V: must be finite and within +-1e6 V")]
    Drive {
        /// Zero-based number of the sample since the simulation was started.
        index: u64,
        /// The sample, V.
        value: f64,
    },
}

/// `Ok` when `holds`, otherwise the error that names `field`.
pub(super) fn require(
    holds: bool,
    field: impl Into<String>,
    value: f64,
    requirement: &'static str,
) -> Result<(), StageError> {
    if holds {
        Ok(())
    } else {
        Err(StageError::Parameter {
            field: field.into(),
            value,
            requirement,
        })
    }
}

/// Largest drive in V that is simulated; with the limits on sample time and rate term it keeps
/// every intermediate value finite.
const LARGEST_DRIVE_V: f64 = 1e6;

/// Refuses a drive sample that would poison the state.
pub(super) fn require_drive(index: u64, value: f64) -> Result<(), StageError> {
    if value.abs() <= LARGEST_DRIVE_V {
        Ok(())
    } else {
        Err(StageError::Drive { index, value })
    }
}
