//! Which frequencies a drive holds.

use realfft::RealFftPlanner;

/// Share of a drive's power below the lowest and above the highest frequency that counts.
const TAIL: f64 = 0.05;

/// Frequencies in hertz below which a twentieth and all but a twentieth of the drive's power lies;
/// `None` for a drive that does not move.
pub fn band(drive: &[f64], sample_time_s: f64) -> Option<(f64, f64)> {
    let count = drive.len();
    let mean = drive.iter().sum::<f64>() / count.max(1) as f64;
    // A Hann window: without it, a period that does not fit the record leaks over the whole band.
    let mut windowed: Vec<f64> = drive
        .iter()
        .enumerate()
        .map(|(k, u)| {
            let phase = std::f64::consts::TAU * (k as f64 + 0.5) / count as f64;
            (u - mean) * (1.0 - phase.cos())
        })
        .collect();
    let transform = RealFftPlanner::new().plan_fft_forward(count);
    let mut lines = transform.make_output_vec();
    transform.process(&mut windowed, &mut lines).ok()?;
    let power: Vec<f64> = lines.iter().skip(1).map(|line| line.norm_sqr()).collect();
    let total: f64 = power.iter().sum();
    if total <= 0.0 || !total.is_finite() {
        return None;
    }
    let below = |share: f64| {
        let mut sum = 0.0;
        power.iter().position(|p| {
            sum += p;
            sum >= share * total
        })
    };
    // The window spreads a tone over its neighbours; take that back.
    let (low, high) = (below(TAIL)?, below(1.0 - TAIL)?);
    let middle = 0.5 * (low + high) as f64;
    let frequency = |line: f64| (line + 1.0) / (count as f64 * sample_time_s);
    let low = (low as f64 + 1.0).min(middle);
    let high = (high as f64 - 1.0).max(middle);
    Some((frequency(low), frequency(high)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn bands_of_known_drives() {
        let drive = |tones: &[f64]| -> Vec<f64> {
            (0..10_000)
                .map(|k| {
                    3.0 + tones
                        .iter()
                        .map(|f| (TAU * f * k as f64 * 1e-3).sin())
                        .sum::<f64>()
                })
                .collect()
        };
        for tone in [0.4, 7.0, 7.03] {
            let (low, high) = band(&drive(&[tone]), 1e-3).unwrap();
            assert!(
                (low - tone).abs() < 0.06 && (high - tone).abs() < 0.06,
                "{low} {high}"
            );
        }
        let (low, high) = band(&drive(&[1.0, 7.0, 30.0, 90.0]), 1e-3).unwrap();
        assert!(
            (low - 1.0).abs() < 0.2 && (high - 90.0).abs() < 0.2,
            "{low} {high}"
        );
        assert_eq!(band(&[2.0; 50], 1e-3), None);
    }
}
