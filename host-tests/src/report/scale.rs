//! From data to drawing coordinates: ranges, ticks, labels.

use super::number::{format_number, minus, power_of_ten};
use super::plot::Axis;

/// Sizes beyond this are no quantity on any axis and would overflow the arithmetic of ranges.
const LARGEST: f64 = 1e100;

/// Narrowest linear range in relation to its values; below it tick labels would run together.
const NARROWEST: f64 = 1e-9;

/// Fewer decades than this on a logarithmic axis are labelled like a linear one.
const FEW_DECADES: f64 = 0.7;

/// Whether `value` has a place on an axis.
pub(super) fn drawable(value: f64, log: bool) -> bool {
    value.abs() <= LARGEST && (!log || value >= 1.0 / LARGEST)
}

/// A position along an axis; without a label it is a minor grid line.
#[derive(Debug, PartialEq)]
pub(super) struct Tick {
    pub value: f64,
    pub label: Option<String>,
}

/// The drawn range of one axis.
#[derive(Debug)]
pub(super) struct Scale {
    pub log: bool,
    pub low: f64,
    pub high: f64,
}

impl Scale {
    /// The range that holds all drawable `values`, with `margin` in parts of their span on either
    /// side, none beside an exact zero.
    pub fn around(axis: &Axis, values: impl Iterator<Item = f64>, margin: f64) -> Self {
        let log = axis.log;
        let (low, high) = values
            .chain(axis.include)
            .filter(|&value| drawable(value, log))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
                (a.min(v), b.max(v))
            });
        if low > high {
            let (low, high) = if log { (1.0, 10.0) } else { (0.0, 1.0) };
            return Self { log, low, high };
        }
        let size = low.abs().max(high.abs());
        let (low, high) = if log {
            let factor = if high / low < 1.01 {
                2.0
            } else {
                (high / low).powf(margin)
            };
            ((low / factor).max(1.0 / LARGEST), high * factor)
        } else if high - low <= NARROWEST * size || size < 1.0 / LARGEST {
            let margin = if size < 1.0 / LARGEST {
                1.0
            } else {
                0.05 * size
            };
            (low - margin, high + margin)
        } else {
            let margin = margin * (high - low);
            let beside = |end: f64, moved: f64| if end == 0.0 { 0.0 } else { moved };
            (beside(low, low - margin), beside(high, high + margin))
        };
        Self {
            log,
            low: low.max(-LARGEST),
            high: high.min(LARGEST),
        }
    }

    /// Where `value` lies between the ends, 0 to 1; NaN if it cannot be drawn.
    pub fn fraction(&self, value: f64) -> f64 {
        if !drawable(value, self.log) {
            f64::NAN
        } else if self.log {
            (value / self.low).ln() / (self.high / self.low).ln()
        } else {
            (value - self.low) / (self.high - self.low)
        }
    }

    /// The power of ten taken out of the tick labels and put into the axis title.
    pub fn exponent(&self) -> i32 {
        let size = self.low.abs().max(self.high.abs());
        if self.log || (0.02..1e5).contains(&size) {
            0
        } else {
            3 * (size.log10() / 3.0).floor() as i32
        }
    }

    /// Grid positions in rising order, with about `wanted` labels.
    pub fn ticks(&self, wanted: usize) -> Vec<Tick> {
        if self.log && (self.high / self.low).log10() >= FEW_DECADES {
            self.decades(wanted)
        } else {
            self.steps(wanted)
        }
    }

    fn steps(&self, wanted: usize) -> Vec<Tick> {
        let unit = 10_f64.powi(self.exponent());
        let (low, high) = (self.low / unit, self.high / unit);
        let step = nice_step((high - low) / wanted.max(1) as f64);
        let decimals = usize::try_from(-(step.log10() + 1e-9).floor() as i32).unwrap_or(0);
        let first = (low / step - 1e-9).ceil() as i64;
        let last = (high / step + 1e-9).floor() as i64;
        (first..=last)
            .map(|k| {
                let value = k as f64 * step;
                Tick {
                    value: value * unit,
                    label: Some(minus(format!("{value:.decimals$}"))),
                }
            })
            .collect()
    }

    fn decades(&self, wanted: usize) -> Vec<Tick> {
        let (low, high) = (self.low.log10(), self.high.log10());
        let every = ((high - low) / wanted.max(1) as f64).ceil().max(1.0) as i32;
        let few = high - low < 2.0;
        let inside = |value: f64| (-1e-9..=1.0 + 1e-9).contains(&self.fraction(value));
        let mut ticks = Vec::new();
        for decade in low.floor() as i32..=high.ceil() as i32 {
            for digit in 1..=if every == 1 { 9 } else { 1 } {
                // Parsed rather than multiplied, so that 0.3 is 0.3.
                let value = format!("{digit}e{decade}").parse().unwrap_or(f64::NAN);
                if inside(value) {
                    let labelled =
                        (digit == 1 && decade % every == 0) || (few && (digit == 2 || digit == 5));
                    ticks.push(Tick {
                        value,
                        label: labelled.then(|| log_label(value, decade)),
                    });
                }
            }
        }
        ticks
    }
}

