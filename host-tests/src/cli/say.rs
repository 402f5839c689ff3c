//! A summary on the standard output, in lines or as JSON; that may be a full disk or a pipe that nobody
//! reads.

use std::fmt::Arguments;
use std::io::{self, ErrorKind, Write};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::Value;

use hysteron_host::error::{Error, Place};

static AS_JSON: AtomicBool = AtomicBool::new(false);
static HEARD: AtomicBool = AtomicBool::new(true);
static REFUSED: OnceLock<io::Error> = OnceLock::new();

/// From now on figures are JSON, and lines for a person to read are left out.
pub fn set_json() {
    AS_JSON.store(true, Ordering::Relaxed);
}

/// Whether figures are to be JSON.
pub fn is_json() -> bool {
    AS_JSON.load(Ordering::Relaxed)
}

/// Writes figures, where they are to be JSON, on a line.
pub fn figures(value: &Value) {
    if is_json() {
        write(format_args!("{value}"));
    }
}

/// Writes one line, where figures are not to be JSON.
pub fn line(text: Arguments<'_>) {
    if !is_json() {
        write(text);
    }
}

/// Writes one line; a refusal is kept for [`refusal`], so that the work itself goes on.
fn write(text: Arguments<'_>) {
    let mut out = io::stdout().lock();
    let written = out.write_fmt(text).and_then(|()| out.write_all(b"\n"));
    keep(written);
}

/// What the system refused of all lines; a reader that has gone away has seen what it wanted.
///
/// # Errors
/// The first refusal.
pub fn refusal() -> Result<(), Error> {
    keep(io::stdout().flush());
    match REFUSED.get() {
        Some(refused) => Err(Place::file("standard output").io_error(
            "cannot write",
            "free some space or write elsewhere; files that were asked for are written",
            io::Error::new(refused.kind(), refused.to_string()),
        )),
        None => Ok(()),
    }
}

/// Whether there is any use in another line.
pub fn is_heard() -> bool {
    HEARD.load(Ordering::Relaxed)
}

fn keep(written: io::Result<()>) {
    let Err(refused) = written else { return };
    HEARD.store(false, Ordering::Relaxed);
    if refused.kind() != ErrorKind::BrokenPipe {
        let _ = REFUSED.set(refused);
    }
}

/// [`println!`] without its panic.
macro_rules! say {
    ($($text:tt)*) => {
        $crate::cli::say::line(format_args!($($text)*))
    };
}
pub(crate) use say;
