//! The dynamic parts of a hidden stage, each taking a whole record; all begin at rest.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;

use crate::plant::amplifier::Amplifier;
use crate::plant::bimorph::{Mode, Vibration};

/// `steps` steps in place of each one, along straight lines.
pub(super) fn refine(samples: &[f64], steps: usize) -> Vec<f64> {
    let mut fine = Vec::with_capacity(samples.len() * steps);
    fine.extend(samples.first());
    for pair in samples.windows(2) {
        let slope = (pair[1] - pair[0]) / steps as f64;
        fine.extend((1..steps).map(|step| pair[0] + slope * step as f64));
        fine.push(pair[1]);
    }
    fine
}

/// At most `most` further in a step.
pub(super) fn limit_steps(signal: &mut [f64], most: f64) {
    for k in 1..signal.len() {
        let way = signal[k] - signal[k - 1];
        signal[k] = signal[k - 1] + way.clamp(-most, most);
    }
}

/// A first-order lag, exact for straight lines.
pub(super) fn lag(signal: &mut [f64], tau_s: f64, step_s: f64) {
    let Some(&first) = signal.first() else { return };
    let mut pole = Amplifier::new(tau_s, step_s, first);
    let mut from = first;
    for x in signal {
        let to = *x;
        *x = pole.advance(from, to);
        from = to;
    }
}

/// The signal `samples` steps ago, a cubic between the samples.
pub(super) fn delay(signal: &[f64], samples: f64) -> Vec<f64> {
    if samples == 0.0 {
        return signal.to_vec();
    }
    // The four samples end at the newest one where the delay is shorter than a step.
    let newest = (samples.floor() - 1.0).max(0.0);
    let place = samples - newest;
    let weights: [f64; 4] = std::array::from_fn(|node| {
        (0..4)
            .filter(|&other| other != node)
            .map(|other| (place - other as f64) / (node as f64 - other as f64))
            .product()
    });
    let newest = newest as usize;
    (0..signal.len())
        .map(|k| {
            let tap = |age: usize| signal[k.saturating_sub(newest + age)];
            (0..4).map(|age| weights[age] * tap(age)).sum()
        })
        .collect()
}

/// A play of half-width `half` along `signal` from a middle at `z`; where that ends.
pub(super) fn backlash(mut z: f64, signal: &mut [f64], half: f64) -> f64 {
    for w in signal {
        z = z.clamp(*w - half, *w + half);
        *w = z;
    }
    z
}

/// The same gap with a compliant contact: what touches is pulled in with a time constant. At rest at
/// the first sample.
pub(super) fn soft_backlash(
    mut z: f64,
    signal: &mut [f64],
    half: f64,
    contact_s: f64,
    step_s: f64,
) -> f64 {
    let share = -(-step_s / contact_s).exp_m1();
    for (k, w) in signal.iter_mut().enumerate() {
        let wanted = z.clamp(*w - half, *w + half);
        z = if k == 0 {
            wanted
        } else {
            z + (wanted - z) * share
        };
        *w = z;
    }
    z
}

/// A mode, exact for straight lines.
pub(super) fn mode(signal: &mut [f64], frequency_hz: f64, damping: f64, step_s: f64) {
    let Some(&rest) = signal.first() else { return };
    let mut mode = Vibration::new(
        Mode {
            frequency_hz,
            damping,
        },
        step_s,
    );
    for x in signal {
        *x = rest + mode.advance(*x - rest);
    }
}

