//! The hardware: the only place that names vendor parts, and the only one with `unsafe`.
//!
//! A board gives the sample task a [`Sampling`], the link a serial port and the idle loop a watchdog.
//! One source serves the microcontroller and its emulator: feature `qemu` leaves out the clock tree,
//! which QEMU never reports ready, and carries samples and link over semihosting (`pil`).

pub mod fault;
#[cfg(feature = "qemu")]
pub mod pil;
#[cfg(feature = "qemu")]
pub use pil as line;
#[cfg(not(feature = "qemu"))]
pub mod serial;
#[cfg(not(feature = "qemu"))]
pub use serial as line;
pub mod spi;
pub mod stm32f405;

use crate::control::Output;
use crate::settings::Valid;

/// What the sample task knows of the hardware.
pub trait Sampling {
    /// Called first in each sample: takes the timer's request and returns what was sampled.
    fn begin(&mut self) -> Sampled;

    /// Called as soon as the output is known: converter first, then the driver-enable pin.
    fn put(&mut self, output: Output);
}

/// What [`Sampling::begin`] finds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampled {
    /// Code of the sensor's converter.
    pub sensor: u16,
    /// The sample before was still being computed when this one was due.
    pub late: bool,
}

/// A board that the firmware runs on.
pub trait Board: Sized {
    /// Its part for the sample task.
    type Sampling: Sampling;

    /// Brings the hardware up with the output at rest, then the driver-enable pin low, and the sample
    /// timer still stopped.
    fn start(settings: &Valid) -> (Self, Self::Sampling);

    /// Starts the sample timer or sets it to another rate, and keeps the code for faults.
    fn apply(&mut self, settings: &Valid);

    /// Tells the watchdog that all is well; it resets a board that stays silent for 50 ms.
    fn feed_watchdog(&mut self);
}
