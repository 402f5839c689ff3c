//! What rounding to whole steps does to noise.

/// Parts of an integral.
const PARTS: usize = 400;
/// Halvings of an interval.
const HALVINGS: usize = 40;
/// Standard deviations at which normal noise ends.
const ENDS: f64 = 6.0;

/// Rms of the noise before a rounding to whole `step`s that made what one cycle differs from the next,
/// over the root of two, as large as `heard`; the unit is that of both.
pub fn noise_before(step: f64, heard: f64) -> f64 {
    let (mut low, mut high) = (0.0, heard);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if differs(step, middle) < heard {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Rms of what one rounded reading differs from another one of the same displacement, over the root of
/// two, for noise of the rms `noise`: two that are `k + f` steps apart before it are `k` steps apart after
/// it, or with the chance `f` one more.
fn differs(step: f64, noise: f64) -> f64 {
    let squares = over_normal(|x| {
        let apart = (x * noise * 2f64.sqrt() / step).abs();
        let (whole, rest) = (apart.floor(), apart.fract());
        whole * whole + rest * (2.0 * whole + 1.0)
    });
    step * (0.5 * squares).sqrt()
}

/// Rms of the distance between a displacement and the step that is read of it, for noise of the rms
/// `noise` before the rounding.
pub fn outside(step: f64, noise: f64) -> f64 {
    if noise <= 0.0 {
        return 0.0;
    }
    // Towards one side, wherever in its step the displacement lies: of a noise of n steps, those
    // positions count from which n reaches another step, by how far the nearer edge of that is.
    let squares = over_normal(|x| {
        let reach = (x * noise / step).abs();
        let (whole, rest) = (reach.floor(), reach.fract());
        // A share `rest` of the positions gets one step further than the others.
        let third = |from: f64, to: f64| (to.powi(3) - from.powi(3)) / 3.0;
        // Position p below the edge: read are floor(reach - p) + 1 steps up, whose edge is p + floor().
        third(whole, whole + rest)
            + if whole > 0.0 {
                third(whole - 1.0 + rest, whole)
            } else {
                0.0
            }
    });
    step * squares.sqrt()
}

/// Mean over a standard normal.
fn over_normal(of: impl Fn(f64) -> f64) -> f64 {
    let width = 2.0 * ENDS / PARTS as f64;
    let (mut sum, mut total) = (0.0, 0.0);
    for i in 0..PARTS {
        let x = (i as f64 + 0.5) * width - ENDS;
        let density = (-0.5 * x * x).exp();
        sum += density * of(x);
        total += density;
    }
    sum / total
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal, StandardUniform};
    use rand_pcg::Pcg64;
    use rand_pcg::rand_core::SeedableRng;

    /// Against readings that are drawn.
    #[test]
    fn is_what_readings_show() {
        let mut rng = Pcg64::seed_from_u64(1);
        for noise in [0.02, 0.2, 0.5, 1.3] {
            let step = 2.0;
            let (mut differ, mut beyond) = (0.0, 0.0);
            let draws = 200_000;
            for _ in 0..draws {
                let place: f64 = StandardUniform.sample(&mut rng);
                let truth = 50.0 * place;
                let mut read = || {
                    let n: f64 = StandardNormal.sample(&mut rng);
                    ((truth + noise * step * n) / step).round() * step
                };
                let (one, other) = (read(), read());
                differ += 0.5 * (one - other).powi(2);
                beyond += ((one - truth).abs() - 0.5 * step).max(0.0).powi(2);
            }
            let heard = (differ / f64::from(draws)).sqrt();
            let found = noise_before(step, heard) / step;
            assert!((found / noise - 1.0).abs() < 0.02, "{noise}: {found}");
            let drawn = (beyond / f64::from(draws)).sqrt();
            let found = outside(step, noise * step);
            assert!(
                (found / drawn - 1.0).abs() < 0.04,
                "{noise}: {found} {drawn}"
            );
        }
    }
}
