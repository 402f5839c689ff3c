//! Feedback around the compensator, on the simulated stage that shares no code with the core.

use std::f64::consts::TAU;

use hysteron::error::{Field, ParameterError, SampleError};
use hysteron::feedback::{Feedback, Gains, State};
use hysteron_host::model_file::resolve;
use hysteron_host::plant::Stage;
use hysteron_host::stage;

const H: f64 = 1e-4;

fn gains() -> Gains<f64> {
    Gains {
        proportional: 0.05,
        integral: 300.0,
        derivative: 0.0,
        filter: 0.0,
    }
}

/// Rms error over the second half, in um, of a 5 Hz sine on the published stage with every parameter
/// off by the given share.
fn error(off: f64, compensated: bool, closed: bool) -> f64 {
    let reference: Vec<f64> = (0..8_000)
        .map(|k| 30.0 * (TAU * 5.0 * f64::from(k) * H).sin())
        .collect();
    let mut hysteresis = Stage::p753_three_plays().hysteresis;
    hysteresis.gain_um_per_v *= 1.0 + off;
    let stage = Stage::ideal(hysteresis);
    let model = stage::compensator(&resolve("p753").unwrap(), H).unwrap();
    let feedforward = if compensated {
        stage::compensate(&model, &reference).unwrap()
    } else {
        reference.iter().map(|v| v / 1.207).collect()
    };
    let feedback = Feedback::new(gains(), H, -60.0, 60.0).unwrap();
    let mut state = State::at_rest(0.0);
    let mut plant = stage.start(H, 0.0).unwrap();
    let mut measured = 0.0;
    let mut squares = 0.0;
    for (k, (&v, &u)) in reference.iter().zip(&feedforward).enumerate() {
        let drive = if closed {
            // The sensor of the sample before: the loop has a delay of one.
            feedback.step(&mut state, v, measured, u).unwrap()
        } else {
            u
        };
        measured = plant.step(drive).unwrap();
        if k >= reference.len() / 2 {
            squares += (measured - v) * (measured - v);
        }
    }
    (squares / (reference.len() / 2) as f64).sqrt()
}

#[test]
fn feedback_and_compensator_together_beat_either() {
    let open = error(0.1, false, false);
    let compensated = error(0.1, true, false);
    let closed = error(0.1, false, true);
    let both = error(0.1, true, true);
    println!(
        "rms error in um, weight a_0 10 % off: linear {open:.3}, compensated {compensated:.3}, \
         feedback alone {closed:.3}, both {both:.3}"
    );
    assert!(compensated < 0.7 * open);
    assert!(both < 0.6 * closed && both < 0.2 * compensated);
}

/// Against the difference equation written out with lists of all samples.
#[test]
fn it_is_a_pid() {
    let gains = Gains {
        proportional: 0.3,
        integral: 40.0,
        derivative: 2e-4,
        filter: 5e-4,
    };
    let feedback = Feedback::new(gains, H, -1e3, 1e3).unwrap();
    let mut state = State::at_rest(0.0);
    let signal = |k: usize, f: f64| (TAU * f * k as f64 * H).sin();
    let errors: Vec<f64> = (0..400)
        .map(|k| signal(k, 31.0) - signal(k, 12.0))
        .collect();
    let mut filtered = 0.0;
    for k in 0..400 {
        let drive = feedback
            .step(&mut state, signal(k, 31.0), signal(k, 12.0), 0.7)
            .unwrap();
        let trapezia: f64 = (0..=k)
            .map(|j| (errors[j] + if j > 0 { errors[j - 1] } else { 0.0 }) / 2.0)
            .sum();
        let before = if k > 0 { signal(k - 1, 12.0) } else { 0.0 };
        let slope = -(signal(k, 12.0) - before) / H;
        filtered += H / (5e-4 + H) * (2e-4 * slope - filtered);
        let truth = 0.7 + 0.3 * errors[k] + 40.0 * H * trapezia + filtered;
        assert!((drive - truth).abs() < 1e-12);
    }
}

#[test]
fn the_integral_does_not_wind_up() {
    let feedback = Feedback::new(gains(), H, -10.0, 10.0).unwrap();
    let mut state = State::at_rest(0.0);
    // Out of reach for a second: the drive stands at its limit.
    for _ in 0..10_000 {
        let drive = feedback.step(&mut state, 1e3, 0.0, 0.0).unwrap();
        assert!(drive <= 10.0);
    }
    // Then within reach: the drive leaves the limit at once, not after another second.
    let left = (0..10_000).position(|_| feedback.step(&mut state, -1.0, 0.0, 0.0).unwrap() < 10.0);
    assert!(left.unwrap() < 2, "{left:?}");
    // A feedforward beyond the limit winds nothing up either.
    let mut state = State::at_rest(0.0);
    for _ in 0..1_000 {
        assert_eq!(feedback.step(&mut state, 0.0, 0.0, 99.0).unwrap(), 10.0);
    }
    assert_eq!(feedback.step(&mut state, 0.0, 0.0, 3.0).unwrap(), 3.0);
}

#[test]
fn bad_samples_and_parameters_are_turned_away() {
    let feedback = Feedback::new(gains(), H, -10.0, 10.0).unwrap();
    let mut state = State::at_rest(1.0);
    for (v, y, u) in [
        (f64::NAN, 0.0, 0.0),
        (0.0, f64::INFINITY, 0.0),
        (0.0, 0.0, f64::NAN),
    ] {
        let refused = feedback.step(&mut state, v, y, u);
        assert_eq!(refused, Err(SampleError::NotFinite));
        assert_eq!(state, State::at_rest(1.0));
    }
    let wrong = Gains {
        integral: f64::NAN,
        ..gains()
    };
    assert_eq!(
        Feedback::new(wrong, H, -1.0, 1.0).unwrap_err(),
        ParameterError::NotFinite(Field::FeedbackGains, 1)
    );
    assert!(Feedback::new(gains(), 0.0, -1.0, 1.0).is_err());
    assert!(Feedback::new(gains(), H, 1.0, -1.0).is_err());
    let wrong = Gains {
        filter: -1.0,
        ..gains()
    };
    assert_eq!(
        Feedback::new(wrong, H, -1.0, 1.0).unwrap_err(),
        ParameterError::Negative(Field::TimeConstant)
    );
}
