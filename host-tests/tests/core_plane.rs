//! The triangular plane: its grid, its degrees of freedom, and parameters that are refused.

use hysteron::error::{Field, ParameterError};
use hysteron::hysteresis::modified_play::{
    Basis, BasisParameters, ClampedPlane, Grid, Harmonics, LinearPlane, ModifiedPlay, Terms,
};
use std::f64::consts::TAU;

/// Time between samples.
const DT: f64 = 2e-4;

/// Number of singular values above rounding.
fn rank(rows: &[Vec<f64>]) -> usize {
    let matrix = nalgebra::DMatrix::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j]);
    let values = matrix.singular_values();
    values
        .iter()
        .filter(|&&value| value > 1e-9 * values[0])
        .count()
}

/// Ranks of the terms of all 55 weights of N = 10 under an input: as printed, and clamped.
fn ranks(alpha: f64, beta: f64, input: &dyn Fn(usize) -> f64) -> (usize, usize) {
    let basis: Basis<f64, 10> = BasisParameters {
        u_max: 1.0,
        divisions: 10,
        alpha,
        beta,
        harmonics: Harmonics::Printed,
        frequency: 25.0,
    }
    .build(DT)
    .unwrap();
    let grid = basis.grid();
    assert_eq!(grid.weights(), 55);
    let mut state = basis.start();
    let (mut printed, mut clamped) = (vec![], vec![]);
    for k in 0..2000 {
        let u = input(k);
        let rate = basis.backward_rate(&state, u);
        let signals = basis.advance(&mut state, u, rate);
        state.remember(u, 0.0);
        let p = |i: usize| if i == 0 { u } else { signals.plays[i - 1] };
        let cells = grid.cells(0).map(|(i, j)| grid.printed(i, j, p(i)));
        printed.push(cells.collect());
        let cells = grid.cells(0).map(|(i, j)| grid.clamped(i, j, p(i)));
        clamped.push(cells.collect());
    }
    (rank(&printed), rank(&clamped))
}

/// The printed plane has at most 11 degrees of freedom under any input. The clamped one has as many
/// as weights under a rich input, and fewer under a sine.
#[test]
fn the_printed_plane_has_rank_eleven_and_the_clamped_one_does_not() {
    let mut seed = 1u64;
    let noise: Vec<f64> = (0..2000)
        .map(|_| {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        })
        .collect();
    let sine = |k: usize| (TAU * 25.0 * k as f64 * DT).sin();
    for (alpha, beta) in [(0.0, 0.0), (1e-4, 3e-4)] {
        let (printed, clamped) = ranks(alpha, beta, &|k| noise[k]);
        println!("noise, {alpha} {beta}: {printed} {clamped}");
        assert_eq!((printed, clamped), (11, 55));
        let (printed, clamped) = ranks(alpha, beta, &sine);
        println!("sine, {alpha} {beta}: {printed} {clamped}");
        assert!(printed <= 11);
        // Without a rate all corners lie on the lattice of the cells; a rate moves them off it.
        let expected = if alpha == 0.0 { 19..=34 } else { 35..=54 };
        assert!(expected.contains(&clamped), "{clamped}");
    }
}

#[test]
fn the_grid_is_the_printed_one() {
    let grid = Grid::<f64, 16>::new(1.0, 10).unwrap();
    assert_eq!((grid.weights(), grid.memory_weights()), (55, 45));
    assert_eq!(grid.cells(0).count(), 55);
    assert_eq!(grid.cells(1).next(), Some((1, 0)));
    assert_eq!(grid.threshold(3), 0.3);
    assert!((grid.point(0, 0) + 0.9).abs() < 1e-15 && (grid.point(0, 9) - 0.9).abs() < 1e-15);
    assert_eq!(grid.point(9, 0), 0.0);
    // Cells lie side by side: at any place one at most is within its limits.
    for (i, p) in (0..10).flat_map(|i| (-100..100).map(move |p| (i, f64::from(p) * 0.00997))) {
        let inside = (0..10 - i).filter(|&j| grid.clamped(i, j, p).abs() < 1.0);
        assert!(inside.count() <= 1, "row {i} at {p}");
    }
}

