//! A model scored on every sample of a data set that was condensed to be fitted.

use crate::dataset::Role;
use crate::dataset::long::{Long, Whole};
use crate::error::Error;
use crate::model_file::ModelFile;
use crate::stage::{self, Chain};

use super::Rms;
use super::cycles::{Turns, first_cycle, turning_points};
use super::start::Start;

/// Samples at the start of a file on which the history before it is chosen.
const HEAD: usize = 1 << 16;
/// Turning points of a drive that has cycles behind its first.
const TURNS_OF_CYCLES: u64 = 4;

/// Rms residuals over all samples of a data set.
#[derive(Clone, Debug, PartialEq)]
pub struct WholeRms {
    /// Samples that were scored.
    pub samples: u64,
    /// Rms residuals in micrometres.
    pub rms: Rms,
}

/// Count, sum and sum of squares of what a role's samples leave over.
#[derive(Clone, Copy, Default)]
struct Moments {
    count: u64,
    sum: f64,
    squares: f64,
}

impl Moments {
    fn add(&mut self, residual: f64) {
        self.count += 1;
        self.sum += residual;
        self.squares += residual * residual;
    }

    fn mean(&self) -> f64 {
        self.sum / self.count.max(1) as f64
    }

    fn about(&self, offset: f64) -> f64 {
        let square = self.squares / self.count.max(1) as f64;
        (square - 2.0 * offset * self.mean() + offset * offset).max(0.0)
    }
}

/// Runs a model through every sample of every file at the files' own sample times, by the core, and
/// scores all but the first cycle of each. `progress` is told what is done now.
///
/// # Errors
/// A model that cannot be built at a file's sample time, a file that changed meanwhile.
pub fn whole(long: &Long, model: &ModelFile, progress: &dyn Fn(&str)) -> Result<WholeRms, Error> {
    let mut found: Vec<(Role, Moments, f64)> = Vec::new();
    for file in long.files() {
        let moments = of_file(&file, model, progress)?;
        let all = moments
            .iter()
            .fold(Moments::default(), |all, (_, part)| Moments {
                count: all.count + part.count,
                sum: all.sum + part.sum,
                squares: all.squares + part.squares,
            });
        found.extend(
            moments
                .into_iter()
                .map(|(role, part)| (role, part, all.mean())),
        );
    }
    let of = |wanted: Role| {
        let of_role = found
            .iter()
            .filter(move |(role, part, _)| *role == wanted && part.count > 0);
        of_role.collect::<Vec<_>>()
    };
    let fit = of(Role::Fit);
    // As in the fit, every record counts the same, whatever its length.
    let shared = fit.iter().map(|(_, part, _)| part.mean()).sum::<f64>() / fit.len().max(1) as f64;
    let rms = |role: Role| {
        let of_role = of(role);
        let squares = of_role
            .iter()
            .map(|(_, part, own)| part.about(if long.own_offsets() { *own } else { shared }));
        (!of_role.is_empty()).then(|| (squares.sum::<f64>() / of_role.len() as f64).sqrt())
    };
    Ok(WholeRms {
        samples: found.iter().map(|(_, part, _)| part.count).sum(),
        rms: Rms {
            fit: rms(Role::Fit),
            select: rms(Role::Select),
            report: rms(Role::Report),
        },
    })
}

/// What the samples of a file leave over, by role: of all, and of those from the second turning point on,
/// which is certain only some samples later.
struct Score<'a> {
    file: &'a Whole<'a>,
    turns: Turns,
    found: u64,
    row: u64,
    all: Vec<Moments>,
    /// Until that point is certain, from where it would be.
    later: Vec<Moments>,
}

impl<'a> Score<'a> {
    fn new(file: &'a Whole<'a>) -> Self {
        let empty = vec![Moments::default(); file.roles.len()];
        Self {
            file,
            turns: Turns::new(file.drive_v.1 - file.drive_v.0),
            found: 0,
            row: 0,
            all: empty.clone(),
            later: empty,
        }
    }

    fn add(&mut self, drive: f64, residual: f64) {
        self.found += u64::from(self.turns.push(drive).is_some());
        if self.found < 2 && self.turns.next() == Some(self.row) {
            self.later.fill(Moments::default());
        }
        let parts = self.all.iter_mut().zip(&mut self.later);
        for ((all, later), (_, rows)) in parts.zip(&self.file.roles) {
            if rows.contains(&self.row) {
                all.add(residual);
                later.add(residual);
            }
        }
        self.row += 1;
    }

    /// The first cycle left out, as [`first_cycle`] does, where others follow it.
    fn moments(self) -> Vec<(Role, Moments)> {
        let scored = if self.found >= TURNS_OF_CYCLES {
            self.later
        } else {
            self.all
        };
        let roles = self.file.roles.iter().map(|(role, _)| *role);
        roles.zip(scored).collect()
    }
}

fn of_file(
    file: &Whole<'_>,
    model: &ModelFile,
    progress: &dyn Fn(&str),
) -> Result<Vec<(Role, Moments)>, Error> {
    let chain = stage::chain(model, file.sample_time_s)?;
    let mut head: Vec<[f64; 2]> = Vec::with_capacity(HEAD);
    let mut state = None;
    let mut score = Score::new(file);
    let length = file.samples.min(HEAD as u64) as usize;
    file.each(progress, |u, y| {
        if let Some(state) = &mut state {
            score.add(u, y - chain.step(state, u));
            return Ok(());
        }
        head.push([u, y]);
        if head.len() == length {
            let mut begun = begin(&chain, file, &head)?;
            for [u, y] in std::mem::take(&mut head) {
                score.add(u, y - chain.step(&mut begun, u));
            }
            state = Some(begun);
        }
        Ok(())
    })?;
    Ok(score.moments())
}

type State = hysteron::chain::ChainState<f64, { stage::PLAYS }>;

/// The state before a file's first sample, of the menu's histories the one that explains its head best:
/// what follows the first cycle in it, or all of a head that is no longer than that.
fn begin(chain: &Chain, file: &Whole<'_>, head: &[[f64; 2]]) -> Result<State, Error> {
    let range = file.drive_v.1 - file.drive_v.0;
    let drive: Vec<f64> = head.iter().map(|[u, _]| *u).collect();
    let skipped = first_cycle(&turning_points(&drive, range));
    let operator = chain.model().hysteresis();
    let u0 = head.first().map_or(0.0, |[u, _]| *u);
    let mut best: Option<(f64, State)> = None;
    for start in Start::menu(range) {
        if start == Start::Periodic {
            continue;
        }
        let thresholds = operator.bank().thresholds();
        let plays: Vec<f64> = thresholds.iter().map(|&r| start.play(u0, r).0).collect();
        let plays = operator
            .start_from(u0, &plays)
            .map_err(|refused| Error::request(format!("start of a record: {refused}")))?;
        let mut state = chain.start_from(u0, plays);
        state.set_time(file.start_s);
        let begun = state;
        let mut moments = Moments::default();
        for (k, [u, y]) in head.iter().enumerate() {
            let residual = y - chain.step(&mut state, *u);
            if k >= skipped {
                moments.add(residual);
            }
        }
        let square = moments.about(moments.mean());
        if best.as_ref().is_none_or(|(least, _)| square < *least) {
            best = Some((square, begun));
        }
    }
    best.map(|(_, state)| state)
        .ok_or_else(|| Error::request("a record has no start".to_owned()))
}