/// A mode by the classical Runge-Kutta method along straight lines.
pub(super) fn mode_by_runge_kutta(
    signal: &mut [f64],
    frequency_hz: f64,
    damping: f64,
    step_s: f64,
) {
    let Some(&rest) = signal.first() else { return };
    let w = std::f64::consts::TAU * frequency_hz;
    let slope = |x: f64, v: f64, input: f64| (v, w * w * (input - x) - 2.0 * damping * w * v);
    let (mut x, mut v, mut from) = (rest, 0.0, rest);
    for sample in signal {
        let to = *sample;
        let middle = 0.5 * (from + to);
        let half = 0.5 * step_s;
        let k1 = slope(x, v, from);
        let k2 = slope(x + half * k1.0, v + half * k1.1, middle);
        let k3 = slope(x + half * k2.0, v + half * k2.1, middle);
        let k4 = slope(x + step_s * k3.0, v + step_s * k3.1, to);
        x += step_s / 6.0 * (k1.0 + 2.0 * (k2.0 + k3.0) + k4.0);
        v += step_s / 6.0 * (k1.1 + 2.0 * (k2.1 + k3.1) + k4.1);
        from = to;
        *sample = x;
    }
}

/// Creep of exponentials a decade apart.
pub(super) fn creep(signal: &mut [f64], gain: f64, tau_min_s: f64, tau_max_s: f64, step_s: f64) {
    let Some(&rest) = signal.first() else { return };
    let mut crept = vec![0.0; signal.len()];
    let mut tau_s = tau_min_s;
    // Half a per cent of slack, so that rounding of the last decade does not lose it.
    while tau_s <= tau_max_s * 1.005 {
        let mut state = signal.to_vec();
        lag(&mut state, tau_s, step_s);
        crept
            .iter_mut()
            .zip(&state)
            .for_each(|(sum, x)| *sum += x - rest);
        tau_s *= 10.0;
    }
    signal
        .iter_mut()
        .zip(&crept)
        .for_each(|(x, crept)| *x += gain * crept);
}

/// Creep whose step response grows by `gain log10(1 + t / onset)`, exact for straight lines.
pub(super) fn logarithmic_creep(signal: &mut [f64], gain: f64, onset_s: f64, step_s: f64) {
    // Integral of log10(1 + t / onset) from 0.
    let grown = |t: f64| ((onset_s + t) * (t / onset_s).ln_1p() - t) / std::f64::consts::LN_10;
    let ages = signal.len().saturating_sub(1);
    let kernel: Vec<f64> = (0..ages)
        .map(|age| {
            let from = age as f64 * step_s;
            (grown(from + step_s) - grown(from)) / step_s
        })
        .collect();
    let moves: Vec<f64> = signal.windows(2).map(|pair| pair[1] - pair[0]).collect();
    for (x, crept) in signal.iter_mut().skip(1).zip(convolved(&moves, &kernel)) {
        *x += gain * crept;
    }
}

/// The first samples of the convolution of two signals of equal length.
fn convolved(a: &[f64], b: &[f64]) -> Vec<f64> {
    if a.is_empty() {
        return Vec::new();
    }
    let length = (2 * a.len()).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let forward = planner.plan_fft_forward(length);
    let lines = |signal: &[f64]| {
        let mut padded = signal.to_vec();
        padded.resize(length, 0.0);
        let mut lines = forward.make_output_vec();
        // Buffers of the planner's own lengths are never refused.
        let _ = forward.process(&mut padded, &mut lines);
        lines
    };
    let mut product: Vec<Complex<f64>> = lines(a)
        .into_iter()
        .zip(lines(b))
        .map(|(a, b)| a * b / length as f64)
        .collect();
    // Rounding leaves nothing here for real signals, but the inverse insists on it.
    if let [first, .., last] = product.as_mut_slice() {
        first.im = 0.0;
        last.im = 0.0;
    }
    let inverse = planner.plan_fft_inverse(length);
    let mut back = inverse.make_output_vec();
    let _ = inverse.process(&mut product, &mut back);
    back.truncate(a.len());
    back
}

/// `y = x + g y u`, both `steps` steps ago.
pub(super) fn interleave(signal: &mut [f64], drive_v: &[f64], g: f64, steps: usize) {
    let (Some(&rest), Some(&drive)) = (signal.first(), drive_v.first()) else {
        return;
    };
    let rest = rest / (1.0 - g * drive);
    for k in 0..signal.len() {
        let (y, u) = match k.checked_sub(steps) {
            Some(ago) => (signal[ago], drive_v[ago]),
            None => (rest, drive),
        };
        signal[k] += g * y * u;
    }
}
