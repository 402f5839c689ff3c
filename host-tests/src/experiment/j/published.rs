//! What the paper prints. Nothing here is computed.

/// A constant of the published inverse: its name, the value as printed, and its unit.
pub type Constant = (&'static str, f64, &'static str);

/// The printed weights a_0 to a_3; spacing and rate term, which agree with everything else, are those
/// of the built-in models.
pub const WEIGHTS: [f64; 4] = [0.7124, 0.2906, 0.0461, 0.1512];

/// The printed inverse: b_0 to b_3, the constant parts of s_1 to s_3, and what multiplies |u'| in
/// each of them.
pub const INVERSE: [Constant; 8] = [
    ("b_0", 1.3892, "V/um"),
    ("b_1", -0.3961, "V/um"),
    ("b_2", -0.038, "V/um"),
    ("b_3", -0.1187, "V/um"),
    ("s_1", 7.0293, "um"),
    ("s_2", 16.8823, "um"),
    ("s_3", 27.1395, "um"),
    ("a_0 beta", 6.2024e-4, "s"),
];

/// Frequencies in Hz of the measured loops.
pub const LOOP_FREQUENCIES_HZ: [f64; 3] = [1.0, 50.0, 100.0];

/// Hysteresis percent of the measured loops.
pub const HYSTERESIS_PERCENT: [f64; 3] = [13.03, 20.28, 26.18];

/// Weights A_p of the measured loops in the fit (J 45).
pub const LOOP_WEIGHTS: [f64; 3] = [1.0, 1.56, 2.0];

/// Least and most of the largest errors between 0.05 and 100 Hz without the inverse, in um.
pub const ERROR_WITHOUT_UM: [f64; 2] = [5.9, 10.6];

/// The same with the rate-dependent inverse.
pub const ERROR_WITH_UM: [f64; 2] = [1.0, 2.0];

/// Lag of the amplifier in degrees at 50 and 100 Hz.
pub const LAG_DEGREES: [(f64, f64); 2] = [(50.0, 0.5), (100.0, 1.5)];
