//! What the paper prints about its bimorph and its results. Nothing here is computed.

/// Frequencies at which the proposed model had the smallest RMSE of the three, of 110.
pub const PROPOSED_BEST: usize = 110;

/// Most that the proposed model's Fitting lost near the resonance, percent.
pub const FITTING_LOSS_PERCENT: f64 = 3.0;

/// Where compensation degraded below the resonance, Hz.
pub const DEGRADED_HZ: [f64; 2] = [23.0, 27.0];

/// The 75 Hz line over the 25 Hz line after compensation at 25 Hz.
pub const THIRD_AFTER: f64 = 2.0;

/// Third over first harmonic at 25 Hz, full drive: "approximately".
pub const THIRD_AT_25_HZ: f64 = 1.0 / 8.0;

/// Third over first harmonic at 35 Hz, full drive: "less than".
pub const THIRD_AT_35_HZ: f64 = 1.0 / 100.0;

/// Fifth over third harmonic at 15 Hz, full drive: "almost".
pub const FIFTH_AT_15_HZ: f64 = 2.0;
