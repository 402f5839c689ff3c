//! The printed plane, which is eleven numbers, against the clamped one, on a signal that was not
//! fitted.

use std::f64::consts::TAU;

use hysteron::hysteresis::modified_play::{
    ClampedPlane, LinearPlane, ModifiedPlay, Plane as CorePlane, Signals, Terms,
};
use hysteron::rls::Rls;
use serde::Serialize;

use crate::error::Error;
use crate::experiment::m::model::{DIVISIONS, Recipe};
use crate::experiment::m::record::{Record, SAMPLE_TIME_S, Score, sine};
use crate::experiment::refused;

/// Feedback coefficients, the only ones beside the plane's here: a signal of many frequencies has no
/// harmonic terms.
const FEEDBACK: usize = 3;
const PRINTED: usize = DIVISIONS + 1 + FEEDBACK;
const CLAMPED: usize = 1 + DIVISIONS * (DIVISIONS - 1) / 2 + FEEDBACK;
/// Initial covariances; the fitted signal is rich, so a large one does no harm.
const COVARIANCES: [f64; 2] = [1.0, 1e4];
/// Tones of fitted and held-out signal in Hz: slow, so that hysteresis and not vibration is fitted.
const TONES_HZ: [[f64; 5]; 2] = [[1.3, 2.9, 4.7, 7.9, 11.3], [1.7, 3.1, 5.3, 8.3, 10.7]];

/// A form of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Plane {
    /// (M 4), linear in every play.
    Printed,
    /// Each cell limited to its own range.
    Clamped,
}

/// How one form does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Held {
    /// The form.
    pub plane: Plane,
    /// Numbers that are identified.
    pub coefficients: usize,
    /// Initial covariance.
    pub covariance: f64,
    /// Free run on the fitted signal.
    pub fitted: Score,
    /// Free run on the other.
    pub held_out: Score,
    /// From the measured outputs before each sample, on the other.
    pub held_out_one_step: Score,
}

/// Tones of equal size, the sum scaled to full drive.
fn rich(tones_hz: [f64; 5]) -> Result<Record, Error> {
    let mut drive = sine(0.0, 1.0);
    for (k, u) in drive.iter_mut().enumerate() {
        let t = k as f64 * SAMPLE_TIME_S;
        *u = tones_hz.iter().map(|hz| (TAU * hz * t).sin()).sum();
    }
    let largest = drive.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    drive.iter_mut().for_each(|u| *u /= largest);
    // Only the seed of the noise comes from this frequency.
    Record::drive(tones_hz.iter().sum(), drive, 3)
}

/// Identifies `K` coefficients, the feedback last.
fn identify<const K: usize>(
    record: &Record,
    covariance: f64,
    terms: impl Fn(&Signals<f64, DIVISIONS>) -> [f64; K],
) -> Result<[f64; K], Error> {
    let basis = Recipe::PROPOSED.basis(1.0)?;
    let rls = Rls::new(1.0, covariance, 2.0 * K as f64 * covariance).map_err(refused)?;
    let mut estimate = rls.start([0.0; K]);
    let mut state = basis.start();
    for (&drive, &measured) in record.drive.iter().zip(&record.displacement_mm) {
        let signals = basis.advance(&mut state, drive, 0.0);
        rls.update(&mut estimate, &terms(&signals), measured)
            .map_err(refused)?;
        state.remember(drive, measured);
    }
    Ok(*estimate.parameters())
}

fn row<const K: usize>(
    plane: impl Iterator<Item = f64>,
    signals: &Signals<f64, DIVISIONS>,
) -> [f64; K] {
    let mut row = [0.0; K];
    let all = plane.chain(signals.outputs);
    row.iter_mut().zip(all).for_each(|(to, from)| *to = from);
    row
}

fn held<P: CorePlane<f64, DIVISIONS>>(
    (plane, coefficients, covariance): (Plane, usize, f64),
    model: &ModifiedPlay<f64, DIVISIONS, P>,
    [fitted, held_out]: &[Record; 2],
) -> Held {
    let free = |record: &Record| {
        let mut state = model.start();
        let drive = record.drive.iter();
        let output: Vec<f64> = drive.map(|&u| model.step(&mut state, u)).collect();
        record.score(&output)
    };
    let mut state = model.start();
    let samples = held_out.drive.iter().zip(&held_out.displacement_mm);
    let one_step: Vec<f64> = samples
        .map(|(&u, &measured)| model.predict(&mut state, u, 0.0, measured))
        .collect();
    Held {
        plane,
        coefficients,
        covariance,
        fitted: free(fitted),
        held_out: free(held_out),
        held_out_one_step: held_out.score(&one_step),
    }
}

/// Both forms, each with both covariances.
///
/// # Errors
/// A drive or model that is refused.
pub fn run() -> Result<Vec<Held>, Error> {
    let [fitted, held_out] = TONES_HZ.map(rich);
    let records = [fitted?, held_out?];
    let basis = Recipe::PROPOSED.basis(1.0)?;
    let with = |feedback: &[f64]| Terms {
        feedback: [feedback[0], feedback[1], feedback[2]],
        ..Terms::none()
    };
    let mut found = Vec::new();
    for covariance in COVARIANCES {
        let printed = identify(&records[0], covariance, |signals| {
            row::<PRINTED>(basis.linear_terms(signals), signals)
        })?;
        let (plane, feedback) = printed.split_at(PRINTED - FEEDBACK);
        let (slopes, offset) = plane.split_at(DIVISIONS);
        let plane = LinearPlane::new(basis.grid(), slopes, offset[0]).map_err(refused)?;
        let model = ModifiedPlay::new(&basis, plane, with(feedback)).map_err(refused)?;
        found.push(held(
            (Plane::Printed, PRINTED, covariance),
            &model,
            &records,
        ));

        let clamped = identify(&records[0], covariance, |signals| {
            row::<CLAMPED>(basis.clamped_terms(signals), signals)
        })?;
        let (plane, feedback) = clamped.split_at(CLAMPED - FEEDBACK);
        let plane = ClampedPlane::new(basis.grid(), plane[0], &plane[1..]).map_err(refused)?;
        let model = ModifiedPlay::new(&basis, plane, with(feedback)).map_err(refused)?;
        found.push(held(
            (Plane::Clamped, CLAMPED, covariance),
            &model,
            &records,
        ));
    }
    Ok(found)
}
