//! Sizes, seeds, records.

use std::collections::BTreeSet;

use hysteron_host::dataset::{Role, Zero};
use hysteron_host::plant::hidden::{Choice, Effect, Hidden, HiddenCase, Protocol, Tier};
use nalgebra::{DMatrix, DVector};

use crate::support::{case, hide, near, rms};

fn without_noise(effects: &[Effect], seed: u64, tier: Tier, rate_term: Option<bool>) -> Hidden {
    HiddenCase {
        noise_percent: 0.0,
        rate_term,
        ..case(effects, seed, tier)
    }
    .make()
    .unwrap()
}

/// Percent of the stroke that the data with the effect leave after a fit of offset and gain to the
/// data without it, each record with the same weight; by a singular value decomposition.
fn left_percent(with: &Hidden, without: &Hidden) -> f64 {
    let (mut rows, mut weights) = (Vec::new(), Vec::new());
    let pairs = with.dataset.records.iter().zip(&without.dataset.records);
    for (a, b) in pairs {
        let weight = 1.0 / (a.drive_v.len() as f64).sqrt();
        for (&y, &x) in a.displacement_um.iter().zip(&b.displacement_um) {
            rows.push((x, y));
            weights.push(weight);
        }
    }
    let count = rows.len();
    let left = DMatrix::from_fn(count, 2, |row, column| {
        weights[row] * if column == 0 { 1.0 } else { rows[row].0 }
    });
    let right = DVector::from_fn(count, |row, _| weights[row] * rows[row].1);
    let fit = left.clone().svd(true, true).solve(&right, 1e-12).unwrap();
    let residual = right - left * fit;
    let records = with.dataset.records.len() as f64;
    100.0 * (residual.norm_squared() / records).sqrt() / with.plant.setup.stroke_um
}

#[test]
fn each_effect_has_the_strength_asked_for() {
    let seed = (1..)
        .find(|&seed| hide(&[], seed, Tier::Same).dataset.zero == Zero::Shared)
        .unwrap();
    let own_law = [Effect::Congruency, Effect::Backlash, Effect::Creep];
    for tier in [Tier::Same, Tier::Other] {
        // The rate law starts from a stronger rate term than any data set without it has.
        let effects = Effect::ALL
            .into_iter()
            .filter(|one| *one != Effect::RateLaw && (tier == Tier::Same || own_law.contains(one)));
        for effect in effects {
            let rate_term = Some(effect != Effect::RateDependence);
            let without = without_noise(&[], seed, tier, rate_term);
            let with = without_noise(&[effect], seed, tier, rate_term);
            let detail = &with.truth.details[0];
            let found = left_percent(&with, &without);
            near(found, detail.strength, 3e-3 * detail.strength);
            if !detail.bounded {
                near(found, 1.0, 5e-3);
            }
            assert!(
                !detail.bounded || effect == Effect::RateDependence,
                "{effect}"
            );
            for (a, b) in with.dataset.records.iter().zip(&without.dataset.records) {
                assert_eq!(a.drive_v, b.drive_v);
            }
        }
    }
}

#[test]
fn figures_by_role_are_those_of_the_data() {
    let seed = (1..)
        .find(|&seed| hide(&[], seed, Tier::Same).dataset.zero == Zero::Shared)
        .unwrap();
    let effects = [Effect::AmplifierLag, Effect::Creep];
    let with = without_noise(&effects, seed, Tier::Finer, Some(false));
    let without = without_noise(&[], seed, Tier::Finer, Some(false));
    for (role, expected) in [
        (Role::Fit, with.truth.moves_um.fit),
        (Role::Select, with.truth.moves_um.select),
        (Role::Report, with.truth.moves_um.report),
    ] {
        let pairs = with
            .dataset
            .with_role(role)
            .zip(without.dataset.with_role(role));
        let found = rms(pairs.map(|(a, b)| {
            let both = a.displacement_um.iter().zip(&b.displacement_um);
            rms(both.map(|(a, b)| a - b))
        }));
        near(found, expected, 1e-6 * expected);
    }
    assert_eq!(with.truth.effects, ["amplifier-lag", "creep"]);
}

#[test]
fn the_seed_decides_everything_and_the_effect_leaves_the_stage() {
    let one = hide(&[Effect::Creep], 5, Tier::Irregular);
    let again = hide(&[Effect::Creep], 5, Tier::Irregular);
    assert_eq!(one.dataset, again.dataset);
    assert_eq!(one.truth, again.truth);
    let other = hide(&[Effect::Drift], 5, Tier::Irregular);
    assert_eq!(one.truth.stage, other.truth.stage);
    let elsewhere = hide(&[Effect::Creep], 6, Tier::Irregular);
    assert_ne!(one.truth.stage, elsewhere.truth.stage);
    // Ranges, units and effects do vary.
    let setups: Vec<_> = (1..40).map(|seed| hide(&[], seed, Tier::Same)).collect();
    let kinds = |f: &dyn Fn(&Hidden) -> String| setups.iter().map(f).collect::<BTreeSet<_>>().len();
    assert_eq!(kinds(&|one| one.dataset.output_unit.to_string()), 3);
    assert_eq!(kinds(&|one| one.plant.setup.drive_max_v.to_string()), 4);
    assert_eq!(kinds(&|one| format!("{:?}", one.dataset.zero)), 2);
    assert_eq!(kinds(&|one| (one.truth.stage.beta_s > 0.0).to_string()), 2);
}

