//! Oscillators against the standard library's sine in double precision.

use heapless::spsc::Queue;
use hysteron::reference::{Reference, STREAM_LEN, Tone, Waveform, WaveformError};
use std::f64::consts::TAU;

const RATE: f32 = 10_000.0;

fn play(waveform: &Waveform, samples: usize) -> Vec<f64> {
    let mut queue = Queue::<f32, STREAM_LEN>::new();
    let (_, mut stream) = queue.split();
    let mut reference = Reference::new(waveform, RATE).unwrap();
    (0..samples)
        .map(|_| f64::from(reference.next(&mut stream).unwrap()))
        .collect()
}

fn tone(amplitude: f32, frequency_hz: f32) -> Tone {
    Tone {
        amplitude,
        frequency_hz,
    }
}

/// The frequency that 32 bits of phase stand for.
fn played_frequency(frequency: f32) -> f64 {
    let rate = f64::from(RATE);
    (f64::from(frequency) / rate * 2f64.powi(32)).round() / 2f64.powi(32) * rate
}

#[test]
fn a_sine_is_exact_to_rounding_for_a_million_samples() {
    for frequency in [0.05f32, 1.0, 50.0, 100.0, 777.7, 2500.0] {
        let waveform = Waveform::Tones {
            offset: 0.0,
            tones: [tone(40.0, frequency), tone(0.0, 0.0)],
        };
        let exact = played_frequency(frequency);
        assert!((exact - f64::from(frequency)).abs() <= 0.5 * f64::from(RATE) / 2f64.powi(32));
        let worst = play(&waveform, 1_000_000)
            .into_iter()
            .enumerate()
            .map(|(k, value)| {
                let turns = (exact / f64::from(RATE) * k as f64).fract();
                (value - 40.0 * (TAU * turns).sin()).abs()
            })
            .fold(0.0, f64::max);
        // A few roundings of a number near 40.
        assert!(worst < 40.0 * 3e-7, "{frequency} Hz: {worst:e}");
    }
}

#[test]
fn two_tones_add_up_about_their_offset() {
    let waveform = Waveform::Tones {
        offset: 3.0,
        tones: [tone(22.0, 10.0), tone(25.0, 30.0)],
    };
    for (k, value) in play(&waveform, 5_000).into_iter().enumerate() {
        let t = k as f64 / f64::from(RATE);
        let exact = 3.0 + 22.0 * (TAU * 10.0 * t).sin() + 25.0 * (TAU * 30.0 * t).sin();
        // The phase is rounded to 2^-33 of a turn each sample: 4e-6 radians at the end.
        assert!((value - exact).abs() < 2e-4, "{k}");
    }
}

#[test]
fn a_triangle_runs_straight_between_its_corners() {
    let waveform = Waveform::Triangle {
        offset: -2.0,
        tone: tone(40.0, 10.0),
    };
    for (k, value) in play(&waveform, 3_000).into_iter().enumerate() {
        let turns = (10.0 * k as f64 / f64::from(RATE)).fract();
        let exact = match turns {
            t if t < 0.25 => 4.0 * t,
            t if t < 0.75 => 2.0 - 4.0 * t,
            t => 4.0 * t - 4.0,
        };
        assert!((value - (40.0 * exact - 2.0)).abs() < 1e-4, "{k}: {value}");
    }
}

#[test]
fn what_cannot_be_played_is_refused() {
    let tones = |first| Waveform::Tones {
        offset: 0.0,
        tones: [first, tone(0.0, 0.0)],
    };
    let refused = |waveform: &Waveform| Reference::new(waveform, RATE).err();
    assert_eq!(
        refused(&tones(tone(1.0, 2500.1))),
        Some(WaveformError::Frequency)
    );
    assert_eq!(
        refused(&tones(tone(1.0, -1.0))),
        Some(WaveformError::Frequency)
    );
    assert_eq!(
        refused(&tones(tone(1.0, f32::NAN))),
        Some(WaveformError::Frequency)
    );
    assert_eq!(
        refused(&tones(tone(f32::INFINITY, 1.0))),
        Some(WaveformError::NotFinite)
    );
    let triangle = Waveform::Triangle {
        offset: f32::NAN,
        tone: tone(1.0, 1.0),
    };
    assert_eq!(refused(&triangle), Some(WaveformError::NotFinite));
}
