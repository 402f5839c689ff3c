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
    /// Largest input u_max that the triangular plane covers.
    InputRange,
    /// Divisions N of the triangular plane.
    Divisions,
    /// Slopes of the plays in the collapsed plane, 2A first.
    Slopes,
    /// Weights omega_ij of the plane.
    PlaneWeights,
    /// Slope alpha of the lower envelope.
    Alpha,
    /// Coefficients c_1..c_3 of the outputs before.
    Feedback,
    /// Coefficient g of the product of output and input before.
    Interleaving,
    /// Frequency of the harmonic terms.
    Frequency,
    /// Coefficients of the harmonic terms that go with the sine.
    Sine,
    /// Coefficients of the harmonic terms that go with the cosine.
    Cosine,
    /// Time constant of a lag.
    TimeConstant,
    /// Transport delay.
    Delay,
    /// Coefficient of the quadratic map.
    Quadratic,
    /// Coefficient of the cubic map.
    Cubic,
    /// Natural frequency of a mechanical mode.
    NaturalFrequency,
    /// Damping ratio of a mechanical mode.
    DampingRatio,
    /// Creep for each decade of time.
    CreepGain,
    /// Shortest time constant of creep.
    CreepShortest,
    /// Longest time constant of creep.
    CreepLongest,
    /// Mechanical modes.
    Modes,
    /// Gains of the feedback, `K_p`, `K_i`, `K_d`.
    FeedbackGains,
    /// Forgetting factor of recursive least squares.
    Forgetting,
    /// Initial covariance of recursive least squares.
    Covariance,
    /// Bound on the trace of that covariance.
    TraceBound,
    /// Limit of the drive.
    SaturationLimit,
    /// Limit of the drive's rate.
    SlewLimit,
    /// Exponent of the rate.
    Exponent,
    /// Growth of the plays with the output.
    Kappa,
    /// Width of a backlash.
    Width,
    /// Coefficient g of interleaving as an effect of its own.
    InterleavingGain,
    /// Amplitude of drift or hum.
    Amplitude,
    /// Phase of hum.
    Phase,
    /// Amplitude of the third harmonic of hum.
    ThirdAmplitude,
    /// Phase of the third harmonic of hum.
    ThirdPhase,
    /// Step of a quantisation.
    Step,
    /// Growth of an element of Bouc and Wen.
    Grow,
    /// Shape of an element of Bouc and Wen.
    Shape,
    /// Elements of Bouc and Wen.
    Elements,
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
            Self::InputRange => "u_max_v",
            Self::Divisions => "divisions",
            Self::Slopes => "slopes_um_per_v",
            Self::PlaneWeights => "plane weights",
            Self::Alpha => "alpha_s",
            Self::Feedback => "feedback",
            Self::Interleaving => "interleaving_per_v",
            Self::Frequency => "frequency_hz",
            Self::Sine => "sine",
            Self::Cosine => "cosine",
            Self::TimeConstant => "tau_s",
            Self::Delay => "delay_s",
            Self::Quadratic => "q",
            Self::Cubic => "c",
            Self::NaturalFrequency => "f_n_hz",
            Self::DampingRatio => "zeta",
            Self::CreepGain => "gain_per_decade",
            Self::CreepShortest => "tau_min_s",
            Self::CreepLongest => "tau_max_s",
            Self::Modes => "resonance",
            Self::FeedbackGains => "feedback gains",
            Self::Forgetting => "forgetting",
            Self::Covariance => "covariance",
            Self::TraceBound => "trace bound",
            Self::SaturationLimit => "limit_v",
            Self::SlewLimit => "slew_v_per_s",
            Self::Exponent => "exponent",
            Self::Kappa => "kappa",
            Self::Width => "width",
            Self::InterleavingGain => "g",
            Self::Amplitude => "amplitude",
            Self::Phase => "phase_rad",
            Self::ThirdAmplitude => "third_amplitude",
            Self::ThirdPhase => "third_phase_rad",
            Self::Step => "step",
            Self::Grow => "grow_per_v",
            Self::Shape => "shape_per_v",
            Self::Elements => "bouc-wen",
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
    /// The value must not be below zero.
    Negative(Field),
    /// The value lies above what it may be at most.
    TooLarge(Field),
    /// The value is below what makes sense.
    TooSmall(Field),
    /// The sum of the slopes up to this entry must have the sign of the first one and not nearly
    /// vanish beside them, or the map from input to output cannot be inverted.
    NotMonotone(Field, usize),
    /// An inverse that was built without the part that this parameter needs.
    NotSupported(Field),
    /// The first entry must outweigh what falls against the drive: elements right after a turn, negative
    /// entries.
    Outweighed(Field),
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
            Self::Negative(field) => write!(f, "{}: must not be below zero", field.key()),
            Self::TooLarge(field) => write!(f, "{}: too large", field.key()),
            Self::TooSmall(field) => write!(f, "{}: too small", field.key()),
            Self::NotSupported(field) => {
                write!(f, "{}: this inverse was built without it", field.key())
            }
            Self::Outweighed(field) => write!(
                f,
                "{}[0]: must be larger than what elements and negative weights take away after a turn",
                field.key()
            ),
            Self::NotMonotone(field, index) => write!(
                f,
                "{}[{index}]: the sum up to this entry must have the sign of the first one and not \
                 nearly vanish",
                field.key()
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
