//! The asymmetry map and its inverse.

use hysteron::effect::asymmetry::{Asymmetry, Side};
use hysteron::error::{Field, ParameterError};
use hysteron::math::Real;
use proptest::prelude::*;

const M: usize = 4;

/// Slopes with positive partial sums, thresholds.
fn side() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    (
        0.2f64..3.0,
        prop::collection::vec((0.2f64..3.0, 0.1f64..10.0), 0..=M),
    )
        .prop_map(|(slope, rows)| {
            let (mut slopes, mut thresholds) = (vec![slope], Vec::new());
            let (mut sum, mut threshold) = (slope, 0.0);
            for (partial_sum, gap) in rows {
                slopes.push(partial_sum - sum);
                sum = partial_sum;
                threshold += gap;
                thresholds.push(threshold);
            }
            (slopes, thresholds)
        })
}

fn build<T: Real>(
    positive: &(Vec<f64>, Vec<f64>),
    negative: &(Vec<f64>, Vec<f64>),
) -> Asymmetry<T, M> {
    let to = |values: &[f64]| values.iter().map(|&v| T::from_f64(v)).collect::<Vec<T>>();
    let (a, b, c, d) = (
        to(&positive.0),
        to(&positive.1),
        to(&negative.0),
        to(&negative.1),
    );
    Asymmetry::new(
        Side {
            slopes: &a,
            thresholds: &b,
        },
        Side {
            slopes: &c,
            thresholds: &d,
        },
    )
    .unwrap()
}

/// The map by its definition as a piecewise linear function: integrate the slope from zero.
fn integrated(side: &(Vec<f64>, Vec<f64>), w: f64) -> f64 {
    let (mut value, mut from, mut slope) = (0.0, 0.0, side.0[0]);
    for (&threshold, &step) in side.1.iter().zip(&side.0[1..]) {
        value += slope * (w.min(threshold) - from).max(0.0);
        from = threshold;
        slope += step;
    }
    value + slope * (w - from).max(0.0)
}

proptest! {
    #[test]
    fn round_trip(positive in side(), negative in side(), w in -60.0f64..60.0) {
        let map = build::<f64>(&positive, &negative);
        let back = map.inverse().unwrap().step(map.step(w));
        prop_assert!((back - w).abs() <= 1e-9, "{back} {w}");
        let map = build::<f32>(&positive, &negative);
        let back = map.inverse().unwrap().step(map.step(w as f32));
        prop_assert!((back - w as f32).abs() <= 1e-4 * 60.0, "{back} {w}");
    }

    #[test]
    fn value_is_the_integral_of_the_slopes(positive in side(), negative in side(), w in 0.0f64..60.0) {
        let map = build::<f64>(&positive, &negative);
        prop_assert!((map.step(w) - integrated(&positive, w)).abs() < 1e-9);
        prop_assert!((map.step(-w) + integrated(&negative, w)).abs() < 1e-9);
    }
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let good = Side {
        slopes: &[1.0, 0.5][..],
        thresholds: &[2.0][..],
    };
    let refused = |side: Side<'_, f64>| {
        (
            Asymmetry::<f64, 2>::new(side, good).unwrap_err(),
            Asymmetry::<f64, 2>::new(good, side).unwrap_err(),
        )
    };
    use Field::*;
    use ParameterError::*;
    type Refusal = fn(Field, Field) -> ParameterError;
    let cases: [(&[f64], &[f64], Refusal); 7] = [
        (&[], &[], |s, _| Length(s)),
        (&[1.0], &[2.0], |s, _| Length(s)),
        (&[1.0; 4], &[1.0, 2.0, 3.0], |_, r| Length(r)),
        (&[1.0, -1.0], &[2.0], |s, _| PartialSum(s, 1)),
        (&[1.0, f64::NAN], &[2.0], |s, _| NotFinite(s, 1)),
        (&[1.0, 0.1, 0.1], &[2.0, 2.0], |_, r| NotIncreasing(r, 1)),
        (&[1.0, 0.1], &[f64::INFINITY], |_, r| NotFinite(r, 0)),
    ];
    for (slopes, thresholds, expected) in cases {
        let (positive, negative) = refused(Side { slopes, thresholds });
        assert_eq!(positive, expected(PositiveSlopes, PositiveThresholds));
        assert_eq!(negative, expected(NegativeSlopes, NegativeThresholds));
    }
}
