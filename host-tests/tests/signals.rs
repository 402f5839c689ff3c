//! Test signals and metrics against closed forms.

use std::f64::consts::{PI, TAU};

use hysteron_host::experiment::references::{
    Grid, Reference, ReferenceError, Tone, example_f, major_minor, multisine, raster, sine, tones,
    triangle,
};
use hysteron_host::metrics::{
    MetricError, hysteresis_percent, line, max_abs_error, rms, rms_error,
};

const H: f64 = 1e-4;

fn second() -> Grid {
    Grid::for_duration(H, 1.0).unwrap()
}

fn at(signal: &Reference, t: f64) -> f64 {
    signal.samples[(t / H).round() as usize]
}

/// Samples of y = cos(wt - phi) over x = cos(wt), one cycle of `n` samples starting anywhere.
fn ellipse(n: usize, start: usize, phi: f64) -> (Vec<f64>, Vec<f64>) {
    let turn = |k: usize| TAU * (k + start) as f64 / n as f64;
    (0..n)
        .map(|k| (turn(k).cos(), (turn(k) - phi).cos()))
        .unzip()
}

#[test]
fn hysteresis_of_an_ellipse_is_the_sine_of_its_phase() {
    for phi in [0.01, 0.2, 1.0, PI / 2.0, -0.4] {
        for start in [0, 1, 123, 777] {
            let (x, y) = ellipse(1000, start, phi);
            let found = hysteresis_percent(&x, &y).unwrap();
            let expected = 100.0 * phi.sin().abs();
            assert!(
                (found / expected - 1.0).abs() < 1e-4,
                "{found} for {expected}"
            );
        }
    }
}

#[test]
fn hysteresis_of_a_parallelogram_is_exact_from_its_corners() {
    // A play with threshold 10 under +-40: width 20, range 60.
    let x = [-40.0, -20.0, 40.0, 20.0];
    let y = [-30.0, -30.0, 30.0, 30.0];
    assert!((hysteresis_percent(&x, &y).unwrap() - 100.0 / 3.0).abs() < 1e-12);
    // Plateaus of the input, one of them across the seam, change nothing.
    let x = [-40.0, -20.0, 40.0, 40.0, 20.0, -40.0, -40.0];
    let y = [-30.0, -30.0, 30.0, 30.0, 30.0, -30.0, -30.0];
    assert!((hysteresis_percent(&x, &y).unwrap() - 100.0 / 3.0).abs() < 1e-12);
}

#[test]
fn a_curve_without_a_loop_has_no_hysteresis() {
    let (x, _) = ellipse(500, 17, 0.0);
    let cubic: Vec<f64> = x.iter().map(|x| x + 0.3 * x.powi(3)).collect();
    // Chords instead of arcs: only the interpolation is left.
    assert!(hysteresis_percent(&x, &cubic).unwrap() < 0.01);
}

#[test]
fn what_is_not_one_loop_is_refused() {
    let (x, y) = ellipse(100, 0, 0.3);
    let still = vec![1.0; 100];
    let twice: Vec<f64> = (0..100)
        .map(|k| (TAU * f64::from(k) / 50.0).sin())
        .collect();
    assert!(matches!(
        hysteresis_percent(&twice, &y),
        Err(MetricError::NotOneLoop { .. })
    ));
    assert_eq!(
        hysteresis_percent(&[0.0, 1.0, 0.5, 2.0], &[0.0, 1.0, 0.5, 2.0]),
        Err(MetricError::NotOneLoop { index: 1 })
    );
    assert_eq!(
        hysteresis_percent(&still, &y),
        Err(MetricError::NoRange { signal: "input" })
    );
    assert_eq!(
        hysteresis_percent(&x, &still),
        Err(MetricError::NoRange { signal: "output" })
    );
    assert_eq!(
        hysteresis_percent(&x, &y[1..]),
        Err(MetricError::Length {
            left: 100,
            right: 99
        })
    );
    assert_eq!(hysteresis_percent(&[], &[]), Err(MetricError::Empty));
    assert_eq!(
        rms(&[0.0, f64::NAN]),
        Err(MetricError::NotFinite { index: 1 })
    );
    assert_eq!(
        rms_error(&[0.0], &[f64::INFINITY]),
        Err(MetricError::NotFinite { index: 0 })
    );
}

