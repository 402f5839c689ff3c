//! Rate terms, families and tiers against formulas and other computations.

use std::f64::consts::TAU;

use hysteron_host::plant::hidden::{Effect, Family, Law, Tier};

use crate::support::{hide, near, rms, stage};

const H: f64 = 1e-4;

/// On a rising line the play trails by r + beta R (|u'| / R)^p.
#[test]
fn a_rising_line_trails_by_the_rate_law() {
    let (r, a) = (0.5, 0.4);
    for rate in [100.0, 400.0] {
        let drive: Vec<f64> = (0..=200).map(|k| rate * H * f64::from(k)).collect();
        let u = drive[200];
        let trail = |beta_s: f64, laws: Vec<Law>| {
            let y = stage(Tier::Finer, &[(r, a)], beta_s, laws).run(&drive, H);
            u - ((y[200] - 1.0) / 2.0 - u) / a
        };
        near(trail(1e-3, vec![]), r + 1e-3 * rate, 1e-9);
        let law = Law::RateDependence { beta_s: 2e-3 };
        near(trail(0.0, vec![law]), r + 2e-3 * rate, 1e-9);
        let law = Law::RateLaw {
            exponent: 1.4,
            rate_v_per_s: 200.0,
        };
        let widening = 1e-3 * 200.0 * (rate / 200.0_f64).powf(1.4);
        near(trail(1e-3, vec![law]), r + widening, 1e-9);
    }
}

/// Families without envelopes trail by as much: fast, the hysteresis is where it was slowly a
/// widening ago.
#[test]
fn other_families_are_dragged_by_the_same_law() {
    for seed in 1..=6 {
        for exponent in [1.0, 0.6, 1.5] {
            let mut plant = hide(&[], seed, Tier::Other).plant;
            let top = plant.setup.drive_max_v;
            let rate = 0.1 * top / H / 1000.0;
            let (beta_s, reference) = (2e-3, 0.5 * rate);
            let drive: Vec<f64> = (0..=5000).map(|k| rate * H * f64::from(k)).collect();
            plant.laws.clear();
            plant.baseline.beta_s = 0.0;
            let slow = plant.run(&drive, H);
            plant.baseline.beta_s = beta_s;
            plant.laws.push(Law::RateLaw {
                exponent,
                rate_v_per_s: reference,
            });
            let fast = plant.run(&drive, H);
            let widening = beta_s * reference * (rate / reference).powf(exponent);
            let ago = widening / (rate * H);
            let hysteresis = |y: &[f64], k: usize| {
                y[k] - plant.setup.gain_um_per_v() * plant.baseline.core.direct * drive[k]
            };
            let (whole, part) = (ago as usize, ago.fract());
            let before = (1.0 - part) * hysteresis(&slow, 4000 - whole)
                + part * hysteresis(&slow, 3999 - whole);
            let now = hysteresis(&slow, 4000) - before;
            near(
                hysteresis(&slow, 4000) - hysteresis(&fast, 4000),
                now,
                0.02 * now.abs(),
            );
        }
    }
}

/// Bouc and Wen's equation against small Euler steps of it.
#[test]
fn bouc_wen_is_its_equation() {
    let plant = (1..)
        .map(|seed| hide(&[], seed, Tier::Other).plant)
        .find(|plant| matches!(plant.baseline.core.family, Family::BoucWen { .. }))
        .map(|mut plant| {
            plant.baseline.beta_s = 0.0;
            plant
        })
        .unwrap();
    let Family::BoucWen {
        grow_per_v,
        shape_per_v,
        weight,
    } = plant.baseline.core.family
    else {
        panic!("found as such");
    };
    let (middle, half) = (plant.setup.middle_v(), plant.setup.half_v());
    let at = |t: f64| middle + half * ((TAU * t).sin() * (1.0 - 0.3 * t));
    let drive: Vec<f64> = (0..=300).map(|k| at(f64::from(k) / 100.0)).collect();
    let y = plant.run(&drive, 0.01);
    // The stage is brought from 0 V to the first sample in one move, then follows straight lines.
    let parts = 2000;
    let (mut z, mut u) = (0.0_f64, 0.0);
    for (k, &to) in drive.iter().enumerate() {
        let du = (to - u) / f64::from(parts);
        for _ in 0..parts {
            z += du - grow_per_v * du.abs() * z - shape_per_v * du * z.abs();
        }
        u = to;
        let w = plant.baseline.core.direct * u + weight * z;
        let expected = plant.setup.offset_um + plant.setup.gain_um_per_v() * w;
        near(y[k], expected, 2e-4 * plant.setup.stroke_um);
    }
}

/// The slow loop over the whole range is as wide and as high as the truth says, in every tier.
#[test]
fn the_slow_loop_has_the_stroke_and_the_width_stated() {
    for tier in crate::support::TIERS {
        for seed in 1..=6 {
            let mut hidden = hide(&[], seed, tier);
            hidden.plant.baseline.beta_s = 0.0;
            let setup = &hidden.plant.setup;
            let way =
                |k: i32| setup.middle_v() - setup.half_v() * (TAU * f64::from(k) / 4000.0).cos();
            let drive: Vec<f64> = (0..=12_000).map(way).collect();
            let y = &hidden.plant.run(&drive, 1e-2)[8000..];
            near(y[2000] - y[0], setup.stroke_um, 2e-3 * setup.stroke_um);
            // Up and down pass the same drive at k and 4000 - k.
            let width = (0..2000).map(|k| y[4000 - k] - y[k]).fold(0.0, f64::max);
            let percent = 100.0 * width / setup.stroke_um;
            near(percent, hidden.truth.stage.hysteresis_percent, 0.1);
        }
    }
}

/// Tier 1 comes nearer to tier 2 as the record is sampled faster, whatever is hidden.
#[test]
fn tier_1_converges_to_tier_2() {
    let effects = Effect::ALL.into_iter().filter(|effect| {
        // A term of one sample ago and a rounding are of the sampling itself.
        !matches!(effect, Effect::Interleaving | Effect::Quantisation)
    });
    for effect in effects {
        let plant = hide(&[effect], 9, Tier::Finer).plant;
        let hz = plant.setup.top_hz;
        let gap = |per_cycle: usize| {
            let drive: Vec<f64> = (0..=3 * per_cycle)
                .map(|k| {
                    let at = TAU * k as f64 / per_cycle as f64;
                    plant.setup.middle_v() + 0.9 * plant.setup.half_v() * at.sin()
                })
                .collect();
            let h = 1.0 / (hz * per_cycle as f64);
            let mut same = plant.clone();
            same.tier = Tier::Same;
            let (finer, same) = (plant.run(&drive, h), same.run(&drive, h));
            // The first cycle begins with a jump of the rate.
            rms((per_cycle..drive.len()).map(|k| finer[k] - same[k]))
        };
        let (coarse, fine) = (gap(40), gap(640));
        let stroke = plant.setup.stroke_um;
        assert!(
            fine < 0.25 * coarse || coarse < 1e-5 * stroke,
            "{effect}: {} then {} of the stroke",
            coarse / stroke,
            fine / stroke
        );
        assert!(fine < 2e-3 * stroke, "{effect}");
    }
}
