//! The hardware: the only place that names vendor parts, and the only one with `unsafe`.
//!
//! A part is a folder: its memory map and an implementor of [`Board`], which is all that the rest of
//! the program knows of it. The feature of its name chooses it.
//!
//! One source serves the microcontroller and its emulator: feature `qemu` leaves out the clock tree,
//! which QEMU never reports ready, and the flash controller, which it lacks, and carries samples and
//! link over semihosting (`pil`).

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
pub mod watchdog;

#[cfg(feature = "stm32f405")]
pub mod stm32f405;
#[cfg(feature = "stm32f405")]
pub use self::stm32f405 as part;

#[cfg(feature = "stm32h743")]
pub mod stm32h743;
#[cfg(feature = "stm32h743")]
pub use self::stm32h743 as part;

pub use part::{Hardware, device};

use core::sync::atomic::{AtomicBool, Ordering};

use embedded_storage::nor_flash::NorFlash;

use crate::control::Output;
use crate::settings::Valid;

/// What there is one of.
struct Single(AtomicBool);

impl Single {
    const fn new() -> Self {
        Self(AtomicBool::new(false))
    }

    /// Runs `make` the first time after a reset, never again.
    fn take<T>(&self, make: impl FnOnce() -> T) -> Option<T> {
        (!self.0.swap(true, Ordering::Relaxed)).then(make)
    }
}

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

/// The link's port: its interrupt comes with a byte, and as long as it was asked to, with room for one.
pub trait Uart {
    /// The byte that came, if one did.
    fn receive(&mut self) -> Option<u8>;

    /// Whether there is room for a byte to send.
    fn has_room(&self) -> bool;

    /// Sends a byte.
    fn send(&mut self, byte: u8);

    /// Whether the interrupt is to come when there is room.
    fn ask_for_room(&mut self, ask: bool);
}

/// A board that the firmware runs on. Its sample interrupt is called `TIM3`, its link's `USART1`.
pub trait Board: Sized {
    /// Its part for the sample task.
    type Sampling: Sampling;

    /// The port of the link.
    type Uart: Uart;

    /// Where settings and model are saved.
    type Flash: NorFlash;

    /// The flash, before anything else; it can be read at once, and written once the board was started.
    /// `None` but for the first time after a reset: there is one.
    fn flash() -> Option<Self::Flash>;

    /// Brings the hardware up with the output at rest, then the driver-enable pin low, and the sample
    /// timer still stopped.
    fn start(settings: &Valid) -> (Self, Self::Sampling);

    /// Opens the port of a board that was started: 921,600 baud, 8N1.
    fn uart() -> Self::Uart;

    /// Starts the sample timer or sets it to another rate, and keeps the code for faults.
    fn apply(&mut self, settings: &Valid);

    /// Tells the watchdog that all is well; it resets a board that stays silent for 34 to 94 ms,
    /// as exact as its oscillator is.
    fn feed_watchdog(&mut self);

    /// Puts out `output`, the driver disabled, whatever state anything is in; interrupts are off for
    /// good.
    fn make_safe(output: Output);
}
