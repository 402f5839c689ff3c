//! Programs that fail: a panic, a hard fault and a sample timer that died, forced in the emulated firmware.

use hysteron::settings::Settings;

use super::judge::{OFF, is_code_of};
use super::material::{anywhere, furnish};
use super::rig::{Rig, Stop, broken};
use crate::pil::{Emulator, Pair, Target};

/// Exit code of the emulator after a program that failed.
const FAILED: Option<i32> = Some(101);

/// How a program is made to fail.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Failing {
    /// A Rust panic.
    Panic,
    /// An undefined instruction.
    HardFault,
    /// No samples any more, while the idle loop goes on.
    Starvation,
}

impl Failing {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Panic, Self::HardFault, Self::Starvation];

    /// Its key in JSON, its name, and what is required.
    pub fn words(self) -> (&'static str, &'static str, &'static str) {
        const SAFE: &str = "the code at rest and the driver off, before anything else";
        match self {
            Self::Panic => ("panic", "forced panic, in any state", SAFE),
            Self::HardFault => ("hard_fault", "forced HardFault, in any state", SAFE),
            Self::Starvation => (
                "watchdog_starvation",
                "sample timer stopped, in any state",
                "the watchdog is no longer fed; after its reset off and at rest in the first sample",
            ),
        }
    }

    /// Forces it somewhere on the way, with the throws of this seed; gives the samples before it.
    ///
    /// # Errors
    /// What must not be.
    pub fn force(self, pair: Pair, seed: u64) -> Result<u64, Stop> {
        let mut rig = Rig::new(pair, seed)?;
        furnish(&mut rig)?;
        anywhere(&mut rig)?;
        let (settings, samples) = (rig.judge.settings(), rig.samples());
        let emulator = rig.into_subject().into_emulator();
        match self {
            Self::Panic => fails(emulator, (b'P', "forced"), &settings)?,
            Self::HardFault => fails(emulator, (b'H', "hard fault"), &settings)?,
            Self::Starvation => starves(emulator)?,
        }
        Ok(samples)
    }
}

/// A request that the program does not survive, with a word of what it says at its end.
fn fails(
    mut emulator: Emulator,
    (kind, word): (u8, &str),
    settings: &Settings,
) -> Result<(), Stop> {
    emulator.request(kind, 0, &[])?;
    let response = emulator.response()?;
    let rest_v = f64::from(settings.drive_rest_v);
    let safe = is_code_of(settings, rest_v, response.ticked.code);
    if response.kind != b'F' || !safe || response.ticked.driver_enabled {
        return broken(format!("{response:?} with {settings:?}"));
    }
    let (code, said) = emulator.end()?;
    if code != FAILED || !said.contains(word) {
        return broken(format!("exit code {code:?}: {said}"));
    }
    Ok(())
}

/// The idle loop is asked again and again, samples come only at first. The reset is the host's, in the
/// place of the watchdog that QEMU lacks.
fn starves(mut emulator: Emulator) -> Result<(), Stop> {
    for (kind, fed) in [(b'T', true), (b'L', false), (b'T', true), (b'L', false)] {
        emulator.request(kind, 0, &[])?;
        let response = emulator.response()?;
        if response.fed != fed {
            return broken(format!("the watchdog is fed: {}, not {fed}", response.fed));
        }
    }
    for _ in 0..100 {
        emulator.request(b'L', 0, &[])?;
        if emulator.response()?.fed {
            return broken("the watchdog is fed without samples");
        }
    }
    emulator.reset()?;
    let first = emulator.tick(0, false)?;
    let settings = Settings::default();
    let safe = is_code_of(&settings, f64::from(settings.drive_rest_v), first.code);
    if first.state != OFF || first.driver_enabled || !safe {
        return broken(format!("after the reset: {first:?}"));
    }
    Ok(())
}