#[test]
fn errors_of_known_differences() {
    let (a, b) = ([1.0, 2.0, 3.0, 4.0], [1.0, 2.0, 0.0, 8.0]);
    assert_eq!(max_abs_error(&a, &b), Ok(4.0));
    assert_eq!(rms_error(&a, &b), Ok(2.5));
    assert_eq!(rms(&[3.0, -3.0]), Ok(3.0));
    let sine = sine(&second(), 2.0, 50.0, 0.7).unwrap().samples;
    assert!((rms(&sine).unwrap() - 2.0_f64.sqrt()).abs() < 1e-12);
}

#[test]
fn a_line_is_found_among_others() {
    let parts = [
        Tone {
            phase_rad: 0.4,
            ..Tone::new(3.0, 25.0)
        },
        Tone {
            phase_rad: -2.0,
            ..Tone::new(0.01, 75.0)
        },
        Tone {
            phase_rad: 3.0,
            ..Tone::new(0.5, 4999.0)
        },
    ];
    let mut signal = tones(&second(), &parts).unwrap().samples;
    signal.iter_mut().for_each(|x| *x += 7.0);
    for part in parts {
        let found = line(&signal, H, part.frequency_hz).unwrap();
        assert!((found.amplitude - part.amplitude).abs() < 1e-11);
        assert!((found.phase_rad - part.phase_rad).abs() < 1e-9);
    }
    assert!(line(&signal, H, 50.0).unwrap().amplitude < 1e-11);
    for frequency_hz in [0.0, 25.5, 5000.0, -25.0, f64::NAN] {
        assert!(matches!(
            line(&signal, H, frequency_hz),
            Err(MetricError::Periods { .. })
        ));
    }
}

#[test]
fn a_triangle_has_the_fourier_series_of_a_triangle() {
    let signal = triangle(&second(), 40.0, 10.0, 0.0).unwrap();
    for k in [1.0_f64, 2.0, 3.0, 4.0, 5.0, 7.0] {
        let found = line(&signal.samples, H, 10.0 * k).unwrap().amplitude;
        let expected = if k % 2.0 == 0.0 {
            0.0
        } else {
            40.0 * 8.0 / (PI * k).powi(2)
        };
        assert!(
            (found - expected).abs() < 1e-3,
            "line {k}: {found}, expected {expected}"
        );
    }
    // Zeros, extremes and slope where the sine has its own.
    let slope = 40.0 * 4.0 * 10.0 * H;
    assert!(
        signal
            .samples
            .windows(2)
            .all(|x| ((x[1] - x[0]).abs() - slope).abs() < 1e-9)
    );
    assert!((at(&signal, 0.025) - 40.0).abs() < 1e-9 && (at(&signal, 0.075) + 40.0).abs() < 1e-9);
    let quarter = triangle(&second(), 40.0, 10.0, PI / 2.0).unwrap();
    assert!((quarter.samples[0] - 40.0).abs() < 1e-9);
}

#[test]
fn large_and_small_periods_alternate() {
    let signal = major_minor(&second(), 40.0, 15.0, 10.0).unwrap();
    let largest = |from: usize| {
        signal.samples[from..from + 1000]
            .iter()
            .fold(0.0, |m: f64, x| m.max(x.abs()))
    };
    for pair in 0..5 {
        assert!((largest(2000 * pair) - 40.0).abs() < 1e-9);
        assert!((largest(2000 * pair + 1000) - 15.0).abs() < 1e-9);
    }
    let steepest = 40.0 * TAU * 10.0 * H;
    assert!(
        signal
            .samples
            .windows(2)
            .all(|x| (x[1] - x[0]).abs() <= steepest * 1.001)
    );
    // A small period is entered and left while the drive rises.
    assert!(at(&signal, 0.0999) < 0.0 && at(&signal, 0.1001) > 0.0);
    assert!(at(&signal, 0.1999) < 0.0 && at(&signal, 0.2001) > 0.0);
}

#[test]
fn the_worked_example_is_its_formula() {
    for f in [10.0, 60.0] {
        let signal = example_f(&second(), f).unwrap();
        let expected: Vec<f64> = (0..signal.samples.len())
            .map(|k| k as f64 * H)
            .map(|t| 22.0 * (2.0 * PI * f * t).sin() + 25.0 * (6.0 * PI * f * t).sin())
            .collect();
        assert!(max_abs_error(&signal.samples, &expected).unwrap() < 1e-9);
    }
}

