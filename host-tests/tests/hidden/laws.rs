//! Each law against its formula, in every tier that claims it.

use std::f64::consts::TAU;

use hysteron_host::metrics::line;
use hysteron_host::plant::hidden::{Family, Law, Tier};

use crate::support::{TIERS, near, stage};

const H: f64 = 1e-4;

fn sine(hz: f64, samples: usize) -> Vec<f64> {
    (0..samples)
        .map(|k| 5.0 + (TAU * hz * k as f64 * H).sin())
        .collect()
}

/// Amplitude (um) and phase of the answer to a sine of 1 V, after `skip` whole seconds.
fn answer(tier: Tier, laws: Vec<Law>, hz: f64, skip: usize) -> (f64, f64) {
    let drive = sine(hz, 10_000 * (skip + 1));
    let displacement = stage(tier, &[], 0.0, laws).run(&drive, H);
    let at = line(&displacement[10_000 * skip..], H, hz).unwrap();
    (at.amplitude, at.phase_rad)
}

#[test]
fn lags_turn_a_line_by_the_arc_tangent() {
    for tier in TIERS {
        for law in [
            Law::AmplifierLag { tau_s: 1e-3 },
            Law::SensorLag { tau_s: 1e-3 },
        ] {
            for hz in [20.0, 100.0] {
                let turn = TAU * hz * 1e-3;
                let (amplitude, phase) = answer(tier, vec![law.clone()], hz, 1);
                near(phase, -turn.atan(), 2e-4);
                near(amplitude, 2.0 / turn.hypot(1.0), 2e-3);
            }
        }
    }
}

#[test]
fn a_delay_turns_a_line_in_proportion_and_leaves_its_size() {
    for tier in TIERS {
        for delay_s in [0.4e-4, 3.3e-4, 10e-4] {
            let (amplitude, phase) = answer(tier, vec![Law::TransportDelay { delay_s }], 100.0, 1);
            near(phase, -TAU * 100.0 * delay_s, 2e-4);
            near(amplitude, 2.0, 1e-3);
        }
    }
}

#[test]
fn a_mode_amplifies_by_one_over_twice_its_damping() {
    for tier in TIERS {
        let law = Law::Resonance {
            f_n_hz: 200.0,
            zeta: 0.02,
        };
        let (amplitude, phase) = answer(tier, vec![law.clone()], 200.0, 1);
        near(amplitude, 2.0 / 0.04, 0.3);
        near(phase, -TAU / 4.0, 0.02);
        // At half the frequency: 1 / (1 - 1/4), up to the damping.
        let (amplitude, _) = answer(tier, vec![law], 100.0, 1);
        near(amplitude, 2.0 / 0.75, 5e-3);
    }
}

#[test]
fn a_step_creeps_by_the_gain_a_decade() {
    let drive: Vec<f64> = (0..40_000)
        .map(|k| if k == 0 { 0.0 } else { 1.0 })
        .collect();
    let law = Law::Creep {
        gain_per_decade: 0.03,
        tau_min_s: 0.01,
        tau_max_s: 1.0,
    };
    let at = |tier: Tier, t: f64| {
        let displacement = stage(tier, &[], 0.0, vec![law.clone()]).run(&drive, 1e-3);
        displacement[(t / 1e-3) as usize + 1] - 3.0
    };
    for t in [0.2, 3.0, 30.0] {
        // The step takes one sample, so that its middle is half a sample after the start.
        let age = t + 0.5e-3;
        near(at(Tier::Other, t), 0.06 * (1.0 + age / 0.01).log10(), 1e-6);
        let states: f64 = [0.01, 0.1, 1.0]
            .iter()
            .map(|tau| -(-age / tau).exp_m1())
            .sum();
        near(at(Tier::Same, t), 0.06 * states, 1e-6);
        near(at(Tier::Finer, t), 0.06 * states, 1e-6);
    }
    // A decade apart and far from either end.
    near(at(Tier::Other, 30.0) - at(Tier::Other, 3.0), 0.06, 1e-4);
}

#[test]
fn hum_is_a_line_and_its_third_in_absolute_time() {
    let law = Law::MainsHum {
        frequency_hz: 50.0,
        amplitude: 0.3,
        phase_rad: 0.7,
        third: 0.1,
        third_phase_rad: -1.1,
    };
    for tier in TIERS {
        let rest = stage(tier, &[], 0.0, vec![law.clone()]).run(&vec![4.0; 10_000], H);
        for (hz, amplitude, phase) in [(50.0, 0.3, 0.7), (150.0, 0.1, -1.1), (100.0, 0.0, 0.0)] {
            let found = line(&rest, H, hz).unwrap();
            near(found.amplitude, amplitude, 1e-9);
            if amplitude > 0.0 {
                near(found.phase_rad, phase, 1e-7);
            }
        }
    }
}

#[test]
fn drift_goes_its_way_at_rest() {
    let law = |linear| Law::Drift {
        amplitude: 0.5,
        tau_s: 20.0,
        linear,
    };
    let end = |tier, linear| {
        let rest = stage(tier, &[], 0.0, vec![law(linear)]).run(&[4.0; 101], 0.1);
        near(rest[0], 9.0, 1e-12);
        rest[100] - 9.0
    };
    near(
        end(Tier::Same, false),
        0.5 * (1.0 - (-0.5_f64).exp()),
        1e-12,
    );
    near(end(Tier::Other, false), 0.5 * 10.0 / 30.0, 1e-12);
    near(end(Tier::Irregular, true), 0.25, 1e-12);
}

