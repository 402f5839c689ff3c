//! What can be wrong with parameters and samples.

use core::fmt;

use serde::{Deserialize, Serialize};

/// A parameter of a model, named as in its documentation and in `model.toml`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Field {
    /// Weights a_0..a_n of the play bank.
    Weights,
    /// Rate-independent thresholds alpha_1..alpha_n of the play bank.
    Thresholds,
    /// Rate coefficient beta.
    Beta,
    /// Time between two samples.
    SampleTime,
    /// Play outputs at the start.
    InitialState,
    /// Thresholds of the asymmetry map for positive arguments.
    PositiveThresholds,
    /// Slopes of the asymmetry map for positive arguments.
    PositiveSlopes,
    /// Thresholds of the asymmetry map for negative arguments.
    NegativeThresholds,
    /// Slopes of the asymmetry map for negative arguments.
    NegativeSlopes,
    /// Window or sweeps of a preview inverse.
    Preview,
    /// Gain from volts to micrometres.
    Gain,
    /// Displacement at rest.
    Offset,
}

impl Field {
    /// The key of `model.toml` that holds the parameter.
    pub const fn key(self) -> &'static str {
        match self {
            Self::Weights => "weights",
            Self::Thresholds => "thresholds_v",
            Self::Beta => "beta_s",
            Self::SampleTime => "sample time",
            Self::InitialState => "initial state",
            Self::PositiveThresholds => "thresholds.positive",
            Self::PositiveSlopes => "slopes.positive",
            Self::NegativeThresholds => "thresholds.negative",
            Self::NegativeSlopes => "slopes.negative",
            Self::Preview => "preview",
            Self::Gain => "gain_um_per_v",
            Self::Offset => "offset_um",
        }
    }
}

/// Why a set of parameters is refused. Indices count the entries of the field from zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ParameterError {
    /// An entry is infinite or NaN, or what is derived from it leaves the range of the scalar.
    NotFinite(Field, usize),
    /// The number of entries is zero, above the capacity, or does not match its partner field.
    Length(Field),
    /// Thresholds must be positive and strictly increasing (J 20).
    NotIncreasing(Field, usize),
    /// The sum of the weights or slopes up to this entry must be positive, or there is no inverse.
    PartialSum(Field, usize),
    /// A rate coefficient below zero would shrink the distance between thresholds (J 11).
    ShrinkingGap(Field),
    /// The rate term is too strong for the sum of the weights up to this entry: no preview inverse.
    RateTooStrong(usize),
    /// The value must be positive.
    NotPositive(Field),
    /// The value must not be zero.
    Zero(Field),
    /// The play output at the start lies further from its neighbour than the thresholds allow (J 8).
    Inadmissible(usize),
}

impl fmt::Display for ParameterError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite(field, index) => {
                write!(
                    f,
                    "{}[{index}]: not finite, or leads out of the range of numbers",
                    field.key()
                )
            }
            Self::Length(field) => write!(f, "{}: wrong number of entries", field.key()),
            Self::NotIncreasing(field, index) => {
                write!(
                    f,
                    "{}[{index}]: must be positive and above the entry before it",
                    field.key()
                )
            }
            Self::PartialSum(field, index) => {
                write!(
                    f,
                    "{}[{index}]: the sum up to this entry must be positive",
                    field.key()
                )
            }
            Self::ShrinkingGap(field) => {
                write!(
                    f,
                    "{}: below zero it would shrink the gaps between thresholds",
                    field.key()
                )
            }
            Self::RateTooStrong(index) => write!(
                f,
                "{}[{index}]: too small a sum up to this entry for a preview inverse at this {} and {}",
                Field::Weights.key(),
                Field::Beta.key(),
                Field::SampleTime.key()
            ),
            Self::NotPositive(field) => write!(f, "{}: must be positive", field.key()),
            Self::Zero(field) => write!(f, "{}: must not be zero", field.key()),
            Self::Inadmissible(index) => write!(
                f,
                "{}[{index}]: further from its neighbour than the thresholds allow",
                Field::InitialState.key()
            ),
        }
    }
}

impl core::error::Error for ParameterError {}

/// Why a sample is turned away; the state is as it was before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleError {
    /// The sample is infinite or NaN.
    NotFinite,
}

impl fmt::Display for SampleError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "the sample is not finite"),
        }
    }
}

impl core::error::Error for SampleError {}
