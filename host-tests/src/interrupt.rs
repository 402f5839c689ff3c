//! Ctrl-C while a stage moves: the work in hand hears of it and ends the motion first.
//!
//! Without a [`Deferred`] alive an interrupt ends the process at once, see
//! [`crate::output::remove_unfinished_on_interrupt`]. A second interrupt always does.

use std::sync::atomic::{AtomicU8, Ordering};

const AT_ONCE: u8 = 0;
const DEFERRED: u8 = 1;
const REQUESTED: u8 = 2;

static STATE: AtomicU8 = AtomicU8::new(AT_ONCE);

/// While it lives, the first interrupt is noted and the process goes on.
#[derive(Debug)]
#[must_use = "an interrupt ends the process at once when this is dropped"]
pub struct Deferred(());

impl Deferred {
    /// From now on.
    pub fn begin() -> Self {
        let _ = STATE.compare_exchange(AT_ONCE, DEFERRED, Ordering::SeqCst, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for Deferred {
    fn drop(&mut self) {
        STATE.store(AT_ONCE, Ordering::SeqCst);
    }
}

/// Whether an interrupt came that is to be obeyed as soon as the stage allows.
pub fn requested() -> bool {
    STATE.load(Ordering::SeqCst) == REQUESTED
}

/// Called by the signal's handler: whether somebody else takes care of the interrupt.
pub(crate) fn defer() -> bool {
    STATE
        .compare_exchange(DEFERRED, REQUESTED, Ordering::SeqCst, Ordering::SeqCst)
        .is_ok()
}