#[test]
fn random_effects_are_compatible_and_all_come_up() {
    let mut seen = BTreeSet::new();
    for seed in 0..400 {
        let drawn = Choice::Random(2).effects(seed).unwrap();
        assert_eq!(drawn.len(), 2);
        assert!(
            !(drawn.contains(&Effect::AmplifierLag) && drawn.contains(&Effect::TransportDelay))
        );
        assert!(!(drawn.contains(&Effect::Quadratic) && drawn.contains(&Effect::Interleaving)));
        seen.extend(drawn);
        let most = Choice::Random(Effect::MOST_TOGETHER).effects(seed).unwrap();
        assert_eq!(most.len(), Effect::MOST_TOGETHER);
    }
    assert_eq!(seen.len(), Effect::ALL.len() - 1);
    assert!(!seen.contains(&Effect::RateDependence));
}

#[test]
fn noise_has_the_rms_and_the_colour_stated() {
    for tier in [Tier::Finer, Tier::Other] {
        let noisy = HiddenCase {
            noise_percent: 0.5,
            ..case(&[], 4, tier)
        }
        .make()
        .unwrap();
        let quiet = without_noise(&[], 4, tier, None);
        let pairs = noisy.dataset.records.iter().zip(&quiet.dataset.records);
        let noise: Vec<f64> = pairs
            .flat_map(|(a, b)| a.displacement_um.iter().zip(&b.displacement_um))
            .map(|(a, b)| a - b)
            .collect();
        let expected = 5e-3 * noisy.plant.setup.stroke_um;
        near(noisy.truth.noise_um, expected, 1e-12);
        near(rms(noise.iter().copied()), expected, 0.03 * expected);
        let neighbours: f64 = noise.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let correlation = neighbours / noise.iter().map(|x| x * x).sum::<f64>();
        // White: none. Coloured: half of the power with 0.95 from sample to sample.
        let expected = if noisy.truth.noise_coloured {
            0.475
        } else {
            0.0
        };
        near(correlation, expected, 0.03);
    }
}

#[test]
fn the_multisine_leaves_even_lines_and_some_odd_ones_empty() {
    let hidden = hide(&[], 2, Tier::Same);
    let multisine = |one: &&hysteron_host::dataset::Record| one.name.contains("multisine");
    let record = hidden.dataset.records.iter().find(multisine).unwrap();
    let drive = &record.drive_v;
    let mean = drive.iter().sum::<f64>() / drive.len() as f64;
    let amplitude = |line: usize| {
        let (mut re, mut im) = (0.0, 0.0);
        for (k, u) in drive[..2048].iter().enumerate() {
            let angle = std::f64::consts::TAU * (line * k % 2048) as f64 / 2048.0;
            re += (u - mean) * angle.cos();
            im += (u - mean) * angle.sin();
        }
        re.hypot(im) / 1024.0
    };
    let top = (hidden.plant.setup.top_hz * 2048.0 * record.sample_time_s) as usize;
    let full = amplitude(1).max(amplitude(3));
    assert!((1..=top / 2).all(|half| amplitude(2 * half) < 1e-9 * full));
    let odd: Vec<bool> = (0..top / 2)
        .map(|half| amplitude(2 * half + 1) > 1e-3 * full)
        .collect();
    let empty = odd.iter().filter(|&&there| !there).count();
    near(empty as f64, odd.len() as f64 / 3.0, 1.0);
}

#[test]
fn every_protocol_has_all_roles_and_time_goes_on() {
    for protocol in [
        Protocol::Full,
        Protocol::Sines,
        Protocol::Slow,
        Protocol::Random,
    ] {
        for seed in 1..6 {
            let case = HiddenCase {
                protocol,
                ..case(&[Effect::Quadratic], seed, Tier::Same)
            };
            let hidden = case.make().unwrap();
            for role in [Role::Fit, Role::Select, Role::Report] {
                assert!(hidden.dataset.with_role(role).count() > 2);
            }
            for pair in hidden.dataset.records.windows(2) {
                assert!(pair[1].start_s > *pair[0].time_s.last().unwrap());
            }
            let setup = &hidden.plant.setup;
            let inside =
                |u: &f64| (setup.drive_min_v - 1e-9..=setup.drive_max_v + 1e-9).contains(u);
            let drives = || hidden.dataset.records.iter().flat_map(|one| &one.drive_v);
            assert!(drives().all(inside));
            if protocol == Protocol::Full {
                let fit: usize = hidden
                    .dataset
                    .with_role(Role::Fit)
                    .map(|one| one.drive_v.len())
                    .sum();
                assert!((15_000..22_000).contains(&fit), "{fit}");
            }
        }
    }
}

/// The same stage with all of its laws is itself, and without any what `none` hides.
#[test]
fn the_same_stage_with_other_laws() {
    for tier in [Tier::Same, Tier::Other] {
        let with = case(&[Effect::Creep, Effect::Cubic], 31, tier);
        let hidden = with.make().unwrap();
        let nothing = hide(&[], 31, tier);
        let all = with.with_laws(&hidden, hidden.plant.laws.clone());
        let bare = with.with_laws(&hidden, Vec::new());
        for (again, as_hidden) in [(all, &hidden.dataset), (bare, &nothing.dataset)] {
            let pairs = again.records.iter().zip(&as_hidden.records);
            for (a, b) in pairs {
                assert_eq!(a.displacement_um, b.displacement_um, "{}", a.name);
            }
        }
    }
}
