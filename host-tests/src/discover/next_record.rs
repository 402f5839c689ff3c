//! Which record would tell the members of an ambiguity set apart: their models are run on a menu of
//! records that stay within the range and the frequencies of the data set.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use crate::dataset::Dataset;
use crate::identify::Effect;
use crate::identify::cycles::range;
use crate::identify::spectrum::band;
use crate::model_file::ModelFile;
use crate::stage::displacement;

use super::diagnosis::{Diagnosis, FoundEffect};
use super::words::listed;

/// How many times the noise models must differ by to be told apart.
const TELLS: f64 = 1.0;
/// Samples of a record at most, about.
const SAMPLES: f64 = 4000.0;
/// Part of the half range that fast records use.
const FAST: f64 = 0.6;

/// Which record would separate the members of each ambiguity set best, by how many times the noise,
/// or that none of the menu does; `None` where nothing is ambiguous.
pub fn next_record(diagnosis: &Diagnosis, dataset: &Dataset) -> Option<String> {
    let menu = Limits::of(dataset).menu();
    let said: Vec<String> = diagnosis
        .effects
        .iter()
        .filter(|found| !found.rivals.is_empty())
        .filter_map(|found| advice(diagnosis, found, &menu))
        .collect();
    (!said.is_empty()).then(|| said.join(" "))
}

/// A record that could be taken.
struct Candidate {
    name: String,
    /// Whether it has a single frequency.
    sine: bool,
    sample_time_s: f64,
    drive_v: Vec<f64>,
}

/// How a candidate separates two models: rms of the difference in um.
struct Separation<'a> {
    record: &'a Candidate,
    um: f64,
    pair: (usize, usize),
}

fn advice(diagnosis: &Diagnosis, found: &FoundEffect, menu: &[Candidate]) -> Option<String> {
    let effects: Vec<Effect> = std::iter::once(found.effect)
        .chain(found.also_possible.iter().copied())
        .collect();
    let names: Vec<&str> = effects.iter().map(|effect| effect.name()).collect();
    let models: Vec<ModelFile> = std::iter::once(&diagnosis.model)
        .chain(&found.rivals)
        .cloned()
        .collect();
    let separations: Vec<Separation<'_>> = menu
        .par_iter()
        .filter_map(|record| least_separation(record, &models))
        .collect();
    let best = separations.iter().max_by(|a, b| a.um.total_cmp(&b.um))?;
    let noise = diagnosis.noise.0.max(f64::MIN_POSITIVE);
    let times = |um: f64| times_noise(um / noise);
    let set = listed(&names);
    let tells = best.um >= TELLS * noise;
    let mut said = if tells {
        let (a, b) = best.pair;
        let how = match names.len() {
            2 => format!("{set} would differ there by"),
            _ => format!(
                "of {set} the two that are nearest to each other there, {} and {}, would differ by",
                names[a], names[b]
            ),
        };
        format!(
            "Record {}: {how} {} ({} rms), the most of {} records simulated.",
            best.record.name,
            times(best.um),
            diagnosis.length(best.um),
            separations.len()
        )
    } else {
        format!(
            "None of {} records simulated within the range and frequencies of the data tells {set} \
             apart; the best is {}, in which they differ by {}.",
            separations.len(),
            best.record.name,
            times(best.um)
        )
    };
    let sines = separations.iter().filter(|s| s.record.sine);
    let sines = sines.map(|s| s.um).fold(0.0, f64::max);
    let lags = effects.iter().filter(|&&effect| is_lag(effect)).count();
    if tells && lags > 1 && sines < TELLS * noise {
        said += &format!(
            " Sines alone cannot: they separate them by {} at most.",
            times(sines)
        );
    }
    let before = effects.iter().any(|&e| is_lag(e) && acts_first(e));
    let behind = effects.iter().any(|&e| is_lag(e) && !acts_first(e));
    if !tells && before && behind {
        said += " One acts before the hysteresis, the other in it or behind it: record the \
                 amplifier's output voltage beside its input, which shows the first directly.";
    }
    Some(said)
}

fn times_noise(ratio: f64) -> String {
    match ratio {
        r if r < 1.0 => format!("{r:.2} times the noise"),
        r if r < 10.0 => format!("{r:.1} times the noise"),
        r => format!("{r:.0} times the noise"),
    }
}

/// Whether an effect delays or turns the phase of the displacement.
fn is_lag(effect: Effect) -> bool {
    matches!(
        effect,
        Effect::AmplifierLag
            | Effect::TransportDelay
            | Effect::RateDependence
            | Effect::RateLaw
            | Effect::SensorLag
    )
}

