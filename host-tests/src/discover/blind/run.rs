//! Hides and diagnoses all cases of a plan, one a core at a time.

use std::num::NonZero;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use cpu_time::ThreadTime;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::dataset::Role;
use crate::discover::baseline::Baseline;
use crate::discover::diagnosis::excess;
use crate::discover::{Diagnosis, Options, baseline_alone, diagnose};
use crate::error::Error;
use crate::identify::Effect;
use crate::plant::hidden::{Hidden, HiddenCase};

use super::outcome::{Answer, Named, Outcome};
use super::plan::Plan;
use super::scores::Scores;

/// Stack of a thread that diagnoses, in bytes: models with many plays lie on it.
const STACK: usize = 16 << 20;
/// A hidden effect that the usual baseline has already.
const RATE: &str = "rate-dependence";

/// All cases with their answers.
#[derive(Clone, Debug)]
pub struct Blind {
    /// What was hidden.
    pub plan: Plan,
    /// The cases in the order of their seeds.
    pub outcomes: Vec<Outcome>,
    /// What they come to.
    pub scores: Scores,
}

/// Hides and diagnoses all cases; `done` is told of each one. A core holds the data of one case at a
/// time. A diagnosis that fails counts as an answer; it does not end the run.
///
/// # Errors
/// A plan out of range; a case that cannot be hidden; no threads.
pub fn run(plan: &Plan, done: &(dyn Fn() + Sync)) -> Result<Blind, Error> {
    let cases = plan.draw()?;
    let cores = thread::available_parallelism().map_or(1, NonZero::get);
    let next = AtomicUsize::new(0);
    let results = Mutex::new(Vec::new());
    thread::scope(|scope| {
        let work = || -> Result<(), Error> {
            let pool = one_thread()?;
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(case) = cases.get(index) else {
                    return Ok(());
                };
                let outcome = pool.install(|| solve(case, plan.leave_out))?;
                let mut results = results
                    .lock()
                    .unwrap_or_else(std::sync::PoisonError::into_inner);
                results.push((index, outcome));
                done();
            }
        };
        let workers: Vec<_> = (0..cores.min(cases.len()))
            .map(|_| scope.spawn(work))
            .collect();
        workers.into_iter().try_for_each(|worker| {
            worker.join().unwrap_or_else(|_| {
                Err(Error::request(
                    "a diagnosis has panicked; this is a bug".to_owned(),
                ))
            })
        })
    })?;
    let mut results = results
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner);
    results.sort_by_key(|(index, _)| *index);
    let outcomes: Vec<Outcome> = results.into_iter().map(|(_, outcome)| outcome).collect();
    Ok(Blind {
        plan: plan.clone(),
        scores: Scores::new(&outcomes),
        outcomes,
    })
}

/// A pool in which a diagnosis runs on one core, whatever it would like to share out: its time can
/// then be taken, and no core takes up a second case while it waits for the first.
fn one_thread() -> Result<ThreadPool, Error> {
    ThreadPoolBuilder::new()
        .num_threads(1)
        .stack_size(STACK)
        .build()
        .map_err(|refused| Error::request(format!("no thread to diagnose on: {refused}")))
}

/// Hides and diagnoses one case.
fn solve(case: &HiddenCase, leave_out: bool) -> Result<Outcome, Error> {
    let hidden = case.make()?;
    let truth = hidden.truth.effects.clone();
    Ok(Outcome {
        case: case.clone(),
        bounded: hidden.truth.details.iter().any(|one| one.bounded),
        answer: answer(case, &hidden, leave_out).map_err(|error| error.to_string()),
        truth,
    })
}

fn answer(case: &HiddenCase, hidden: &Hidden, leave_out: bool) -> Result<Answer, Error> {
    let truth = &hidden.truth;
    let options = Options {
        baseline: if truth.effects.iter().any(|effect| effect == RATE) {
            Baseline::RateIndependent
        } else {
            Baseline::RateDependent
        },
        ..Options::default()
    };
    let start = ThreadTime::now();
    let found = diagnose(&hidden.dataset, &options, &|_| {})?;
    let seconds = start.elapsed().as_secs_f64();
    let reach = reach(case, hidden, &options.baseline)?;
    let left_out = match &truth.effects[..] {
        [only] if leave_out => {
            let library: Vec<Effect> = options
                .library
                .iter()
                .copied()
                .filter(|effect| effect.name() != only)
                .collect();
            let options = Options { library, ..options };
            Some(diagnose(&hidden.dataset, &options, &|_| {})?.verdict)
        }
        _ => None,
    };
    Ok(Answer {
        verdict: found.verdict,
        named: named(&found),
        noise_ratio: found.noise.0 / truth.noise_um,
        reach,
        closed: found.closed(),
        left_out,
        seconds,
    })
}

fn named(found: &Diagnosis) -> Vec<Named> {
    found
        .effects
        .iter()
        .map(|one| Named {
            name: one.effect.law().to_owned(),
            also_possible: one.other_laws().into_iter().map(str::to_owned).collect(),
        })
        .collect()
}

/// How far each effect alone moves what the baseline leaves over of the same stage without any, the least
/// of them; without effects, what it leaves beyond the noise; over the noise.
fn reach(case: &HiddenCase, hidden: &Hidden, baseline: &Baseline) -> Result<f64, Error> {
    let noise_um = hidden.truth.noise_um;
    let left = |laws| -> Result<Vec<Vec<f64>>, Error> {
        let all = baseline_alone(&case.with_laws(hidden, laws), baseline)?.records;
        let select = all.into_iter().filter(|one| one.role == Role::Select);
        Ok(select.map(|one| one.residual_um).collect())
    };
    let bare = left(Vec::new())?;
    let laws = &hidden.plant.laws;
    if laws.is_empty() {
        return Ok(excess(rms(bare.into_iter()), noise_um) / noise_um);
    }
    laws.iter().try_fold(f64::INFINITY, |least, law| {
        let with = left(vec![law.clone()])?;
        // The noise is the same in both.
        let moved = with.iter().zip(&bare).map(|(with, bare)| {
            let samples = with.iter().zip(bare);
            samples.map(|(with, bare)| with - bare).collect()
        });
        Ok(least.min(rms(moved) / noise_um))
    })
}

/// Root of the mean over the records of their mean square about their mean.
fn rms(records: impl ExactSizeIterator<Item = Vec<f64>>) -> f64 {
    let count = records.len().max(1) as f64;
    let squares = records.map(|record| {
        let samples = record.len().max(1) as f64;
        let mean = record.iter().sum::<f64>() / samples;
        record.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / samples
    });
    (squares.sum::<f64>() / count).sqrt()
}
