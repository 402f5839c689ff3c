//! The independent watchdog of an STM32: 32 kHz, 17 to 47 kHz.

use super::device::{IWDG, iwdg};

const START: u16 = 0xcccc;
const UNLOCK: u16 = 0x5555;
const FEED: u16 = 0xaaaa;

fn registers() -> &'static iwdg::RegisterBlock {
    // SAFETY: single writes of keys and periods, by the idle loop alone once the board was started.
    unsafe { &*IWDG::ptr() }
}

/// Starts it: from now on it must be fed, every 50 ms.
pub fn start() {
    // SAFETY: a key of the reference manual.
    registers().kr().write(|w| unsafe { w.bits(START.into()) });
    set(0, 400);
}

/// Begins another period.
pub fn feed() {
    // SAFETY: a key of the reference manual.
    registers().kr().write(|w| unsafe { w.bits(FEED.into()) });
}

/// 8 s, 5.5 s at the least, from now: flash is going to make the core stand still.
pub fn wait_long() {
    set(4, 4095);
    settle();
}

/// 50 ms again, from now.
pub fn wait_short() {
    set(0, 400);
    settle();
}

/// 32 kHz / 4 / 2^`prescaler`, `reload` counts.
fn set(prescaler: u8, reload: u16) {
    // SAFETY: a key, a prescaler and a reload value of the reference manual.
    unsafe {
        registers().kr().write(|w| w.bits(UNLOCK.into()));
        registers().pr().write(|w| w.bits(prescaler.into()));
        registers().rlr().write(|w| w.bits(reload.into()));
    }
}

/// The registers are taken over within five of its own cycles, some 10 ms at the slowest.
fn settle() {
    while registers().sr().read().bits() != 0 {}
    feed();
}
