//! Faults by the thousand: a seeded campaign against the firmware's code, on the host or in the emulator.
//!
//! A run powers a target on and injects every [`Kind`] a few times in any order; its seed repeats it.
//! A [`judge`] that asks nothing of the code under test holds every sample and every reply against what
//! was acknowledged; after each fault the target is brought to rest by command and must follow again.

mod dice;
mod failing;
mod json;
pub mod judge;
mod kind;
mod line;
mod material;
mod on_the_bench;
mod on_the_line;
mod page;
mod rig;

use std::collections::BTreeMap;

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

pub use failing::Failing;
pub use json::schema_text;
pub use kind::Kind;
pub use line::framed;
pub use page::page;
pub use rig::{Rig, Stop, Subject};

use crate::error::Error;
use crate::pil::{Pair, Replica};

/// How often each kind is injected in a run.
pub const ROUNDS: usize = 4;

/// Something that must hold and did not.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Failure {
    /// Of the run: repeats it.
    pub seed: u64,
    /// The kind.
    pub fault: &'static str,
    /// What happened, in words.
    pub what: String,
}

/// What came of a kind.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Key in JSON.
    pub key: &'static str,
    /// In words.
    pub name: &'static str,
    /// What was required, beyond what always holds.
    pub required: &'static str,
    /// Faults injected.
    pub injected: u64,
}

/// What came of a campaign.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Of the first run; each further one has the next.
    pub seed: u64,
    /// Runs.
    pub runs: u64,
    /// The firmware in its emulator and the host's replica, compared bit for bit; else the latter alone.
    pub emulated: bool,
    /// By kind.
    pub rows: Vec<Row>,
    /// Samples judged.
    pub samples: u64,
    /// All that did not hold; at most one a run, which ends there.
    pub failures: Vec<Failure>,
}

/// What came of a run.
#[derive(Default)]
struct Ran {
    counts: BTreeMap<&'static str, u64>,
    samples: u64,
    failure: Option<Failure>,
}

impl Outcome {
    /// Faults injected.
    pub fn injected(&self) -> u64 {
        self.rows.iter().map(|row| row.injected).sum()
    }
}

/// Injects one fault of a kind into a target at rest and brings it back to rest.
fn inject<S: Subject>(rig: &mut Rig<S>, kind: Kind, phase: usize) -> Result<(), Stop> {
    use {on_the_bench as bench, on_the_line as line};
    material::furnish(rig)?;
    match kind {
        Kind::BadChecksum => line::spoilt(rig, self::line::bad_checksum),
        Kind::Truncation => line::spoilt(rig, self::line::truncated),
        Kind::Duplicate => line::duplicate(rig),
        Kind::Reordering => line::reordering(rig),
        Kind::RandomFrame => line::random_frame(rig),
        Kind::RandomCommands => line::random_commands(rig),
        Kind::Noise => line::noise(rig),
        Kind::LostReply => line::lost_reply(rig),
        Kind::LinkCut => line::link_cut(rig),
        Kind::Flood => line::flood(rig),
        Kind::StaleReference => line::stale(rig),
        Kind::StreamResets => line::stream_resets(rig),
        Kind::StuckSensor => bench::sensor(rig, false),
        Kind::JumpingSensor => bench::sensor(rig, true),
        Kind::SensorNotFinite => bench::sensor_not_finite(rig),
        Kind::BadSettings => bench::settings_out_of_range(rig),
        Kind::BadModel => bench::bad_model(rig),
        Kind::ReferenceNotFinite => bench::reference_not_finite(rig),
        Kind::ModelSwap => bench::model_swap(rig, phase),
        Kind::ModelRemoved => bench::model_removed(rig),
        Kind::SettingsInMotion => bench::settings_in_motion(rig),
        Kind::Overrun => bench::overrun(rig),
        Kind::Reset => bench::reset(rig),
    }?;
    rig.recovers()
}

