//! The bar for a name by parametric bootstrap: what the best effect of the library gains on records that
//! the baseline itself makes, with noise and without any effect.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use rayon::prelude::*;

use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::score;

use super::search::{Candidate, Ground, expand, most_promising};

/// Share of the draws that stay under the bar.
const UNDER: f64 = 0.95;

/// Square root of what the best effect takes from the mean square on the select records, in um: the
/// largest but for one in twenty of so many `draws`. The noise is Gaussian with the rms of the floor and
/// the correlation from sample to sample of what the baseline leaves over.
///
/// # Errors
/// Numbers that the core refuses.
pub fn bar(
    ground: &Ground,
    base: &Candidate,
    noise_um: f64,
    library: &[Effect],
    draws: usize,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<f64, Error> {
    let joint = &base.joint;
    let predicted = ground.fit().predicted(&joint.core, &joint.terms)?;
    let offsets = score::offsets(&ground.runs, &predicted);
    let kept = correlation(ground, &predicted);
    let mut gains: Vec<f64> = (0..draws as u64)
        .into_par_iter()
        .map(|draw| {
            progress("drawing records without effect");
            let mut rng = Pcg64::seed_from_u64(draw);
            let mut other = ground.clone();
            for ((run, predicted), offset) in
                other.runs.runs.iter_mut().zip(&predicted).zip(&offsets)
            {
                let mut state: f64 = StandardNormal.sample(&mut rng);
                for (y, predicted) in run.displacement.iter_mut().zip(predicted) {
                    *y = predicted + offset + noise_um * state;
                    let fresh: f64 = StandardNormal.sample(&mut rng);
                    state = kept * state + (1.0 - kept * kept).sqrt() * fresh;
                }
            }
            gain(&other, base, library)
        })
        .collect::<Result<_, Error>>()?;
    gains.sort_by(f64::total_cmp);
    let place = (UNDER * gains.len() as f64).ceil() as usize;
    Ok(gains
        .get(place.max(1) - 1)
        .copied()
        .unwrap_or_default()
        .sqrt())
}

/// What the best effect takes from the mean square on the select records of a draw.
fn gain(ground: &Ground, base: &Candidate, library: &[Effect]) -> Result<f64, Error> {
    let rich = ground.refit(base)?;
    let leads = most_promising(ground, &rich, library)?;
    let found = expand(&ground.fit(), &rich, &leads)?;
    let least = found.iter().map(|c| c.select).fold(rich.select, f64::min);
    Ok(rich.select.powi(2) - least * least)
}

/// Correlation from one sample to the next of what the baseline leaves over, not below zero.
fn correlation(ground: &Ground, predicted: &[Vec<f64>]) -> f64 {
    let (mut along, mut size) = (0.0, 0.0);
    for (run, predicted) in ground.runs.runs.iter().zip(predicted) {
        for span in &run.spans {
            let left: Vec<f64> = span
                .samples
                .clone()
                .map(|k| run.displacement[k] - predicted[k])
                .collect();
            let mean = left.iter().sum::<f64>() / left.len().max(1) as f64;
            for pair in left.windows(2) {
                along += (pair[0] - mean) * (pair[1] - mean);
                size += (pair[0] - mean).powi(2);
            }
        }
    }
    if size > 0.0 {
        (along / size).clamp(0.0, 0.99)
    } else {
        0.0
    }
}
