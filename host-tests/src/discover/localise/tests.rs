//! Residuals that are put in a known place.

use std::f64::consts::TAU;

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::*;

const H: f64 = 1e-3;
const COUNT: usize = 4000;
const NOISE: f64 = 0.01;

/// Two records of a sine of 10 Hz and 40 V about 50 V, with noise and what `gap` gives for time in s,
/// drive in V and its rate in V/s.
fn residuals(gap: impl Fn(f64, f64, f64) -> f64) -> Residuals {
    let mut random = Pcg64::seed_from_u64(7);
    let record = |index: usize, random: &mut Pcg64| {
        let time = (0..COUNT).map(|k| k as f64 * H);
        let drive: Vec<f64> = time
            .clone()
            .map(|t| 50.0 + 40.0 * (TAU * 10.0 * t).sin())
            .collect();
        let residual_um = time
            .zip(&drive)
            .map(|(t, &u)| {
                let noise: f64 = StandardNormal.sample(random);
                let rate = 40.0 * TAU * 10.0 * (TAU * 10.0 * t).cos();
                NOISE * noise + gap(t, u, rate)
            })
            .collect();
        RecordResiduals {
            name: format!("sine {index}"),
            role: Role::Fit,
            sample_time_s: H,
            start_s: 10.0 * index as f64,
            displacement_um: drive.iter().map(|u| 0.1 * u).collect(),
            drive_v: drive,
            residual_um,
        }
    };
    Residuals {
        records: vec![record(0, &mut random), record(1, &mut random)],
    }
}

fn found(residuals: &Residuals, modes: &[f64]) -> Vec<Place> {
    places(residuals, NOISE, modes, LengthUnit::Micrometre)
}

#[track_caller]
fn lies(places: &[Place], axis: &str, share: std::ops::RangeInclusive<f64>, says: &str) {
    let place = places.iter().find(|place| place.axis == axis).unwrap();
    assert!(share.contains(&place.share), "{}", place.share);
    assert!(place.summary.contains(says), "{}", place.summary);
    // No other axis of the samples tells as much.
    let of_samples = ["time", "amplitude", "branch"];
    for other in places.iter().filter(|p| of_samples.contains(&p.axis)) {
        assert!(other.telling <= place.telling, "{}", other.axis);
    }
}

#[test]
fn noise_alone_has_no_place() {
    assert!(found(&residuals(|_, _, _| 0.0), &[]).is_empty());
}

#[test]
fn the_last_part_of_the_records() {
    let late = |t: f64, _, _| if t >= 3.0 { sign(t) } else { 0.0 };
    let places = found(&residuals(late), &[]);
    lies(
        &places,
        "time",
        0.99..=1.0,
        "in the last 25 % of the records",
    );
}

/// A sign that changes without order from sample to sample.
fn sign(t: f64) -> f64 {
    let k = (t / H).round() as u64;
    let mixed = k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    if mixed.is_multiple_of(2) { 0.2 } else { -0.2 }
}

#[test]
fn high_drives() {
    let places = found(
        &residuals(|t, u, _| if u > 76.7 { sign(t) } else { 0.0 }),
        &[],
    );
    lies(&places, "amplitude", 0.95..=1.0, "at drives above 76.7 V");
}

#[test]
fn the_falling_branch() {
    let places = found(
        &residuals(|t, _, v| if v < 0.0 { sign(t) } else { 0.0 }),
        &[],
    );
    lies(&places, "branch", 0.95..=1.0, "while the drive falls");
}

#[test]
fn just_after_a_turning_point() {
    // On each branch the first eighth of the range.
    let near = |t, u: f64, v: f64| {
        let since = if v > 0.0 { u - 10.0 } else { 90.0 - u };
        if since < 10.0 { sign(t) } else { 0.0 }
    };
    let places = found(&residuals(near), &[]);
    let place = places.iter().find(|p| p.axis == "turning-point").unwrap();
    assert!(place.share > 0.95, "{place:#?}");
    assert!(
        place.summary.contains("below 16.7 % of the range"),
        "{}",
        place.summary
    );
    assert!(place.bins[0].band_um.0 > 5.0 * place.bins[5].band_um.1);
}

#[test]
fn an_even_line_above_the_drive() {
    let places = found(&residuals(|t, _, _| 0.1 * (TAU * 80.0 * t).sin()), &[]);
    lies(&places, "frequency", 0.98..=1.0, "on even lines");
    assert_eq!(places[0].axis, "frequency");
    // The bin around 80 Hz holds the sine's rms.
    let fullest = places[0]
        .bins
        .iter()
        .max_by(|a, b| a.rms_um.total_cmp(&b.rms_um));
    let fullest = fullest.unwrap();
    assert!(
        (fullest.rms_um - 0.1 / 2f64.sqrt()).abs() < 1e-3,
        "{}",
        fullest.rms_um
    );
    assert!((fullest.at / 80.0).ln().abs() < 0.4, "{}", fullest.at);
}

#[test]
fn an_odd_multiple_that_meets_a_mode() {
    let odd = residuals(|t, _, _| 0.1 * (TAU * 70.0 * t).sin());
    let places = found(&odd, &[72.0]);
    lies(&places, "frequency", 0.98..=1.0, "on odd lines");
    let says = "7th multiple of the drive's 10 Hz meets the mode at 72 Hz";
    assert!(places[0].summary.contains(says), "{}", places[0].summary);
    let elsewhere = found(&odd, &[85.0]);
    assert!(!elsewhere[0].summary.contains("meets"));
}

#[test]
fn what_goes_with_the_rate() {
    let places = found(&residuals(|_, _, v| 1e-4 * v), &[]);
    let place = places.iter().find(|p| p.axis == "correlation").unwrap();
    assert!(
        place.summary.starts_with("Its rate (correlation 1.00)"),
        "{}",
        place.summary
    );
    assert!(place.share > 0.98);
}

#[test]
fn one_record_and_report_records_are_not_looked_at() {
    let mut one = residuals(|_, _, _| 0.0);
    for e in &mut one.records[1].residual_um {
        *e += 0.1;
    }
    let places = found(&one, &[]);
    let place = places.iter().find(|p| p.axis == "record").unwrap();
    assert!(place.share > 0.98, "{place:#?}");
    assert!(
        place.summary.contains("in 1 of 2 records"),
        "{}",
        place.summary
    );
    assert!(
        place.summary.contains("to 0.1 um in 10 s"),
        "{}",
        place.summary
    );
    one.records[1].role = Role::Report;
    assert!(found(&one, &[]).is_empty());
}