#[test]
fn curves_are_what_they_say() {
    let ramp: Vec<f64> = (0..=100).map(|k| 0.1 * f64::from(k)).collect();
    let bent = |tier, law| stage(tier, &[], 0.0, vec![law]).run(&ramp, 1e-2);
    for tier in TIERS {
        let quadratic = bent(tier, Law::Quadratic { q: 0.01 });
        let cubic = bent(tier, Law::Cubic { c: -0.001 });
        for (k, u) in ramp.iter().enumerate() {
            near(quadratic[k], 1.0 + 2.0 * (u + 0.01 * u * u), 1e-12);
            near(cubic[k], 1.0 + 2.0 * (u - 0.001 * u * u * u), 1e-12);
        }
        let zones = bent(
            tier,
            Law::Asymmetry {
                thresholds: vec![2.0, 5.0],
                slopes: vec![0.2, -0.1],
            },
        );
        // Far from a rounded corner its asymptotes are those of the sharp one.
        let beyond = |u: f64| u + 0.2 * (u - 2.0).max(0.0) - 0.1 * (u - 5.0).max(0.0);
        let rounded = if tier == Tier::Other { 0.02 } else { 1e-12 };
        for k in [0, 35, 100] {
            near(zones[k], 1.0 + 2.0 * beyond(ramp[k]), rounded * 2.0);
        }
    }
}

#[test]
fn clipped_slewed_rounded() {
    for tier in TIERS {
        let drive: Vec<f64> = (0..=100).map(|k| 0.1 * f64::from(k)).collect();
        let clipped = stage(tier, &[], 0.0, vec![Law::Saturation { limit_v: 7.0 }]).run(&drive, H);
        near(clipped[69], 1.0 + 2.0 * 6.9, 1e-12);
        near(clipped[100], 15.0, 1e-12);

        let mut step = vec![0.0];
        step.resize(200, 6.0);
        let law = Law::SlewLimit {
            slew_v_per_s: 500.0,
        };
        let slewed = stage(tier, &[], 0.0, vec![law]).run(&step, H);
        near(slewed[50], 1.0 + 2.0 * 500.0 * 50.0 * H, 1e-9);
        near(slewed[199], 13.0, 1e-12);

        let law = Law::Quantisation { step: 0.75 };
        let rounded = stage(tier, &[], 0.0, vec![law]).run(&drive, H);
        for (y, u) in rounded.iter().zip(&drive) {
            near(y / 0.75 - (y / 0.75).round(), 0.0, 1e-12);
            near(*y, 1.0 + 2.0 * u, 0.375 + 1e-12);
        }
    }
}

#[test]
fn a_gap_holds_its_width_between_the_branches() {
    let way = |k: i32| 5.0 - 3.0 * (TAU * f64::from(k) / 400.0).cos();
    let drive: Vec<f64> = (0..=800).map(way).collect();
    for tier in TIERS {
        let law = Law::Backlash { width: 0.5 };
        let y = stage(tier, &[], 0.0, vec![law]).run(&drive, 1e-2);
        // Equal drives on the way up and on the way down of the second cycle.
        near(y[700] - y[500], 2.0 * 0.5, 0.01);
    }
}

#[test]
fn interleaving_at_rest_is_a_fixed_point() {
    for tier in TIERS {
        let y = stage(tier, &[], 0.0, vec![Law::Interleaving { g: 0.02 }]).run(&[4.0; 50], H);
        for y in y {
            near(y, 1.0 + 8.0 / (1.0 - 0.08), 1e-9);
        }
    }
}

#[test]
fn weights_grow_with_the_output() {
    let (u, r, a, kappa) = (8.0, 1.5, 0.4, 0.03);
    let drive: Vec<f64> = (0..=80).map(|k| 0.1 * f64::from(k)).collect();
    let y = stage(Tier::Finer, &[(r, a)], 0.0, vec![Law::Congruency { kappa }]).run(&drive, 0.1);
    let w = (y[80] - 1.0) / 2.0;
    near(w, u + (1.0 + kappa * w) * a * (u - r), 1e-12);
}

/// Equal minor loops at two biases in the other families: larger where kappa says so.
#[test]
fn minor_loops_grow_with_the_bias_in_other_families() {
    for seed in 1..=8 {
        let mut plant = crate::support::hide(&[], seed, Tier::Other).plant;
        plant.baseline.beta_s = 0.0;
        let relays = matches!(plant.baseline.core.family, Family::Relays(_));
        let (middle, half) = (plant.setup.middle_v(), plant.setup.half_v());
        let largest = plant.setup.drive_max_v;
        let mut width = |bias: f64, laws: Vec<Law>| {
            plant.laws = laws;
            let way = |k: i32| bias - 0.2 * half * (TAU * f64::from(k) / 400.0).cos();
            let mut drive: Vec<f64> = (0..=400)
                .map(|k| middle + (bias - 0.2 * half - middle) * f64::from(k) / 400.0)
                .collect();
            drive.extend((0..=1200).map(way));
            let y = plant.run(&drive, 1e-2);
            y[401 + 1100] - y[401 + 900]
        };
        let mut ratio = |kappa: f64| {
            let laws = vec![Law::Congruency { kappa }];
            width(middle + 0.5 * half, laws.clone()) / width(middle - 0.5 * half, laws)
        };
        let (less, equal, more) = (ratio(-0.3 / largest), ratio(0.0), ratio(0.3 / largest));
        assert!(less < equal && equal < more, "{less} {equal} {more}");
        // Loops of Bouc and Wen's equation are congruent for no parameters.
        if relays {
            near(equal, 1.0, 0.05);
        }
    }
}