fn acts_first(effect: Effect) -> bool {
    matches!(effect, Effect::AmplifierLag | Effect::TransportDelay)
}

/// The pair of models that a record separates least.
fn least_separation<'a>(record: &'a Candidate, models: &[ModelFile]) -> Option<Separation<'a>> {
    let answers: Vec<Vec<f64>> = models
        .iter()
        .map(|model| displacement(model, record.sample_time_s, &record.drive_v).ok())
        .collect::<Option<_>>()?;
    let pairs = (0..answers.len()).flat_map(|a| (0..a).map(move |b| (b, a)));
    pairs
        .map(|pair| Separation {
            record,
            um: difference(&answers[pair.0], &answers[pair.1]),
            pair,
        })
        .filter(|separation| separation.um.is_finite())
        .min_by(|a, b| a.um.total_cmp(&b.um))
}

/// Rms of what no gain and offset explain of one signal by the other.
fn difference(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len().max(1) as f64;
    let mean = |v: &[f64]| v.iter().sum::<f64>() / count;
    let (ma, mb) = (mean(a), mean(b));
    let (mut aa, mut ab, mut bb) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (a, b) = (a - ma, b - mb);
        aa += a * a;
        ab += a * b;
        bb += b * b;
    }
    let explained = if bb > 0.0 { ab * ab / bb } else { 0.0 };
    ((aa - explained).max(0.0) / count).sqrt()
}

/// What the data set shows the stage can be driven with.
struct Limits {
    low_v: f64,
    high_v: f64,
    slow_hz: f64,
    fast_hz: f64,
    sample_time_s: f64,
    longest_s: f64,
}

impl Limits {
    fn of(dataset: &Dataset) -> Self {
        let mut limits = Self {
            low_v: f64::INFINITY,
            high_v: f64::NEG_INFINITY,
            slow_hz: f64::INFINITY,
            fast_hz: 0.0,
            sample_time_s: f64::INFINITY,
            longest_s: 0.0,
        };
        for record in &dataset.records {
            for &u in &record.drive_v {
                limits.low_v = limits.low_v.min(u);
                limits.high_v = limits.high_v.max(u);
            }
            let length = record.drive_v.len() as f64 * record.sample_time_s;
            limits.longest_s = limits.longest_s.max(length);
            limits.sample_time_s = limits.sample_time_s.min(record.sample_time_s);
            if range(&record.drive_v) > 0.0
                && let Some((low, high)) = band(&record.drive_v, record.sample_time_s)
            {
                limits.slow_hz = limits.slow_hz.min(low);
                limits.fast_hz = limits.fast_hz.max(high);
            }
        }
        limits
    }

    /// A record of `seconds`, its drive in parts of the half range from the middle.
    fn record(
        &self,
        (name, sine): (String, bool),
        seconds: f64,
        drive: impl Fn(f64) -> f64,
    ) -> Candidate {
        let step = self.sample_time_s.max(seconds / SAMPLES);
        let count = (seconds / step).round() as usize;
        let (middle, half) = (
            0.5 * (self.high_v + self.low_v),
            0.5 * (self.high_v - self.low_v),
        );
        Candidate {
            name,
            sine,
            sample_time_s: step,
            drive_v: (0..count)
                .map(|k| middle + half * drive(k as f64 * step))
                .collect(),
        }
    }

