//! One sample: reference, compensator, safety, converter code. Host and target run this very code.
//!
//! What a sample needs is a [`Setup`], built and validated outside the interrupt. There are two of
//! them: the interrupt owns one by a `&mut`, the link prepares the other, sends it over a queue and
//! gets the first one back, so a swap between two samples is an exchange of two pointers.

use core::mem;

use heapless::spsc::{Consumer, Producer};
use serde::{Deserialize, Serialize};

use crate::dac;
use crate::record::{ModelRecord, Motion, RecordError, TargetCompensator};
use crate::reference::{Reference, Stream};
use crate::replay::Replay;
use crate::safety::{Cause, Limits, Safety, State};
use crate::settings::Valid;
use crate::telemetry::{Codes, Sample, Samples, Shared};

/// Orders that fit between link and interrupt, one less than this.
pub const ORDERS_LEN: usize = 4;
/// Setups on their way back, one less than this: there is only one to return.
pub const RETIRED_LEN: usize = 2;

/// The interrupt's end of the orders.
pub type Orders<'a> = Consumer<'a, Order<'a>, ORDERS_LEN>;
/// The interrupt's end of the setups that go back.
pub type Retired<'a> = Producer<'a, &'a mut Setup, RETIRED_LEN>;

/// What a reference means.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Path {
    /// Displacement in um: through the compensator.
    Compensated,
    /// Drive in V: past the compensator, for excitations and for comparison.
    Direct,
}

/// What the interrupt works with; built by [`Setup::new`] and [`Setup::prepare`].
#[derive(Clone, Debug)]
pub struct Setup {
    limits: Limits,
    dac: dac::Scale,
    miss_limit: u32,
    compensator: Option<TargetCompensator>,
    latency: u32,
}

impl Setup {
    /// For validated settings and no model.
    pub fn new(settings: &Valid) -> Self {
        Self {
            limits: settings.limits,
            dac: settings.dac,
            miss_limit: u32::from(settings.miss_limit),
            compensator: None,
            latency: 0,
        }
    }

    /// Samples between a reference sample and its drive.
    pub fn latency(&self) -> u32 {
        self.latency
    }

    /// Makes this setup that of `settings` and `model`.
    ///
    /// # Errors
    /// A model that is refused; the setup is as it was.
    #[inline(never)]
    pub fn prepare(
        &mut self,
        settings: &Valid,
        model: Option<&ModelRecord>,
    ) -> Result<(), RecordError> {
        match model {
            Some(record) => record.put_compensator(settings.sample_time, &mut self.compensator)?,
            None => self.compensator = None,
        }
        let latency = self.compensator.as_ref().map(TargetCompensator::latency);
        self.latency = latency.unwrap_or(0) as u32;
        // Field by field: a whole setup on its way would double its room on the stack.
        let bench = Self::new(settings);
        (self.limits, self.dac, self.miss_limit) = (bench.limits, bench.dac, bench.miss_limit);
        Ok(())
    }
}

/// What the link wants from the interrupt; at most one is obeyed a sample.
#[derive(Debug)]
pub enum Order<'a> {
    /// A new setup. The output goes on from where it stands; only with the driver disabled does it
    /// move to the new rest at once.
    Adopt(&'a mut Setup),
    /// Plays a reference, for `left` samples or, with `None`, until told otherwise; then holds. It
    /// begins in the sample after that of the order, and a recording that runs numbers its samples
    /// from there.
    Start {
        /// The reference at its first sample.
        reference: Reference,
        /// What it means.
        path: Path,
        /// Samples to play.
        left: Option<u32>,
    },
    /// Stands still.
    Hold,
    /// Ramps to rest.
    Stop,
    /// Leaves a fault.
    Clear,
    /// Drops this many samples from the front of the stream, a few in each sample; not while a
    /// stream is played.
    DropStream(u32),
    /// Records one sample in this many, from now on; zero ends the recording.
    Record(u32),
}

