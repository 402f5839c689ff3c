//! The independent watchdog of an STM32, on its internal slow oscillator: 32 kHz by name. The data sheets
//! allow that of the STM32F405 17 to 47 kHz, that of the STM32H743 29.4 to 33.6 kHz; times here are those at
//! 32 kHz, and at 47 and 17 kHz.

use super::device::{IWDG, iwdg};

fn registers() -> &'static iwdg::RegisterBlock {
    // SAFETY: single writes, by the idle loop alone once the board was started.
    unsafe { &*IWDG::ptr() }
}

/// Starts it: from now on it must be fed, every 50 ms (34 to 94 ms).
pub fn start() {
    registers().kr().write(|w| w.key().start());
    set_short();
}

/// Begins another period.
pub fn feed() {
    registers().kr().write(|w| w.key().feed());
}

/// 8.2 s (5.6 to 15.4 s) from now: flash is going to make the core stand still.
pub fn wait_long() {
    registers().kr().write(|w| w.key().unlock());
    registers().pr().write(|w| w.pr().divide_by64());
    registers().rlr().write(|w| w.rl().set(4095));
    settle();
}

/// 50 ms (34 to 94 ms) again, from now.
pub fn wait_short() {
    set_short();
    settle();
}

fn set_short() {
    registers().kr().write(|w| w.key().unlock());
    registers().pr().write(|w| w.pr().divide_by4());
    registers().rlr().write(|w| w.rl().set(400));
}

/// The registers are taken over within five cycles behind the divider, 10 ms (7 to 19 ms) with the longer.
fn settle() {
    while registers().sr().read().bits() != 0 {}
    feed();
}