    fn menu(&self) -> Vec<Candidate> {
        if !(self.fast_hz > 0.0 && self.slow_hz.is_finite()) {
            return Vec::new();
        }
        let (fast, slow) = (self.fast_hz, self.slow_hz);
        let half = 0.5 * (self.high_v - self.low_v);
        let volts = |part: f64| crate::report::format_number((part * half * 100.0).round() / 100.0);
        let hertz = |hz: f64| super::localise::short(hz);
        let mut menu = Vec::new();
        for top in [0.25 * fast, 0.5 * fast, fast] {
            let name = format!(
                "a multisine to {} Hz of {} V to either side",
                hertz(top),
                volts(FAST)
            );
            menu.push(self.record((name, false), 2.0 * LINES / top, move |t| {
                FAST * multisine(t, top)
            }));
        }
        for hz in [0.01 * fast, 0.03 * fast, 0.1 * fast, 0.3 * fast, fast] {
            let name = format!("a sine of {} Hz and {} V", hertz(hz), volts(FAST));
            menu.push(self.record((name, true), 4.0 / hz, move |t| FAST * (TAU * hz * t).sin()));
        }
        for (amplitude, bias) in [(1.0, 0.0), (0.3, 0.0), (0.3, 0.6), (0.3, -0.6)] {
            let place = match bias {
                b if b > 0.0 => " near the upper end of the range",
                b if b < 0.0 => " near the lower end of the range",
                _ => "",
            };
            let name = format!(
                "slow triangular loops of {} V{place} at {} Hz",
                volts(amplitude),
                hertz(slow)
            );
            menu.push(self.record((name, false), 3.0 / slow, move |t| {
                bias + amplitude * (slow * t * TAU).sin().asin() * 2.0 / PI
            }));
        }
        let longest = self.longest_s;
        let name = format!(
            "a staircase over the range, up and down, with holds of {} s",
            hertz(longest / 9.0)
        );
        menu.push(self.record((name, false), longest, move |t| {
            let step = (9.0 * t / longest).floor().min(8.0);
            1.0 - (step - 4.0).abs() / 2.0
        }));
        let name = format!("a sine over the whole range at {} Hz", hertz(0.25 * fast));
        menu.push(self.record((name, true), 16.0 / fast, move |t| {
            (0.25 * fast * TAU * t).sin()
        }));
        let ladder = 0.03 * fast;
        let name = format!(
            "a sine of {} Hz whose amplitude falls to zero",
            hertz(ladder)
        );
        menu.push(self.record((name, false), 10.0 / ladder, move |t| {
            (1.0 - 0.1 * t * ladder) * (TAU * ladder * t).sin()
        }));
        let name = format!("a rest of {} s", hertz(longest));
        menu.push(self.record((name, false), longest, |_| 0.0));
        menu
    }
}

/// Lines below the top one, their number twice that: only odd ones are driven.
const LINES: f64 = 31.0;

/// Odd lines up to `top` Hz with Schroeder's phases, at most about one.
fn multisine(t: f64, top: f64) -> f64 {
    let count = (LINES as usize).div_ceil(2);
    let sum: f64 = (0..count)
        .map(|i| {
            let line = (2 * i + 1) as f64;
            let phase = -PI * (i * i) as f64 / count as f64;
            (TAU * line * top / LINES * t + phase).cos()
        })
        .sum();
    // The crest of these phases is about 1.7.
    sum / (1.7 * (0.5 * count as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dataset::{LengthUnit, Record, Role, Zero};

    fn limits() -> Limits {
        let drive = |hz: f64| -> Vec<f64> {
            (0..2000)
                .map(|k| 20.0 + 30.0 * (TAU * hz * k as f64 * 1e-3).sin())
                .collect()
        };
        let record = |hz| Record {
            name: format!("{hz}"),
            role: Role::Fit,
            start_s: 0.0,
            sample_time_s: 1e-3,
            time_s: (0..2000).map(|k| k as f64 * 1e-3).collect(),
            drive_v: drive(hz),
            displacement_um: drive(hz),
            continues: None,
        };
        Limits::of(&Dataset {
            name: "two".to_owned(),
            output_unit: LengthUnit::Micrometre,
            zero: Zero::Shared,
            input_zero: Zero::Shared,
            records: vec![record(1.0), record(40.0)],
        })
    }

    #[test]
    fn the_menu_keeps_to_the_range_of_the_data() {
        let limits = limits();
        assert!((limits.fast_hz - 40.0).abs() < 1.0, "{}", limits.fast_hz);
        for record in limits.menu() {
            assert!(record.drive_v.len() >= 100, "{}", record.name);
            assert!(record.sample_time_s >= limits.sample_time_s);
            for &u in &record.drive_v {
                assert!((-10.001..=50.001).contains(&u), "{}: {u}", record.name);
            }
        }
    }

    #[test]
    fn the_difference_of_two_signals_is_what_no_gain_and_offset_explain() {
        let a: Vec<f64> = (0..1000).map(|k| (TAU * k as f64 / 100.0).sin()).collect();
        let b: Vec<f64> = a.iter().map(|v| 3.0 - 2.0 * v).collect();
        assert!(difference(&a, &b) < 1e-7);
        // A quarter of a period apart nothing is explained: the rms of a sine.
        let c: Vec<f64> = (0..1000).map(|k| (TAU * k as f64 / 100.0).cos()).collect();
        assert!((difference(&a, &c) - 0.5f64.sqrt()).abs() < 1e-9);
    }
}
