//! The oscillator of the harmonic terms, and which harmonics they hold.

use hysteron::hysteresis::modified_play::{Basis, BasisParameters, Harmonics};
use hysteron::phasor::{Phasor, Rotation};
use proptest::prelude::*;
use std::f64::consts::TAU;

const DT: f64 = 2e-4;

/// Amplitudes of the harmonics 0 to 7 of one period, by the definition of the transform.
fn harmonics(period: &[f64]) -> [f64; 8] {
    let n = period.len() as f64;
    std::array::from_fn(|order| {
        let sum = |phase: fn(f64) -> f64| -> f64 {
            let term = |(k, x): (usize, &f64)| x * phase(TAU * order as f64 * k as f64 / n);
            period.iter().enumerate().map(term).sum()
        };
        sum(f64::cos).hypot(sum(f64::sin)) / n * if order == 0 { 1.0 } else { 2.0 }
    })
}

/// Each of the six terms over one period of `u = sin`, at 25 Hz.
fn terms(form: Harmonics) -> [Vec<f64>; 6] {
    let basis: Basis<f64, 2> = BasisParameters {
        u_max: 1.0,
        divisions: 2,
        alpha: 0.0,
        beta: 0.0,
        harmonics: form,
        frequency: 25.0,
    }
    .build(DT)
    .unwrap();
    let mut state = basis.start();
    let mut terms: [Vec<f64>; 6] = Default::default();
    for k in 0..600 {
        let u = (TAU * 25.0 * k as f64 * DT).sin();
        let signals = basis.advance(&mut state, u, 0.0);
        state.remember(u, 0.0);
        if k >= 400 {
            terms
                .iter_mut()
                .zip(signals.harmonics)
                .for_each(|(list, term)| list.push(term));
        }
    }
    terms
}

/// The paper's harmonic terms are there for the third and fifth harmonic, and hold neither.
#[test]
fn the_printed_terms_hold_even_harmonics_only() {
    for (term, degree) in terms(Harmonics::Printed).iter().zip([2, 2, 4, 4, 6, 6]) {
        let found = harmonics(term);
        for (order, amplitude) in found.iter().enumerate() {
            if order % 2 == 1 || order > degree {
                assert!(*amplitude < 1e-13, "harmonic {order}: {amplitude:e}");
            }
        }
        assert!(found[degree] > 0.01, "harmonic {degree} of {found:?}");
    }
}

#[test]
fn the_corrected_terms_hold_the_first_third_and_fifth() {
    for (term, degree) in terms(Harmonics::Corrected).iter().zip([1, 1, 3, 3, 5, 5]) {
        let found = harmonics(term);
        for (order, amplitude) in found.iter().enumerate() {
            if order % 2 == 0 || order > degree {
                assert!(*amplitude < 1e-13, "harmonic {order}: {amplitude:e}");
            }
        }
        assert!(found[degree] > 0.05, "harmonic {degree} of {found:?}");
    }
}

/// Largest error of the length, and error of the angle at the end, after this many samples.
fn run<T: hysteron::math::Real>(frequency: f64, sample_time: f64, samples: u64) -> (f64, f64) {
    let rotation = Rotation::new(T::from_f64(frequency), T::from_f64(sample_time)).unwrap();
    let mut phasor = Phasor::<T>::zero();
    let mut worst = 0.0f64;
    for _ in 0..samples {
        rotation.step(&mut phasor);
        let (sine, cosine) = (phasor.sine.to_f64(), phasor.cosine.to_f64());
        worst = worst.max((sine * sine + cosine * cosine - 1.0).abs() / 2.0);
    }
    let turns = T::from_f64(frequency).to_f64() * T::from_f64(sample_time).to_f64();
    let angle = TAU * (turns * samples as f64).fract();
    let (sine, cosine) = (phasor.sine.to_f64(), phasor.cosine.to_f64());
    let difference = (sine * angle.cos() - cosine * angle.sin())
        .atan2(cosine * angle.cos() + sine * angle.sin());
    (worst, difference.abs())
}

/// The length does not know how many samples there were: the largest error is reached in the first
/// thousands and stays, and an error of the length is squared in every sample (below). So the bound
/// for 10^9 samples is the one seen here.
#[test]
fn the_oscillator_keeps_its_length() {
    for frequency in [1.0, 25.0, 74.0, 110.0, 1250.0, 2500.0] {
        for sample_time in [1e-4, 2e-4] {
            let (early, _) = run::<f32>(frequency, sample_time, 10_000);
            let (length, angle) = run::<f32>(frequency, sample_time, 1_000_000);
            println!("f32, {frequency} Hz: length {early:e}, {length:e}, angle {angle:e}");
            assert!(length < 5e-7, "{frequency} Hz: {length:e}");
            let (length, angle) = run::<f64>(frequency, sample_time, 1_000_000);
            assert!(
                length < 1e-15 && angle < 1e-8,
                "{frequency} Hz: {length:e}, {angle:e}"
            );
        }
    }
}

/// Ten million samples: 1,000 s at 10 kHz.
#[test]
fn the_oscillator_keeps_its_length_for_ten_million_samples() {
    let (length, angle) = run::<f32>(25.0, 1e-4, 10_000_000);
    println!("length {length:e}, angle {angle:e}");
    assert!(length < 5e-7, "{length:e}");
    // A hundredth of a period of 25 Hz after 25,000 of them.
    assert!(angle < 0.06, "{angle:e}");
}

proptest! {
    /// x -> -(3/2) x^2 - (1/2) x^3, at any angle and frequency.
    #[test]
    fn an_error_of_the_length_is_squared(
        error in -0.1f64..0.1,
        angle in 0.0..TAU,
        frequency in 0.0f64..2500.0,
    ) {
        let rotation = Rotation::new(frequency, DT).unwrap();
        let mut phasor = Phasor {
            sine: (1.0 + error) * angle.sin(),
            cosine: (1.0 + error) * angle.cos(),
        };
        rotation.step(&mut phasor);
        let length = phasor.sine.hypot(phasor.cosine);
        let expected = 1.0 - 1.5 * error * error - 0.5 * error * error * error;
        prop_assert!((length - expected).abs() < 1e-14);
        // And the angle has grown by one sample's.
        let next = angle + TAU * frequency * DT;
        let off = phasor.sine * next.cos() - phasor.cosine * next.sin();
        prop_assert!(off.abs() < 1e-14, "{off:e}");
    }
}
