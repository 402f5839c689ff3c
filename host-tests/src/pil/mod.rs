//! Processor in the loop: the firmware itself in an emulator, the simulated stage around it.
//!
//! A [`Target`] answers samples and link bytes: the firmware in QEMU ([`Emulator`]), the same core
//! code on the host ([`Replica`]), or both with every answer compared ([`Pair`]). A [`Bench`] puts a
//! simulated stage between the target's converter and its sensor, and is a port for the link.
//! [`experiment`] is what `hysteron pil` runs; [`compare`] puts the compensators of two models side by
//! side on any stage.

mod bench;
mod compare;
mod comparison_page;
mod emulator;
pub mod experiment;
mod firmware;
mod page;
mod replica;
mod serve;
mod target;

pub use bench::{Bench, Hardware, Plant};
pub use compare::{Compared, Comparison, Reached, compare, model_plant};
pub use comparison_page::comparison_page;
pub use emulator::Emulator;
pub use firmware::{Sizes, build, sizes};
pub use page::page;
pub use replica::{Pair, Replica};
pub use serve::{Listener, serve};
pub use target::{Target, Ticked};