/// What goes to the hardware after a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// The converter.
    pub dac: dac::Kind,
    /// Code for the converter.
    pub code: u16,
    /// Whether the amplifier is to be driven.
    pub driver_enabled: bool,
}

/// The control of one output.
pub struct Control<'a> {
    setup: &'a mut Setup,
    orders: Orders<'a>,
    retired: Retired<'a>,
    stream: Stream<'a>,
    samples: Samples<'a>,
    shared: &'a Shared,
    safety: Safety,
    reference: Reference,
    path: Path,
    left: Option<u32>,
    replay: Replay,
    motion: Motion,
    /// Samples until the drive of the next sample of the reference comes out of the compensator.
    wait: u32,
    to_drop: u32,
    /// A start or a swap of the setup was obeyed. It costs much, and so does the first sample after it:
    /// the output stands still in the sample of the order, and the next one obeys none.
    begins: bool,
    record_every: u32,
    record_wait: u32,
    record_index: u32,
    misses_since_start: u32,
}

impl<'a> Control<'a> {
    /// Off, at rest.
    pub fn new(
        setup: &'a mut Setup,
        orders: Orders<'a>,
        retired: Retired<'a>,
        stream: Stream<'a>,
        samples: Samples<'a>,
        shared: &'a Shared,
    ) -> Self {
        let safety = Safety::new(&setup.limits);
        Self {
            setup,
            orders,
            retired,
            stream,
            samples,
            shared,
            safety,
            reference: Reference::Stream,
            path: Path::Direct,
            left: None,
            replay: Replay::new(),
            motion: Motion::Begins,
            wait: 0,
            to_drop: 0,
            begins: false,
            record_every: 0,
            record_wait: 0,
            record_index: 0,
            misses_since_start: 0,
        }
    }

    /// One sample. `sensor` is the code read at its beginning, `late` tells that the sample before
    /// it was still being computed when this one was due.
    #[inline(always)]
    pub fn tick(&mut self, sensor: u16, late: bool) -> Output {
        if self.begins {
            self.begins = false;
        } else if self.orders.ready() {
            self.obey();
        }
        if self.to_drop != 0 {
            self.drop_some();
        }
        if late {
            self.miss();
        }
        if !self.begins {
            self.advance();
        }
        let drive = self.safety.output();
        let codes = Codes {
            drive: self.setup.dac.code(drive),
            sensor,
        };
        if self.record_every != 0 {
            self.record(codes);
        }
        let driver_enabled = self.safety.driver_enabled(&self.setup.limits);
        self.shared.publish(codes, driver_enabled, &self.safety);
        Output {
            dac: self.setup.dac.kind(),
            code: codes.drive,
            driver_enabled,
        }
    }

    /// Moves the output on by a sample.
    #[inline(always)]
    fn advance(&mut self) {
        let target = match self.safety.state() {
            State::Run => self.target(),
            _ => None,
        };
        let limits = &self.setup.limits;
        match target {
            // `target` leaves the state alone when there is one.
            Some(target) => self.safety.follow(limits, target),
            None => self.safety.stay(limits),
        }
    }

    /// The drive that the next reference sample asks for; `None` when it did not come or came to an
    /// end.
    #[inline(always)]
    fn target(&mut self) -> Option<f32> {
        let reference = self.next_reference()?;
        let drive = match (self.path, &mut self.setup.compensator) {
            (Path::Direct, _) => reference,
            (Path::Compensated, Some(compensator)) => {
                let drive = compensator.step(reference, self.motion);
                // The safety turns what is not finite into a fault.
                drive.unwrap_or(f32::NAN)
            }
            (Path::Compensated, None) => {
                self.safety.fault(Cause::NoModel);
                return None;
            }
        };
        self.motion = Motion::Goes;
        if self.wait != 0 {
            self.wait -= 1;
        } else {
            self.replay.put_out();
            self.shared.count_played();
        }
        Some(drive)
    }

