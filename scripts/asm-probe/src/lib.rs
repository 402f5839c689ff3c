#![no_std]
//! The plain bank's step in its final types, compiled but never run:
//! `scripts/check-play-instructions.sh` counts its instructions.

use hysteron::play::{Envelope, PlainState, PlayBank};

/// Step of a bank with room for ten plays.
#[inline(never)]
pub fn plain_step(
    state: &mut PlainState<f32, 10>,
    bank: &PlayBank<f32, 10>,
    envelope: Envelope<f32>,
) -> f32 {
    state.step(bank, envelope)
}