/// One run of a seed.
fn one<S: Subject>(subject: S, seed: u64) -> Result<Ran, Error> {
    let mut ran = Ran::default();
    let mut rig = match Rig::new(subject, seed) {
        Ok(rig) => rig,
        Err(stop) => return failed(ran, seed, "power_on", stop),
    };
    let faults = Kind::ALL.len() * ROUNDS;
    for place in rig.dice.order(faults) {
        let (kind, round) = (Kind::ALL[place / ROUNDS], place % ROUNDS);
        let key = kind.words().0;
        *ran.counts.entry(key).or_default() += 1;
        // Neighbouring seeds come to neighbouring phases: fifty runs to all of a cycle.
        let phase = (seed % 1_000) as usize * ROUNDS + round;
        if let Err(stop) = inject(&mut rig, kind, phase) {
            ran.samples = rig.samples();
            return failed(ran, seed, key, stop);
        }
    }
    ran.samples = rig.samples();
    Ok(ran)
}

/// A run that ends at something that did not hold; a target that is gone is an error.
fn failed(mut ran: Ran, seed: u64, fault: &'static str, stop: Stop) -> Result<Ran, Error> {
    match stop {
        Stop::Failed(error) => Err(error),
        Stop::Broken(what) => {
            ran.failure = Some(Failure { seed, fault, what });
            Ok(ran)
        }
    }
}

/// Runs the seeds from `seed` on the host; `done` is called after each.
///
/// # Errors
/// None: what does not hold is in the outcome.
pub fn on_host(seed: u64, runs: u64, done: &(dyn Fn() + Sync)) -> Result<Outcome, Error> {
    on(&Replica::power_on, seed, runs, done)
}

/// The same with any targets, each just powered on for the first time.
///
/// # Errors
/// A target that does not start or is gone.
pub fn on<S: Subject>(
    start: &(dyn Fn() -> Result<S, Error> + Sync),
    seed: u64,
    runs: u64,
    done: &(dyn Fn() + Sync),
) -> Result<Outcome, Error> {
    let ran = each(seed, runs, done, &|seed| one(start()?, seed))?;
    Ok(gathered(seed, false, rows(), ran))
}

/// The same with the firmware in its emulator beside, and a forced panic and hard fault for each run.
///
/// # Errors
/// An emulator that does not start or is gone.
pub fn emulated(
    start: &(dyn Fn() -> Result<Pair, Error> + Sync),
    seed: u64,
    runs: u64,
    done: &(dyn Fn() + Sync),
) -> Result<Outcome, Error> {
    let ran = each(seed, runs, done, &|seed| {
        let mut ran = one(start()?, seed)?;
        if ran.failure.is_some() {
            return Ok(ran);
        }
        for failing in Failing::ALL {
            let key = failing.words().0;
            *ran.counts.entry(key).or_default() += 1;
            match failing.force(start()?, seed) {
                Ok(samples) => ran.samples += samples,
                Err(stop) => return failed(ran, seed, key, stop),
            }
        }
        Ok(ran)
    })?;
    let mut rows = rows();
    rows.extend(Failing::ALL.map(|failing| row(failing.words())));
    Ok(gathered(seed, true, rows, ran))
}

fn each(
    seed: u64,
    runs: u64,
    done: &(dyn Fn() + Sync),
    run: &(dyn Fn(u64) -> Result<Ran, Error> + Sync),
) -> Result<Vec<Ran>, Error> {
    (0..runs)
        .into_par_iter()
        .map(|at| {
            let ran = run(seed.wrapping_add(at));
            done();
            ran
        })
        .collect()
}

fn row((key, name, required): (&'static str, &'static str, &'static str)) -> Row {
    Row {
        key,
        name,
        required,
        injected: 0,
    }
}

fn rows() -> Vec<Row> {
    Kind::ALL.map(|kind| row(kind.words())).into()
}

fn gathered(seed: u64, emulated: bool, mut rows: Vec<Row>, ran: Vec<Ran>) -> Outcome {
    let runs = ran.len() as u64;
    let mut samples = 0;
    let mut failures = Vec::new();
    for one in ran {
        for row in &mut rows {
            row.injected += one.counts.get(row.key).copied().unwrap_or_default();
        }
        samples += one.samples;
        failures.extend(one.failure);
    }
    Outcome {
        seed,
        runs,
        emulated,
        rows,
        samples,
        failures,
    }
}
