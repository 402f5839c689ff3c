//! What leaves the interrupt: samples through a queue, counters through atomics.

use core::sync::atomic::{AtomicU32, Ordering};

use heapless::spsc::{Consumer, Producer};
use serde::{Deserialize, Serialize};

use crate::safety::{Cause, Safety, State};

/// Samples that fit between interrupt and link, one less than this: 51 ms at 10 kHz.
pub const QUEUE_LEN: usize = 512;

/// The interrupt's end of the samples.
pub type Samples<'a> = Producer<'a, Sample, QUEUE_LEN>;

/// The link's end of the samples.
pub type Recorded<'a> = Consumer<'a, Sample, QUEUE_LEN>;

/// One recorded sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Number of the sample since the recording or its reference began; a gap is what was dropped.
    pub index: u32,
    /// Codes of this sample.
    pub codes: Codes,
}

/// Codes of one sample: the drive that was put out in it, and the sensor as it was just before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Codes {
    /// Code of the digital-to-analog converter.
    #[serde(with = "postcard::fixint::le")]
    pub drive: u16,
    /// Code of the sensor's converter.
    #[serde(with = "postcard::fixint::le")]
    pub sensor: u16,
}

/// What the interrupt tells the rest; one writer, so plain loads and stores are enough.
#[derive(Debug)]
pub struct Shared {
    ticks: AtomicU32,
    /// State, cause and whether the driver is enabled, a byte each.
    status: AtomicU32,
    codes: AtomicU32,
    misses: AtomicU32,
    underruns: AtomicU32,
    limited: AtomicU32,
    dropped: AtomicU32,
    played: AtomicU32,
}

/// A snapshot of the counters. All of them wrap and none is reset before power-off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statistics {
    /// What the output does.
    pub state: State,
    /// Why it is in a fault.
    pub cause: Option<Cause>,
    /// Whether the amplifier is driven.
    pub driver_enabled: bool,
    /// Samples since power-on.
    pub ticks: u32,
    /// Samples that were computed too late.
    pub misses: u32,
    /// How often a stream ran dry.
    pub underruns: u32,
    /// Samples in which range or slew held the output back.
    pub limited: u32,
    /// Recorded samples that did not fit into the queue.
    pub dropped: u32,
    /// Reference samples played since the start of the reference.
    pub played: u32,
    /// Latest codes.
    pub codes: Codes,
    /// Frames that were turned away, counted by the link.
    pub bad_frames: u32,
    /// Samples between one of a compensated reference and its drive, by the model that the link sent
    /// last.
    pub latency: u16,
}

/// The number after those of the causes. As it is what the compiler keeps in memory for no cause, too,
/// telling takes no case distinction; told in exclusive or with it, no cause is zero.
const NO_CAUSE: u32 = 3;

/// Whether samples go on: only then is a watchdog fed, so that a timer or an interrupt that died ends in
/// a reset, as does an idle loop that no longer asks.
#[derive(Debug)]
pub struct Alive {
    seen: u32,
}

impl Alive {
    /// Says yes once, then as samples come.
    pub fn new(shared: &Shared) -> Self {
        Self {
            seen: shared.ticks().wrapping_sub(1),
        }
    }

    /// Whether there was a sample since the last question.
    pub fn goes_on(&mut self, shared: &Shared) -> bool {
        let ticks = shared.ticks();
        core::mem::replace(&mut self.seen, ticks) != ticks
    }
}

impl Default for Shared {
    fn default() -> Self {
        Self::new()
    }
}

/// Adds one; only the interrupt writes, so a load and a store are enough.
#[inline(always)]
fn count(counter: &AtomicU32) {
    let next = counter.load(Ordering::Relaxed).wrapping_add(1);
    counter.store(next, Ordering::Relaxed);
}

impl Shared {
    /// All zero: off, no sample yet.
    pub const fn new() -> Self {
        Self {
            ticks: AtomicU32::new(0),
            status: AtomicU32::new(0),
            codes: AtomicU32::new(0),
            misses: AtomicU32::new(0),
            underruns: AtomicU32::new(0),
            limited: AtomicU32::new(0),
            dropped: AtomicU32::new(0),
            played: AtomicU32::new(0),
        }
    }

    /// Called once a sample by the interrupt.
    #[inline(always)]
    pub(crate) fn publish(&self, codes: Codes, driver_enabled: bool, safety: &Safety) {
        count(&self.ticks);
        self.limited.store(safety.limited(), Ordering::Relaxed);
        self.underruns.store(safety.underruns(), Ordering::Relaxed);
        let packed = u32::from(codes.drive) | u32::from(codes.sensor) << 16;
        self.codes.store(packed, Ordering::Relaxed);
        let cause = safety.cause().map_or(NO_CAUSE, |cause| cause as u32) ^ NO_CAUSE;
        let enabled = u32::from(driver_enabled) << 16;
        self.status.store(
            safety.state() as u32 | cause << 8 | enabled,
            Ordering::Relaxed,
        );
    }

    /// A reference begins.
    #[inline(always)]
    pub(crate) fn start(&self) {
        self.played.store(0, Ordering::Relaxed);
    }

    /// A reference sample was played.
    #[inline(always)]
    pub(crate) fn count_played(&self) {
        count(&self.played);
    }

    /// A sample came too late.
    #[inline(always)]
    pub(crate) fn count_miss(&self) {
        count(&self.misses);
    }

    /// A recorded sample did not fit into the queue.
    #[inline(always)]
    pub(crate) fn count_dropped(&self) {
        count(&self.dropped);
    }

    /// Samples since power-on; wraps. It standing still tells a watchdog that the interrupt died.
    pub fn ticks(&self) -> u32 {
        self.ticks.load(Ordering::Relaxed)
    }

    /// Everything; the link knows the rest.
    pub fn statistics(&self, bad_frames: u32) -> Statistics {
        let status = self.status.load(Ordering::Relaxed);
        let codes = self.codes.load(Ordering::Relaxed);
        Statistics {
            state: match status & 0xff {
                1 => State::Hold,
                2 => State::Run,
                3 => State::Fault,
                _ => State::Off,
            },
            cause: match status >> 8 & 0xff ^ NO_CAUSE {
                0 => Some(Cause::NotFinite),
                1 => Some(Cause::Deadline),
                2 => Some(Cause::NoModel),
                _ => None,
            },
            driver_enabled: status >> 16 & 1 == 1,
            ticks: self.ticks(),
            misses: self.misses.load(Ordering::Relaxed),
            underruns: self.underruns.load(Ordering::Relaxed),
            limited: self.limited.load(Ordering::Relaxed),
            dropped: self.dropped.load(Ordering::Relaxed),
            played: self.played.load(Ordering::Relaxed),
            codes: Codes {
                drive: codes as u16,
                sensor: (codes >> 16) as u16,
            },
            bad_frames,
            latency: 0,
        }
    }
}