#[test]
fn a_multisine_has_equal_lines_a_peak_and_a_seed() {
    let signal = multisine(&second(), 30.0, 2.0, 1..=50, 9).unwrap();
    let line_at = |k: f64| line(&signal.samples, H, 2.0 * k).unwrap();
    let first = line_at(1.0).amplitude;
    assert!((2..=50).all(|k| (line_at(f64::from(k)).amplitude / first - 1.0).abs() < 1e-9));
    assert!(line_at(51.0).amplitude < 1e-10);
    let peak = signal.samples.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    assert!((peak - 30.0).abs() < 1e-12);
    // Random phases keep the crest factor far from the 10 of lines in phase.
    assert!(peak / rms(&signal.samples).unwrap() < 5.0);
    assert_eq!(signal, multisine(&second(), 30.0, 2.0, 1..=50, 9).unwrap());
    assert_ne!(signal, multisine(&second(), 30.0, 2.0, 1..=50, 10).unwrap());
}

#[test]
fn a_raster_visits_every_line_once() {
    let (lines, line_rate_hz) = (5, 10.0);
    let scan = raster(H, 20.0, 8.0, lines, line_rate_hz).unwrap();
    assert_eq!(
        (scan.fast.samples.len(), scan.slow.samples.len()),
        (5000, 5000)
    );
    for index in 0..lines as usize {
        let start = index * 1000;
        let position = 2.0 * index as f64;
        let trace = &scan.slow.samples[start..start + 500];
        assert!(
            trace.iter().all(|y| (y - position).abs() < 1e-9),
            "line {index} is not straight"
        );
        for k in 0..1000 {
            let expected = 20.0 * if k < 500 { k as f64 } else { 1000.0 - k as f64 } / 500.0;
            assert!((scan.fast.samples[start + k] - expected).abs() < 1e-9);
        }
    }
    // Steps are ramps over half a line and the last line's retrace stays.
    assert!(
        scan.slow
            .samples
            .windows(2)
            .all(|y| (0.0..=0.0040001).contains(&(y[1] - y[0])))
    );
    assert!((scan.slow.samples[4999] - 8.0).abs() < 1e-9);
}

#[test]
fn grids_count_samples() {
    assert_eq!(second().samples(), 10_000);
    assert_eq!(Grid::for_cycles(H, 50.0, 3.0).unwrap().samples(), 600);
    assert_eq!(Grid::for_cycles(H, 0.05, 1.0).unwrap().samples(), 200_000);
    // The phase after a million cycles is still exact.
    let long = Grid::for_cycles(0.125, 1.0, 1e6).unwrap();
    let signal = sine(&long, 1.0, 1.0, 0.0).unwrap().samples;
    assert!((signal[signal.len() - 6] - 1.0).abs() < 1e-12);
}

#[test]
fn bad_parameters_are_refused_by_name() {
    let grid = second();
    let refused: [(&str, Result<Reference, ReferenceError>); 14] = [
        ("amplitude", sine(&grid, f64::NAN, 1.0, 0.0)),
        ("frequency_hz", sine(&grid, 1.0, 5000.0, 0.0)),
        ("frequency_hz", sine(&grid, 1.0, 0.0, 0.0)),
        ("phase_rad", sine(&grid, 1.0, 1.0, f64::INFINITY)),
        ("amplitude", triangle(&grid, f64::INFINITY, 1.0, 0.0)),
        ("frequency_hz", triangle(&grid, 1.0, -1.0, 0.0)),
        ("small", major_minor(&grid, 10.0, 11.0, 1.0)),
        ("large", major_minor(&grid, f64::NAN, 1.0, 1.0)),
        ("frequency_hz", example_f(&grid, 2000.0)),
        ("peak", multisine(&grid, f64::NAN, 1.0, 1..=3, 0)),
        ("harmonics", multisine(&grid, 1.0, 1.0, 0..=3, 0)),
        ("fundamental_hz", multisine(&grid, 1.0, 1.0, 1..=5000, 0)),
        ("lines", raster(H, 1.0, 1.0, 1, 1.0).map(|scan| scan.fast)),
        (
            "line_rate_hz",
            raster(H, 1.0, 1.0, 2, 0.0).map(|scan| scan.slow),
        ),
    ];
    for (expected, result) in refused {
        assert_eq!(result.unwrap_err().field, expected);
    }
    let grids = [
        ("sample_time_s", Grid::for_duration(0.0, 1.0)),
        ("sample_time_s", Grid::for_cycles(f64::NAN, 1.0, 1.0)),
        ("duration_s", Grid::for_duration(1e-9, 1e9)),
        ("duration_s", Grid::for_duration(1.0, f64::NAN)),
        ("cycles", Grid::for_cycles(H, 1.0, 0.0)),
        ("frequency_hz", Grid::for_cycles(H, 0.0, 1.0)),
    ];
    for (expected, result) in grids {
        assert_eq!(result.unwrap_err().field, expected);
    }
}
