//! The queues between link and interrupt, and both ends connected to them: the same on the target, in
//! a host's replica of it, and in tests.

use heapless::Vec;
use heapless::spsc::Queue;

use crate::control::{Control, ORDERS_LEN, Order, RETIRED_LEN, Setup};
use crate::link::{Server, Wires};
use crate::reference::STREAM_LEN;
use crate::settings::{Settings, SettingsError, Valid};
use crate::store::{Boot, Keep, Unfit};
use crate::telemetry::{QUEUE_LEN, Sample, Shared};

/// Memory that link and interrupt share, without a lock: every queue has one writer and one reader.
pub struct Memory<'a> {
    orders: Queue<Order<'a>, ORDERS_LEN>,
    retired: Queue<&'a mut Setup, RETIRED_LEN>,
    stream: Queue<f32, STREAM_LEN>,
    samples: Queue<Sample, QUEUE_LEN>,
    /// Filled by `connect`: an empty vector costs no initial values in flash.
    setups: Vec<Setup, 2>,
    shared: Shared,
}

impl Default for Memory<'_> {
    fn default() -> Self {
        Self::new()
    }
}

impl<'a> Memory<'a> {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            orders: Queue::new(),
            retired: Queue::new(),
            stream: Queue::new(),
            samples: Queue::new(),
            setups: Vec::new(),
            shared: Shared::new(),
        }
    }

    /// Two setups. A function of its own: their room on the stack is free again when a model comes.
    #[inline(never)]
    fn set_up(&mut self, valid: &Valid) {
        self.setups.clear();
        for _ in 0..2 {
            let _ = self.setups.push(Setup::new(valid));
        }
    }

    /// The interrupt's end, off and at rest, the link's end, and the counters.
    ///
    /// # Errors
    /// Settings that are out of their bounds.
    pub fn connect(
        &'a mut self,
        settings: Settings,
    ) -> Result<(Control<'a>, Server<'a>, &'a Shared), SettingsError> {
        self.connect_kept(Boot::new(settings)?, None)
    }

    /// The same with what was saved in force, and a place to save to.
    ///
    /// # Errors
    /// None.
    pub fn connect_kept(
        &'a mut self,
        mut boot: Boot,
        keep: Option<&'a mut (dyn Keep + Send)>,
    ) -> Result<(Control<'a>, Server<'a>, &'a Shared), SettingsError> {
        let valid = &boot.valid;
        self.set_up(valid);
        let [active, spare] = self.setups.as_mut_slice() else {
            // Never taken: both were just put there.
            return Err(SettingsError::Version);
        };
        if let Err(error) = active.prepare(valid, boot.model.as_ref()) {
            boot.model = None;
            boot.unfit = Some(Unfit::Model(error));
        }
        let latency = active.latency();
        let (to_orders, orders) = self.orders.split();
        let (to_retired, retired) = self.retired.split();
        let (to_stream, stream) = self.stream.split();
        let (to_samples, samples) = self.samples.split();
        let shared = &self.shared;
        let control = Control::new(active, orders, to_retired, stream, to_samples, shared);
        let wires = Wires {
            spare,
            orders: to_orders,
            retired,
            stream: to_stream,
            recorded: samples,
            shared,
            keep,
        };
        Ok((control, Server::new(boot, latency, wires), shared))
    }
}