    #[inline(always)]
    fn next_reference(&mut self) -> Option<f32> {
        if let Some(again) = self.replay.again() {
            return Some(again);
        }
        if let Some(left) = &mut self.left {
            if *left == 0 {
                // It rests at its last sample until the drive of that has come out, too.
                let last = self.replay.last();
                if last.is_none() {
                    self.safety.hold();
                }
                return last;
            }
            *left -= 1;
        }
        let Some(reference) = self.reference.next(&mut self.stream) else {
            // The sample is still to come.
            self.left = self.left.map(|left| left.wrapping_add(1));
            if self.motion == Motion::Goes {
                self.motion = Motion::Resumes;
            }
            return None;
        };
        self.replay.push(reference);
        Some(reference)
    }

    /// Puts the next setup in force. In mid-motion its compensator takes over from the one before: it
    /// is given what that one had only looked at, and the output stands still until the first drive
    /// of it comes.
    fn adopt(&mut self, next: &'a mut Setup) {
        let before = mem::replace(&mut self.setup, next);
        if self.safety.driver_enabled(&before.limits) {
            self.safety.join();
        } else {
            self.safety.reset_output(&self.setup.limits);
        }
        if self.path == Path::Compensated {
            self.motion = Motion::Begins;
            self.wait = self.setup.latency;
            let last = self.replay.rewind();
            if self.safety.state() == State::Run
                && let Some(last) = last
                && let Some(compensator) = &mut self.setup.compensator
                && let Some(before) = &mut before.compensator
            {
                self.motion = compensator.take_over(before, last);
            }
        }
        // There is room: the queue holds the only other setup there is.
        let _ = self.retired.enqueue(before);
    }

    #[inline(never)]
    fn obey(&mut self) {
        let Some(order) = self.orders.dequeue() else {
            return;
        };
        match order {
            Order::Adopt(next) => {
                self.adopt(next);
                self.begins = true;
            }
            Order::Start {
                reference,
                path,
                left,
            } => {
                (self.reference, self.path, self.left) = (reference, path, left);
                self.misses_since_start = 0;
                self.shared.start();
                // A recording begins anew, so that its sample 0 is that of the reference.
                let wait = match path {
                    Path::Compensated => self.setup.latency,
                    Path::Direct => 0,
                };
                self.replay.clear();
                (self.motion, self.wait) = (Motion::Begins, wait);
                (self.record_wait, self.record_index) = (1 + wait, 0);
                self.safety.run();
                if let Some(compensator) = &mut self.setup.compensator {
                    compensator.begin();
                }
                self.begins = true;
            }
            Order::Hold => self.safety.hold(),
            Order::Stop => self.safety.off(),
            Order::Clear => {
                self.misses_since_start = 0;
                self.safety.clear();
            }
            Order::DropStream(count) => self.to_drop = count,
            Order::Record(every) => {
                (self.record_every, self.record_wait, self.record_index) = (every, 0, 0);
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn drop_some(&mut self) {
        const A_SAMPLE: u32 = 8;
        for _ in 0..A_SAMPLE {
            if self.to_drop != 0 {
                self.to_drop -= 1;
                let _ = self.stream.dequeue();
            }
        }
    }

    #[cold]
    #[inline(never)]
    fn miss(&mut self) {
        self.shared.count_miss();
        self.misses_since_start = self.misses_since_start.saturating_add(1);
        if self.misses_since_start > self.setup.miss_limit {
            self.safety.fault(Cause::Deadline);
        }
    }

    #[inline(always)]
    fn record(&mut self, codes: Codes) {
        if self.record_wait != 0 {
            self.record_wait -= 1;
            return;
        }
        self.record_wait = self.record_every - 1;
        let index = self.record_index;
        self.record_index = index.wrapping_add(1);
        if self.samples.enqueue(Sample { index, codes }).is_err() {
            self.shared.count_dropped();
        }
    }

    /// What the output does, for tests and displays.
    pub fn safety(&self) -> &Safety {
        &self.safety
    }
}
