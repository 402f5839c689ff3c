//! The independent watchdog of an STM32: 32 kHz, 17 to 47 kHz.

use super::device::{IWDG, iwdg};

fn registers() -> &'static iwdg::RegisterBlock {
    // SAFETY: single writes, by the idle loop alone once the board was started.
    unsafe { &*IWDG::ptr() }
}

/// Starts it: from now on it must be fed, every 50 ms.
pub fn start() {
    registers().kr().write(|w| w.key().start());
    set_short();
}

/// Begins another period.
pub fn feed() {
    registers().kr().write(|w| w.key().feed());
}

/// 8 s, 5.5 s at the least, from now: flash is going to make the core stand still.
pub fn wait_long() {
    registers().kr().write(|w| w.key().unlock());
    registers().pr().write(|w| w.pr().divide_by64());
    registers().rlr().write(|w| w.rl().set(4095));
    settle();
}

/// 50 ms again, from now.
pub fn wait_short() {
    set_short();
    settle();
}

fn set_short() {
    registers().kr().write(|w| w.key().unlock());
    registers().pr().write(|w| w.pr().divide_by4());
    registers().rlr().write(|w| w.rl().set(400));
}

/// The registers are taken over within five of its own cycles, some 10 ms at the slowest.
fn settle() {
    while registers().sr().read().bits() != 0 {}
    feed();
}
