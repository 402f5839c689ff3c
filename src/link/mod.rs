//! The link between host and target: messages, frames, and the target's side of the conversation.
//!
//! `docs/link.md` has the bytes. The messages are plain data that both ends share; the order of
//! fields and variants is the wire format, so a change to either raises [`VERSION`].

mod frame;
mod server;

pub use frame::{BODY_LEN, FRAME_LEN, FrameError, Reader, decode, encode};
pub use server::{Server, Wires};

use heapless::Vec;
use serde::{Deserialize, Serialize};

use crate::control::Path;
use crate::record::{self, ModelRecord, RecordError};
use crate::reference::{Waveform, WaveformError};
use crate::settings::{Settings, SettingsError};
use crate::store::Kept;
use crate::telemetry::{Codes, Statistics};

/// Version of the frames and messages: the first byte of a frame.
pub const VERSION: u8 = 2;

/// Reference samples in one [`Command::Stream`], at most.
pub const CHUNK_LEN: usize = 64;

/// Recorded samples in one [`Message::Recorded`], at most.
pub const RECORDED_LEN: usize = 64;

/// What a host sends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Chosen by the host; the reply carries it back.
    pub sequence: u16,
    /// What is wanted.
    pub command: Command,
}

/// What a host can want. Every command has exactly one reply, and one that is refused changes
/// nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub enum Command {
    /// Asks for [`Answer::Identity`].
    Identify,
    /// Asks for [`Answer::Settings`].
    GetSettings,
    /// Sets the settings; only with the output off and at rest. A model stays in force.
    SetSettings(Settings),
    /// Asks for [`Answer::Model`].
    GetModel,
    /// Sets or, with `None`, removes the model. In any state: the output goes on without a jump.
    SetModel(#[serde(deserialize_with = "record::deserialize")] Option<ModelRecord>),
    /// Plays a reference; not while one is being played, not in a fault. A stream starts with what
    /// was sent since the last start, so a host fills the queue first.
    Start {
        /// Displacement or drive.
        path: Path,
        /// What to play.
        waveform: Waveform,
        /// Samples to play before the output holds; 0 for no end.
        samples: u32,
    },
    /// The output stands still; not in a fault.
    Hold,
    /// The output ramps to rest; what is left of a stream is dropped by the next
    /// [`Command::ResetStream`].
    Stop,
    /// Leaves a fault.
    Clear,
    /// Empties the stream and numbers its next sample 0; only while no reference is played.
    ResetStream,
    /// Samples of the stream, in the unit of the reference. Those that came before are skipped, a gap
    /// is refused, and what does not fit is left: the reply says where to go on.
    Stream {
        /// Number of the first sample since [`Command::ResetStream`].
        first: u32,
        /// The samples, all finite.
        samples: Vec<f32, CHUNK_LEN>,
    },
    /// Records one sample in this many, numbered from 0, and again from 0 at every
    /// [`Command::Start`]; zero ends the recording.
    Record {
        /// Distance between two recorded samples.
        every: u32,
    },
    /// Asks for [`Answer::Statistics`].
    Statistics,
    /// Saves settings and model in force to flash, to be in force after a reset; only with the output
    /// off and at rest. Takes as long as an erase, and samples are late or lost meanwhile.
    Save,
    /// Asks for [`Answer::Kept`].
    GetKept,
}

/// What a target replies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub enum Answer {
    /// Done.
    Done,
    /// Not done, and nothing changed.
    Refused(Refusal),
    /// Who answers.
    Identity(Identity),
    /// Settings in force.
    Settings(Settings),
    /// Model in force.
    Model(Option<ModelRecord>),
    /// Progress of the stream.
    Stream {
        /// Number of the next sample that is expected.
        next: u32,
        /// Samples that there is room for.
        free: u16,
    },
    /// Counters.
    Statistics(Statistics),
    /// What flash holds.
    Kept(Kept),
}

/// Who answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identity {
    /// `hysteron`.
    pub name: [u8; 8],
    /// Version of the firmware: major, minor, patch.
    pub firmware: [u8; 3],
    /// Plays that there is room for.
    pub plays: u8,
    /// Dead zones on each side that there is room for.
    pub dead_zones: u8,
    /// Samples of a stream that there is room for.
    pub stream: u16,
    /// Samples that a preview inverse can look at.
    pub window: u8,
}

/// Why a command is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Refusal {
    /// The frame was whole, but its message is none of this version.
    Unknown,
    /// Not in the present state of the output.
    State,
    /// An earlier command is still being carried out; ask again.
    Busy,
    /// A setting is out of its bounds.
    Settings(SettingsError),
    /// The model is refused.
    Model(RecordError),
    /// A compensated reference needs a model.
    NoModel,
    /// The reference is refused.
    Waveform(WaveformError),
    /// A sample of the stream is infinite or NaN.
    NotFinite,
    /// Samples before this part of the stream are missing.
    Gap,
    /// The flash could not be written, or there is none; what was saved before is still there.
    Flash,
}

/// What a target sends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap to put the larger one on"
)]
pub enum Message {
    /// To the command of this sequence number.
    Reply {
        /// As sent; 0 where it could not be read.
        sequence: u16,
        /// The answer.
        answer: Answer,
    },
    /// Recorded samples, unasked.
    Recorded {
        /// Number of the first one; a distance to the last of the frame before is what was dropped,
        /// and 0 begins a recording.
        first: u32,
        /// Neighbouring samples.
        codes: Vec<Codes, RECORDED_LEN>,
    },
}
