//! The scalar of the core, `f32` or `f64`, and the few functions it needs.
//!
//! Everything here is exact or correctly rounded on both the host and the target, so that the two
//! agree bit for bit.

use core::fmt::Debug;
use core::ops::{Add, Div, Mul, Neg, Sub};

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// A floating-point scalar: `f32` on the target, `f32` or `f64` on the host.
pub trait Real:
    sealed::Sealed
    + Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + 'static
{
    /// 0
    const ZERO: Self;
    /// 1
    const ONE: Self;
    /// Spacing of the numbers next to one.
    const EPSILON: Self;
    /// Beyond every number.
    const INFINITY: Self;
    /// Not a number: every comparison with it is false.
    const NAN: Self;

    /// Nearest representable value.
    fn from_f64(value: f64) -> Self;
    /// The same value in double precision.
    fn to_f64(self) -> f64;
    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;
    /// Magnitude.
    fn abs(self) -> Self;
    /// `1 / self` to 1e-7 of it for a positive number, without a division.
    fn rough_reciprocal(self) -> Self;
    /// To the power of `exponent`, for numbers of zero or more.
    fn powf(self, exponent: Self) -> Self;
    /// `e^self - 1`.
    fn exp_m1(self) -> Self;
    /// Natural logarithm of `1 + self`.
    fn ln_1p(self) -> Self;
}

macro_rules! real {
    // The guess: subtracting the bits of a number from this constant turns its exponent's sign, and is
    // off by 12 % at most.
    ($float:ident, $powf:path, $exp_m1:path, $ln_1p:path, $guess:expr) => {
        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $float::EPSILON;
            const INFINITY: Self = $float::INFINITY;
            const NAN: Self = $float::NAN;

            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $float
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $float::is_finite(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $float::abs(self)
            }
            #[inline(always)]
            fn rough_reciprocal(self) -> Self {
                let mut guess = $float::from_bits($guess.wrapping_sub(self.to_bits()));
                // 0.12, 0.014, 2e-4, 5e-8
                for _ in 0..3 {
                    guess = guess * (2.0 - self * guess);
                }
                guess
            }
            fn powf(self, exponent: Self) -> Self {
                $powf(self, exponent)
            }
            fn exp_m1(self) -> Self {
                $exp_m1(self)
            }
            fn ln_1p(self) -> Self {
                $ln_1p(self)
            }
        }
    };
}

real!(f32, libm::powf, libm::expm1f, libm::log1pf, 0x7ef3_11c7_u32);
real!(
    f64,
    libm::pow,
    libm::expm1,
    libm::log1p,
    0x7fde_6238_22fc_16e6_u64
);

/// The smaller of two numbers; a NaN in `a` yields `b`.
///
/// A compare and a conditional move: `f32::min` is a library call on a Cortex-M4F.
#[inline(always)]
pub fn min<T: Real>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// The larger of two numbers; a NaN in `a` yields `b`.
#[inline(always)]
pub fn max<T: Real>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// `e^x` for set-up: tens of thousands of cycles where double precision is software.
pub(crate) fn exp(x: f64) -> f64 {
    libm::exp(x)
}

/// `e^x - 1` for set-up.
pub(crate) fn exp_m1(x: f64) -> f64 {
    libm::expm1(x)
}

/// Sine of any angle in rad; it brings 7 KiB of range reduction along.
pub(crate) fn sin(x: f64) -> f64 {
    libm::sin(x)
}

/// Nearest whole number, halves away from zero.
pub(crate) fn round(x: f64) -> f64 {
    libm::round(x)
}

/// Square root for set-up.
pub(crate) fn sqrt(x: f64) -> f64 {
    libm::sqrt(x)
}

/// Sine and cosine of `x` from zero to a quarter of a turn, for set-up: Taylor's polynomials, whose
/// first term left out is below 1e-17. That of libm brings 7 KiB of range reduction into the firmware.
pub(crate) fn quarter_turn(x: f64) -> (f64, f64) {
    const TERMS: u32 = 12;
    let square = x * x;
    let (mut sine, mut cosine) = (1.0, 1.0);
    for n in (1..TERMS).rev() {
        let n = f64::from(2 * n);
        sine = 1.0 - square / (n * (n + 1.0)) * sine;
        cosine = 1.0 - square / (n * (n - 1.0)) * cosine;
    }
    (x * sine, cosine)
}
