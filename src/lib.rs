#![no_std]
#![doc = include_str!("../README.md")]
//!
//! # The library
//!
//! The crate is the mathematical core of hysteron: it computes in volts, micrometres and seconds,
//! knows no clock, bus, heap or file, and runs bit for bit the same on a Cortex-M4F and on a host.
//!
//! | module | what it holds |
//! |---|---|
//! | [`play`] | the play operator with envelopes; a bank of them in a plain and in a stack form |
//! | [`rate`] | the law that widens the envelopes with the rate of the input |
//! | [`hysteresis`] | the rate-dependent Prandtl-Ishlinskii model, its analytic and its preview inverse; the modified play model |
//! | [`effect`] | what a stage does besides hysteresis: asymmetry, curvature, limits, lags, delay, backlash, modes, creep, interleaving, drift, hum, steps |
//! | [`model`] | a whole stage: hysteresis, asymmetry, gain and offset |
//! | [`chain`] | the same with every effect around it |
//! | [`compensator`] | the inverses of a model in reverse order: reference in, drive out |
//! | [`feedback`] | PID around a compensator, for stages with a sensor |
//! | [`cascade`] | the same for a chain: lags, modes and delays are undone ahead of time |
//! | [`dim`] | direct inverse multiplication: the compensator of the modified play model |
//! | [`rls`] | recursive least squares of fixed size, which identifies that model |
//! | [`phasor`] | sine and cosine by rotation |
//!
//! Around it lies what a target needs to drive an amplifier with it, free of any hardware too:
//!
//! | module | what it holds |
//! |---|---|
//! | [`control`] | one sample: reference, compensator, safety, converter code |
//! | [`mod@reference`] | oscillators and streamed samples |
//! | [`safety`] | range, slew, soft start, stale references, faults |
//! | [`dac`], [`sensor`] | codes and units, the driver of a bipolar converter |
//! | [`settings`], [`record`] | what a host sets: bench and model, validated whole |
//! | [`store`] | both kept in flash, whole through a power cut |
//! | [`link`], [`telemetry`] | framed commands and replies, recorded samples, counters |
//! | [`wiring`] | the queues between the two, for target, simulation and tests alike |
//!
//! Configuration stands apart from state: what is validated and built once is shared and immutable,
//! what a sample changes is a small value of its own. Sizes are types (`[T; N]`), `T` is `f32` or
//! `f64`, and nothing here allocates, panics or needs `unsafe`.
//!
//! Equations are cited as (J n): Al Janaideh and Krejci, *Inverse Rate-Dependent Prandtl-Ishlinskii
//! Model for Feedforward Compensation of Hysteresis in a Piezomicropositioning Actuator*,
//! IEEE/ASME Trans. Mechatronics 18(5), 2013, doi 10.1109/TMECH.2012.2205265; and as (M n): Morita,
//! Fujii and Hosoda, *Modeling and Compensation of a Bimorph Type Piezoelectric Actuator Exhibiting
//! Odd-Harmonic Oscillation and Frequency-Dependent, Interleaved Hysteresis*, Actuators 9(2), 2020.

#[cfg(all(target_os = "none", feature = "firmware"))]
#[allow(unsafe_code, reason = "registers of the microcontroller")]
pub mod board;
pub mod cascade;
pub mod chain;
mod checksum;
pub mod compensator;
pub mod control;
pub mod dac;
pub mod dim;
pub mod effect;
pub mod error;
pub mod feedback;
pub mod hysteresis;
pub mod link;
pub mod math;
pub mod model;
pub mod phasor;
pub mod play;
pub mod rate;
pub mod record;
pub mod reference;
mod replay;
pub mod rls;
pub mod safety;
pub mod sensor;
pub mod settings;
pub mod store;
pub mod telemetry;
pub mod wiring;
