//! What long work shows on the terminal; nothing where the error output is not one.

use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

/// A line that tells what is done now and for how long already.
pub fn steps(title: &'static str) -> ProgressBar {
    let bar = ProgressBar::new_spinner().with_prefix(title);
    if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix}: {wide_msg} {elapsed}") {
        bar.set_style(style);
    }
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// A bar of so many equal pieces of work.
pub fn bar(title: &'static str, pieces: u64) -> ProgressBar {
    let bar = ProgressBar::new(pieces).with_prefix(title);
    if let Ok(style) =
        ProgressStyle::with_template("{prefix}: {wide_bar} {pos}/{len} {elapsed} (eta {eta})")
    {
        bar.set_style(style);
    }
    bar
}