#[test]
fn bad_parameters_are_refused_by_name() {
    use Field::*;
    use ParameterError::*;
    let good = BasisParameters {
        u_max: 1.0,
        divisions: 4,
        alpha: 1e-4,
        beta: 2e-4,
        harmonics: Harmonics::Corrected,
        frequency: 25.0,
    };
    let refused =
        |parameters: BasisParameters<f64>, dt: f64| parameters.build::<4>(dt).unwrap_err();
    assert_eq!(
        refused(BasisParameters { u_max: 0.0, ..good }, DT),
        NotFinite(InputRange, 0)
    );
    assert_eq!(
        refused(
            BasisParameters {
                u_max: -1.0,
                ..good
            },
            DT
        ),
        NotPositive(InputRange)
    );
    assert_eq!(
        refused(
            BasisParameters {
                divisions: 1,
                ..good
            },
            DT
        ),
        Length(Divisions)
    );
    assert_eq!(
        refused(
            BasisParameters {
                divisions: 5,
                ..good
            },
            DT
        ),
        Length(Divisions)
    );
    assert_eq!(
        refused(
            BasisParameters {
                alpha: -1e-9,
                ..good
            },
            DT
        ),
        Negative(Alpha)
    );
    assert_eq!(
        refused(
            BasisParameters {
                beta: f64::NAN,
                ..good
            },
            DT
        ),
        NotFinite(Beta, 0)
    );
    assert_eq!(
        refused(BasisParameters { beta: -1.0, ..good }, DT),
        Negative(Beta)
    );
    assert_eq!(
        refused(
            BasisParameters {
                frequency: -1.0,
                ..good
            },
            DT
        ),
        Negative(Frequency)
    );
    assert_eq!(
        refused(
            BasisParameters {
                frequency: 2501.0,
                ..good
            },
            DT
        ),
        TooLarge(Frequency)
    );
    let infinite = BasisParameters {
        frequency: f64::INFINITY,
        ..good
    };
    assert_eq!(refused(infinite, DT), NotFinite(Frequency, 0));
    assert_eq!(refused(good, -DT), NotPositive(SampleTime));
    assert_eq!(refused(good, 0.0), NotFinite(SampleTime, 0));

    let basis = good.build::<4>(DT).unwrap();
    let grid = basis.grid();
    let slopes = |slopes: &[f64], offset| LinearPlane::new(grid, slopes, offset).unwrap_err();
    assert_eq!(slopes(&[1.0; 3], 0.0), Length(Slopes));
    assert_eq!(
        slopes(&[1.0, 1.0, f64::NAN, 1.0], 0.0),
        NotFinite(Slopes, 2)
    );
    assert_eq!(slopes(&[1.0; 4], f64::INFINITY), NotFinite(Offset, 0));
    assert_eq!(
        LinearPlane::collapse(grid, &[1.0; 9]).unwrap_err(),
        Length(PlaneWeights)
    );
    let cells = |gain, weights: &[f64]| ClampedPlane::new(grid, gain, weights).unwrap_err();
    assert_eq!(cells(1.0, &[1.0; 10]), Length(PlaneWeights));
    assert_eq!(cells(f64::NAN, &[1.0; 6]), NotFinite(Slopes, 0));
    let plane = LinearPlane::new(grid, &[1.0; 4], 0.0).unwrap();
    let terms = |terms| ModifiedPlay::new(&basis, plane, terms).unwrap_err();
    let none = Terms::none();
    let nan = f64::NAN;
    assert_eq!(
        terms(Terms {
            interleaving: nan,
            ..none
        }),
        NotFinite(Interleaving, 0)
    );
    assert_eq!(
        terms(Terms {
            feedback: [0.0, nan, 0.0],
            ..none
        }),
        NotFinite(Feedback, 1)
    );
    assert_eq!(
        terms(Terms {
            sine: [0.0, 0.0, nan],
            ..none
        }),
        NotFinite(Sine, 2)
    );
    assert_eq!(
        terms(Terms {
            cosine: [nan, 0.0, 0.0],
            ..none
        }),
        NotFinite(Cosine, 0)
    );
}
