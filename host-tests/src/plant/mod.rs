//! Simulated piezo stages: the independent truth that identification and compensation are tested on.
//!
//! Nothing here comes from the core crate. The core keeps a bank of plays; a simulated stage keeps
//! one *memory curve* over a continuous density of thresholds ([`Band`]), so a bank of any size is
//! an approximation of it, unless the density consists of single thresholds
//! ([`Band::play`]).
//!
//! # Signal chain
//!
//! ```text
//! command -> DAC -> reconstruction -> amplifier -> hysteresis -> sensor -> sample
//!   V        V         V(t)            u(t), V       v(t), um       um        um
//! ```
//!
//! One call of [`Simulation::step`] takes the command of one sample time h and returns the sensor
//! sample at its end. Inside, everything runs `oversample` times finer.
//!
//! * **DAC** ([`Dac`]): rounds to a code and saturates at its range.
//! * **Reconstruction** ([`Reconstruction`]): the command as a function of time. The thresholds
//!   widen with the rate of the drive at the actuator, and the rate of a staircase is not defined
//!   at its steps. `Ramp`, the default, joins the commands by straight lines: during one sample
//!   time the drive goes from the previous command to this one and reaches it where the sensor is
//!   sampled, so sample k of the output belongs to command k without delay. `Hold` is the bare
//!   staircase; a rate term then needs an amplifier lag behind it, and the lag must be several
//!   sample times long, or the rate comes in bursts and is near zero whenever the drive arrives.
//! * **Amplifier**: a first-order lag, integrated exactly for either reconstruction.
//! * **Hysteresis** ([`Hysteresis`]): `v = a_0 u + integral of p(r) z_r dr`, every
//!   `z_r = max(u - r - beta |u'|, min(u + r + beta |u'|, z_r before))`, with `u'` the difference of
//!   the actual drive u(t) over one fine step.
//! * **Sensor** ([`Sensor`]): seeded Gaussian noise, then rounding.
//!
//! ```
//! use hysteron_host::plant::Stage;
//!
//! let drive: Vec<f64> = (0..100).map(|k| 0.4 * f64::from(k)).collect();
//! let displacement_um = Stage::p753().run(&drive, 1e-4)?;
//! assert_eq!(displacement_um.len(), drive.len());
//! # Ok::<(), hysteron_host::plant::StageError>(())
//! ```

mod amplifier;
pub mod bimorph;
mod dac;
mod error;
pub mod hidden;
mod hysteresis;
mod memory;
mod presets;
mod sensor;
mod stage;

pub use amplifier::Reconstruction;
pub use dac::Dac;
pub use error::StageError;
pub use hysteresis::{Band, Hysteresis};
pub use sensor::Sensor;
pub use stage::{Simulation, Stage};
