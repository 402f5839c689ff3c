//! The core on the host in place of the target, and both side by side.

use std::sync::{Arc, Mutex, PoisonError};

use hysteron::control::Control;
use hysteron::link::Server;
use hysteron::safety::State;
use hysteron::store::{Boot, FlashError, Keep, RamFlash, Saved, Store, Unfit};
use hysteron::telemetry::Shared;
use hysteron::wiring::Memory;

use super::emulator::Emulator;
use super::target::{Target, Ticked, has_room};
use crate::error::Error;

/// The code that the firmware runs in its interrupt and beside it, on the host.
pub struct Replica {
    control: Control<'static>,
    server: Server<'static>,
    shared: &'static Shared,
    flash: Flash,
}

/// What stays through a reset, as the emulated firmware has it.
#[derive(Clone, Default)]
struct Flash(Arc<Mutex<RamFlash>>);

impl Flash {
    fn with<T>(&self, use_store: impl FnOnce(&mut Store<&mut RamFlash>) -> T) -> T {
        // Whoever panicked before left the flash as a power cut would.
        let mut flash = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        use_store(&mut Store::new(&mut *flash))
    }
}

impl Keep for Flash {
    fn load(&mut self) -> Result<Option<Saved>, Unfit> {
        self.with(|store| store.load())
    }

    fn save(&mut self, saved: &Saved) -> Result<(), FlashError> {
        self.with(|store| store.save(saved))
    }
}

impl Replica {
    /// As the firmware is after power-on. Its queues, some 20 KiB, are statics on the target and live
    /// as long as the program here.
    ///
    /// # Errors
    /// None: the settings of power-on are valid.
    pub fn power_on() -> Result<Self, Error> {
        Self::start(Flash::default())
    }

    /// As the firmware is after a reset: what was saved is in force, all else is gone. Its queues are new
    /// ones, and the old ones stay: they refer into themselves, so that nothing short of `unsafe` could
    /// free or reuse them, but a thread that has them on its stack, at the cost of a message each sample.
    ///
    /// # Errors
    /// None, as above.
    pub fn restart(&mut self) -> Result<(), Error> {
        *self = Self::start(self.flash.clone())?;
        Ok(())
    }

    fn start(flash: Flash) -> Result<Self, Error> {
        let refused =
            |error| Error::request(format!("the settings of power-on are refused: {error:?}"));
        let keep = Box::leak(Box::new(flash.clone()));
        let boot = Boot::load(keep).map_err(refused)?;
        let memory = Box::leak(Box::new(Memory::new()));
        let connected = memory.connect_kept(boot, Some(keep));
        let (control, server, shared) = connected.map_err(refused)?;
        Ok(Self {
            control,
            server,
            shared,
            flash,
        })
    }
}

impl Target for Replica {
    fn tick(&mut self, sensor: u16, late: bool) -> Result<Ticked, Error> {
        let output = self.control.tick(sensor, late);
        Ok(Ticked {
            state: match self.shared.statistics(0).state {
                State::Off => 0,
                State::Hold => 1,
                State::Run => 2,
                State::Fault => 3,
            },
            code: output.code,
            driver_enabled: output.driver_enabled,
            instructions: 0,
        })
    }

    fn chunk(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error> {
        let mut answer = Vec::new();
        for &byte in bytes {
            answer.extend_from_slice(self.server.receive(byte).unwrap_or_default());
        }
        while has_room(answer.len())
            && let Some(frame) = self.server.recorded(false)
        {
            answer.extend_from_slice(frame);
        }
        Ok(answer)
    }
}

/// The firmware in its emulator and the replica, given the same and compared in everything they do.
pub struct Pair {
    emulator: Emulator,
    replica: Replica,
    /// Samples so far.
    samples: u64,
    first_difference: Option<String>,
}

impl Pair {
    /// Both after power-on.
    pub fn new(emulator: Emulator, replica: Replica) -> Self {
        Self {
            emulator,
            replica,
            samples: 0,
            first_difference: None,
        }
    }

    /// Resets both: what was saved is in force, all else is gone.
    ///
    /// # Errors
    /// A target that failed or is gone.
    pub fn reset(&mut self) -> Result<(), Error> {
        self.replica.restart()?;
        self.emulator.reset()
    }

    /// Samples that were compared.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The first sample or link answer in which the two differed, in words; `None` while they agree
    /// bit for bit.
    pub fn first_difference(&self) -> Option<&str> {
        self.first_difference.as_deref()
    }

    /// The firmware alone, once everything was compared.
    pub fn into_emulator(self) -> Emulator {
        self.emulator
    }
}

impl Target for Pair {
    /// Of the firmware; the replica computes while the emulator does.
    fn tick(&mut self, sensor: u16, late: bool) -> Result<Ticked, Error> {
        self.emulator.request_tick(sensor, late)?;
        let here = self.replica.tick(sensor, late)?;
        let there = self.emulator.ticked()?;
        let same = Ticked {
            instructions: 0,
            ..there
        } == here;
        if !same && self.first_difference.is_none() {
            self.first_difference = Some(format!(
                "sample {}: the firmware put out code {} and the host {}, state {} and {}",
                self.samples, there.code, here.code, there.state, here.state
            ));
        }
        self.samples += 1;
        Ok(there)
    }

    fn chunk(&mut self, bytes: &[u8]) -> Result<Vec<u8>, Error> {
        self.emulator.request(b'L', 0, bytes)?;
        let here = self.replica.chunk(bytes)?;
        let there = self.emulator.linked()?;
        if here != there && self.first_difference.is_none() {
            self.first_difference = Some(format!(
                "after sample {}: the firmware answered {} bytes on the link and the host {} others",
                self.samples,
                there.len(),
                here.len()
            ));
        }
        Ok(there)
    }
}
