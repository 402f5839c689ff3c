//! The host's side of the link to the firmware: ports, conversation, recording, streaming.
//!
//! `docs/link.md` has the bytes and the commands. A [`Port`] carries bytes, a [`Client`] holds the
//! conversation over it, [`play`] plays a reference and records what the stage does, [`model`] and
//! [`settings`] turn files into what the target takes.

mod capture;
mod client;
mod excitation;
pub mod model;
mod play;
mod port;
mod refusal;
pub mod settings;
mod stream;

pub use client::Client;
pub use excitation::{Excitation, Shape, multisine};
pub use play::{Played, Signals, play};
pub use port::{Port, open};
pub use refusal::kept as describe_kept;
