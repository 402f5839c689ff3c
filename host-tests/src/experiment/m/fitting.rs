//! Identification of the three models at one frequency.

use serde::Serialize;

use crate::error::Error;
use crate::experiment::refused;

use super::bouc_wen::BoucWen;
use super::free_run::{FreeRun, Samples};
use super::model::{COEFFICIENTS, G, Model, Recipe, free_run, one_step};
use super::record::{Record, SAMPLE_TIME_S, Score};
use super::separable::{Fit, LAST_STEPS, minimise, search};

/// A model of one form, identified and scored in every way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Scores {
    /// Identified for the one-step error and scored by it.
    pub one_step: Score,
    /// Identified for the free run and scored in it.
    pub free_run: Score,
    /// Identified recursively with [`Recipe::COVARIANCE`], scored in free run; the rival, which is
    /// not linear in its parameters, has none.
    pub recursive_free_run: Option<Score>,
}

/// The three models at one frequency.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// With g.
    pub proposed: Scores,
    /// Without g.
    pub truncated: Scores,
    /// The rival.
    pub bouc_wen: Scores,
}

/// What identification leaves for compensation and for the figures.
#[derive(Clone, Debug)]
pub struct Identified {
    /// The scores.
    pub comparison: Comparison,
    /// With and without g, identified recursively with [`Recipe::COVARIANCE`].
    pub recursive: [Model; 2],
    /// With g, identified for the free run.
    pub free_run: Model,
}

/// Coefficients that enter linearly for a given feedback: all but g and c_1 to c_3.
const LINEAR: usize = COEFFICIENTS - 4;

/// Their places.
fn linear_places() -> impl Iterator<Item = usize> + Clone {
    (0..G).chain(G + 4..COEFFICIENTS)
}

/// Coefficients of the whole model from a free-run fit.
fn whole(fit: &Fit) -> [f64; COEFFICIENTS] {
    let mut coefficients = [0.0; COEFFICIENTS];
    for (place, &value) in linear_places().zip(&fit.linear) {
        coefficients[place] = value;
    }
    let (c, g) = fit.parameters.split_at(3);
    coefficients[G] = g.first().copied().unwrap_or(0.0);
    coefficients[G + 1..G + 4].copy_from_slice(c);
    coefficients
}

/// A start for c_1 to c_3 that is given to all models: a lightly damped mode where the gain has its
/// peak, and a lag of half a millisecond.
fn resonant_feedback() -> [f64; 3] {
    let radius = 1.0 - 0.0017;
    let turn = std::f64::consts::TAU * 74.0 * SAMPLE_TIME_S;
    let (sum, product) = (2.0 * radius * turn.cos(), radius * radius);
    let lag = (-SAMPLE_TIME_S / 5e-4).exp();
    [sum + lag, -product - sum * lag, product * lag]
}

/// Terms along a record without outputs in them, one row a sample.
fn linear_terms(record: &Record) -> Result<Vec<[f64; LINEAR]>, Error> {
    let rows = Recipe::PROPOSED.rows(record)?;
    let row = |row: &[f64; COEFFICIENTS]| {
        let mut places = linear_places();
        std::array::from_fn(|_| places.next().map_or(0.0, |place| row[place]))
    };
    Ok(rows.iter().map(row).collect())
}

/// Identifies and scores all three models on a record under a sine.
///
/// # Errors
/// A model that cannot be built.
pub fn identify(record: &Record) -> Result<Identified, Error> {
    let hz = record.frequency_hz;
    let recursive = |interleaving, covariance| {
        let recipe = Recipe {
            interleaving,
            covariance,
            ..Recipe::PROPOSED
        };
        let coefficients = recipe.identify(record)?;
        Ok::<_, Error>((recipe.model(hz, &coefficients)?, coefficients))
    };
    let (full, full_start) = recursive(true, Recipe::COVARIANCE)?;
    let (short, short_start) = recursive(false, Recipe::COVARIANCE)?;
    let (weak_full, weak_start) = recursive(true, Recipe::WEAK_COVARIANCE)?;
    let (weak_short, _) = recursive(false, Recipe::WEAK_COVARIANCE)?;

    let starts = [
        feedback(&full_start),
        feedback(&short_start),
        feedback(&weak_start),
        resonant_feedback(),
        [0.9, 0.0, 0.0],
        [0.0; 3],
    ];
    let rival = BoucWen::identify_one_step(record)?;
    let FreeRuns {
        full: full_free,
        short: short_free,
        rival: rival_free,
    } = FreeRuns::identify(record, &starts)?;
    let free = |model: &Model| record.score(&free_run(model, &record.drive));
    let step = |model: &Model| record.score(&one_step(model, record));
    let comparison = Comparison {
        proposed: Scores {
            one_step: step(&weak_full),
            free_run: free(&full_free),
            recursive_free_run: Some(free(&full)),
        },
        truncated: Scores {
            one_step: step(&weak_short),
            free_run: free(&short_free),
            recursive_free_run: Some(free(&short)),
        },
        bouc_wen: Scores {
            one_step: record.score(&rival.one_step(record)?),
            free_run: record.score(&rival_free.free_run(record)?),
            recursive_free_run: None,
        },
    };
    Ok(Identified {
        comparison,
        recursive: [full, short],
        free_run: full_free,
    })
}

/// The three models identified for the free run.
struct FreeRuns {
    full: Model,
    short: Model,
    rival: BoucWen,
}

impl FreeRuns {
    /// From starts for c_1 to c_3. What suits one operator is tried with the other as well.
    fn identify(record: &Record, starts: &[[f64; 3]]) -> Result<Self, Error> {
        let terms = linear_terms(record)?;
        let problem = |with_g, samples| FreeRun::new(record, &terms, with_g, samples);
        let hz = record.frequency_hz;
        let search_from = |starts: &[[f64; 3]]| {
            let starts = starts.iter().map(|start| start.to_vec());
            search(
                &problem(false, Samples::Sparse),
                &problem(false, Samples::All),
                starts,
            )
            .ok_or_else(|| refused(format!("no stable model at {hz} Hz")))
        };
        let own = search_from(starts)?;
        let mut rival_starts = starts.to_vec();
        rival_starts.extend(own.parameters.first_chunk::<3>());
        let rival = BoucWen::identify_free_run(record, &rival_starts)?;
        let other = search_from(&[rival.feedback()]).unwrap_or_else(|_| own.clone());
        let fit = if other.cost < own.cost { other } else { own };
        let short = Recipe::PROPOSED.model(hz, &whole(&fit))?;

        // The models are nested: g is added to the optimum without it, and left out where the free
        // run from rest, which the fit did not see, is none the better for it.
        let nested = [&fit.parameters[..], &[0.0]].concat();
        let full = minimise(&problem(true, Samples::All), &nested, LAST_STEPS);
        let full = Recipe::PROPOSED.model(hz, &whole(&full))?;
        let rmse = |model: &Model| record.score(&free_run(model, &record.drive)).rmse_mm;
        let full = if rmse(&full) < rmse(&short) {
            full
        } else {
            short
        };
        Ok(Self { full, short, rival })
    }
}

fn feedback(coefficients: &[f64; COEFFICIENTS]) -> [f64; 3] {
    let c = &coefficients[G + 1..G + 4];
    [c[0], c[1], c[2]]
}
