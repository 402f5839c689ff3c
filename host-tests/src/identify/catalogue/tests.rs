//! From numbers to a stage and back.

use crate::model_file::{self, Stage, TwoSided};

use super::{Effect, Seen};

fn seen() -> Seen {
    Seen {
        sample_time_s: 2e-4,
        displacement_um: 21.0,
        duration_s: 30.0,
        time_s: (100.0, 900.0),
        drive_v: 60.0,
        rate_v_per_s: 7e3,
        threshold_v: 25.0,
        line_um: (-18.0, 24.0),
        frequency_span: 100.0,
        step_um: Some(0.01),
    }
}

/// Every template, each of its starts, moved into its bounds: the numbers come back.
#[test]
fn numbers_come_back_from_the_stage() {
    let gain = 0.7;
    for seen in [
        seen(),
        Seen {
            line_um: (0.0, 42.0),
            ..seen()
        },
        Seen {
            line_um: (-42.0, 0.0),
            ..seen()
        },
    ] {
        for effect in Effect::ALL {
            let template = effect.template();
            let starts = template.starts(&seen);
            assert!(!starts.is_empty(), "{}", effect.name());
            for mut numbers in starts {
                let bounds = template.bounds(&seen, &numbers);
                assert_eq!(bounds.len(), numbers.len(), "{}", effect.name());
                for (i, (x, (low, high))) in numbers.iter_mut().zip(bounds).enumerate() {
                    // Corners of a side must stay in order.
                    let step = 0.02 / (1.0 + i as f64) * (high - low);
                    *x = (*x + step).clamp(low, high);
                }
                let Some(stage) = template.stage(&numbers, &seen, gain) else {
                    assert_eq!(effect, Effect::RateDependence);
                    continue;
                };
                let back = template.numbers(&stage, &seen, gain).unwrap();
                assert_eq!(back.len(), numbers.len(), "{}", effect.name());
                for (a, b) in back.iter().zip(&numbers) {
                    let close = (a - b).abs() < 1e-9 * (1.0 + b.abs());
                    assert!(close, "{}: {back:?} for {numbers:?}", effect.name());
                }
            }
        }
    }
}

/// No template takes the stage of another one for its own.
#[test]
fn numbers_of_another_effect_are_none() {
    let stage = Stage::Saturation(model_file::Saturation { limit_v: 40.0 });
    for effect in Effect::ALL {
        let own = effect == Effect::Saturation;
        let numbers = effect.template().numbers(&stage, &seen(), 1.0);
        assert_eq!(numbers.is_some(), own, "{}", effect.name());
    }
}

/// Lambda by its definition (J 29).
fn bent(map: &model_file::Asymmetry, w: f64) -> f64 {
    let (thresholds, slopes) = if w >= 0.0 {
        (&map.thresholds.positive, &map.slopes.positive)
    } else {
        (&map.thresholds.negative, &map.slopes.negative)
    };
    let corners = std::iter::once(&0.0).chain(thresholds);
    let zones = corners.zip(slopes);
    w.signum() * zones.map(|(r, g)| g * (w.abs() - r).max(0.0)).sum::<f64>()
}

/// Maps with other numbers of zones than a fit's own stay the same map, but for the slope at zero,
/// which is the gain's.
#[test]
fn a_map_of_any_zones_is_kept() {
    let template = Effect::Asymmetry.template();
    let unipolar = Seen {
        line_um: (-0.5, 41.5),
        ..seen()
    };
    let map = |positive: [&[f64]; 2], negative: [&[f64]; 2]| model_file::Asymmetry {
        thresholds: TwoSided {
            positive: positive[0].to_vec(),
            negative: negative[0].to_vec(),
        },
        slopes: TwoSided {
            positive: positive[1].to_vec(),
            negative: negative[1].to_vec(),
        },
    };
    let maps = [
        map([&[5.0], &[1.0, 0.2]], [&[], &[1.0]]),
        map(
            [
                &[4.0, 8.0, 12.0, 16.0, 20.0],
                &[0.8, 0.1, 0.1, -0.1, 0.1, 0.05],
            ],
            [&[3.0, 50.0], &[0.9, -0.1, 0.2]],
        ),
        map([&[], &[1.0]], [&[], &[0.9]]),
    ];
    for seen in [seen(), unipolar] {
        for map in &maps {
            let gain = 0.7;
            let stage = Stage::Asymmetry(map.clone());
            let numbers = template.numbers(&stage, &seen, gain).unwrap();
            let Some(Stage::Asymmetry(back)) = template.stage(&numbers, &seen, gain) else {
                panic!("{numbers:?}");
            };
            for k in -60..=60 {
                let w = f64::from(k);
                let (a, b) = (bent(map, w), map.slopes.positive[0] * bent(&back, w));
                assert!((a - b).abs() < 1e-9, "{map:?} at {w}: {a} and {b}");
            }
        }
    }
}