fn log_label(value: f64, decade: i32) -> String {
    let text = format_number(value);
    match text.strip_prefix("1×") {
        Some(_) => power_of_ten(decade),
        None => text,
    }
}

/// The one of 1, 2, 5 times a power of ten that is nearest to `step` in ratio.
fn nice_step(step: f64) -> f64 {
    let decade = 10_f64.powf(step.log10().floor());
    // Beyond the geometric mean of two neighbours the upper one is nearer.
    let reach = [(1.0, 2_f64), (2.0, 10.0), (5.0, 50.0)];
    let factor = reach
        .into_iter()
        .find(|(_, square)| step / decade <= square.sqrt());
    factor.map_or(10.0, |(factor, _)| factor) * decade
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(scale: &Scale, wanted: usize) -> Vec<String> {
        scale
            .ticks(wanted)
            .into_iter()
            .filter_map(|tick| tick.label)
            .collect()
    }

    #[test]
    fn linear_labels_are_round() {
        let scale = Scale {
            log: false,
            low: -0.0132,
            high: 0.0427,
        };
        assert_eq!(
            labels(&scale, 6),
            ["−0.01", "0.00", "0.01", "0.02", "0.03", "0.04"]
        );
        let scale = Scale {
            log: false,
            low: 0.0,
            high: 100.0,
        };
        assert_eq!(labels(&scale, 5), ["0", "20", "40", "60", "80", "100"]);
    }

    #[test]
    fn very_small_values_put_their_power_into_the_title() {
        let scale = Scale {
            log: false,
            low: 0.0,
            high: 3.1e-5,
        };
        assert_eq!(scale.exponent(), -6);
        assert_eq!(labels(&scale, 3), ["0", "10", "20", "30"]);
    }

    #[test]
    fn decades_are_labelled_and_divided() {
        let scale = Scale {
            log: true,
            low: 0.05,
            high: 100.0,
        };
        assert_eq!(labels(&scale, 8), ["0.1", "1", "10", "100"]);
        // 0.05 to 0.09, three full decades of nine, and 100.
        assert_eq!(scale.ticks(8).len(), 5 + 27 + 1);
        let scale = Scale {
            log: true,
            low: 1e-12,
            high: 1e9,
        };
        assert_eq!(labels(&scale, 4), ["10⁻¹²", "10⁻⁶", "1", "10⁶"]);
        let scale = Scale {
            log: true,
            low: 1.1,
            high: 60.0,
        };
        assert_eq!(labels(&scale, 8), ["2", "5", "10", "20", "50"]);
    }

    #[test]
    fn undrawable_values_do_not_count() {
        let axis = Axis::log("Error", "µm");
        let scale = Scale::around(
            &axis,
            [f64::NAN, -1.0, 0.0, 2.0, 20.0, 1e300].into_iter(),
            0.04,
        );
        assert!(scale.low > 1.5 && scale.high < 25.0, "{scale:?}");
        assert!(scale.fraction(0.0).is_nan() && scale.fraction(f64::INFINITY).is_nan());
        let scale = Scale::around(&Axis::linear("Error", "µm"), std::iter::empty(), 0.04);
        assert_eq!((scale.low, scale.high), (0.0, 1.0));
    }

    proptest! {
        #[test]
        fn every_range_has_few_ticks_inside_it(
            values in prop::collection::vec(prop_oneof![
                -1e100..1e100_f64, -1.0..1.0_f64, 1e6..1e6 + 1e-8, Just(0.0), any::<f64>()], 0..8),
            log: bool,
        ) {
            let axis = if log { Axis::log("a", "V") } else { Axis::linear("a", "V") };
            let scale = Scale::around(&axis, values.iter().copied(), 0.04);
            prop_assert!(scale.low < scale.high);
            for &value in values.iter().filter(|&&v| drawable(v, log)) {
                prop_assert!((0.0..=1.0).contains(&scale.fraction(value)));
            }
            let ticks = scale.ticks(6);
            let labelled = ticks.iter().filter(|tick| tick.label.is_some()).count();
            prop_assert!((1..=11).contains(&labelled), "{labelled} labels in {scale:?}");
            for pair in ticks.windows(2) {
                prop_assert!(pair[0].value < pair[1].value);
                prop_assert!(pair[0].label.is_none() || pair[0].label != pair[1].label);
            }
            for tick in &ticks {
                let fraction = scale.fraction(tick.value);
                prop_assert!((-1e-6..=1.0 + 1e-6).contains(&fraction), "{tick:?} in {scale:?}");
            }
        }
    }
}
