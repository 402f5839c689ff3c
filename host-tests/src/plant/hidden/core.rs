//! The hysteresis of a hidden stage, in one of three families.

use std::f64::consts::TAU;

use crate::metrics::hysteresis_percent;
use crate::plant::amplifier::Amplifier;
use crate::plant::bimorph::{RelayDensity, Relays};

/// What makes the loop.
#[derive(Clone, Debug, PartialEq)]
pub enum Family {
    /// Plays with these thresholds.
    Plays {
        /// r_i, V.
        thresholds_v: Vec<f64>,
        /// a_i.
        weights: Vec<f64>,
    },
    /// Preisach's plane of relays around the middle of the range.
    Relays(RelayDensity),
    /// `z' = u' - grow |u'| z - shape u' |z|`, added with a weight.
    BoucWen {
        /// 1/V.
        grow_per_v: f64,
        /// 1/V.
        shape_per_v: f64,
        /// Share of z in the output; negative for a loop that lags behind the drive.
        weight: f64,
    },
}

/// How the loop depends on the rate of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RateTerm {
    /// beta, s; 0 for none.
    pub(super) beta_s: f64,
    /// p.
    pub(super) exponent: f64,
    /// The rate at which all exponents agree, V/s.
    pub(super) reference: f64,
}

impl RateTerm {
    /// `beta R (|u'| / R)^p`, V.
    fn widening(&self, rate: f64) -> f64 {
        if self.exponent == 1.0 || self.beta_s == 0.0 {
            self.beta_s * rate.abs()
        } else {
            self.beta_s * self.reference * (rate.abs() / self.reference).powf(self.exponent)
        }
    }
}

/// The core of a stage: what a drive of unit gain becomes, in volts.
#[derive(Clone, Debug, PartialEq)]
pub struct Core {
    /// a_0.
    pub direct: f64,
    /// The hysteresis added to it.
    pub family: Family,
    /// Middle of the drive's range, V.
    pub middle_v: f64,
}

impl Core {
    /// The core with its hysteresis scaled to `percent` of the output's range over `middle +- half`
    /// and then as a whole, so that the output spans as much as the drive; and the percentage
    /// reached, which is less where the drive itself would be left with a quarter of the output.
    pub(super) fn calibrated(
        family: Family,
        middle_v: f64,
        half_v: f64,
        percent: f64,
    ) -> (Self, f64) {
        const CYCLE: usize = 400;
        let drive: Vec<f64> = (0..=2 * CYCLE)
            .map(|k| middle_v + half_v * (TAU * k as f64 / CYCLE as f64).sin())
            .collect();
        let unit = Self {
            direct: 0.0,
            family,
            middle_v,
        };
        let hysteresis = unit.quasi_static(&drive, 0.0);
        let input = &drive[CYCLE..2 * CYCLE];
        let output = |scale: f64| -> Vec<f64> {
            let pairs = input.iter().zip(&hysteresis[CYCLE..]);
            pairs.map(|(u, added)| u + scale * added).collect()
        };
        let reached =
            |scale: f64| hysteresis_percent(input, &output(scale)).unwrap_or(f64::INFINITY);
        let most = 3.0 * 2.0 * half_v / span(&hysteresis[CYCLE..]).max(f64::MIN_POSITIVE);
        let (mut low, mut high) = (0.0, most);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if reached(middle) < percent {
                low = middle;
            } else {
                high = middle;
            }
        }
        let norm = 2.0 * half_v / span(&output(high));
        let mut core = unit;
        core.direct = norm;
        core.scale(high * norm);
        (core, reached(high))
    }

    fn scale(&mut self, factor: f64) {
        match &mut self.family {
            Family::Plays { weights, .. } => weights.iter_mut().for_each(|a| *a *= factor),
            Family::Relays(density) => density.density_um_per_v2 *= factor,
            Family::BoucWen { weight, .. } => *weight *= factor,
        }
    }

    /// The output along a drive without any rate, from the virgin state.
    fn quasi_static(&self, drive_v: &[f64], kappa: f64) -> Vec<f64> {
        self.virgin(kappa).moved_slowly(drive_v)
    }

    /// The hysteresis before anything moved it.
    pub(super) fn virgin(&self, kappa: f64) -> Element<'_> {
        Element::new(self, kappa)
    }
}

/// Largest less least sample.
fn span(signal: &[f64]) -> f64 {
    let ends = signal
        .iter()
        .fold((f64::MAX, f64::MIN), |(least, most), &x| {
            (x.min(least), x.max(most))
        });
    ends.1 - ends.0
}

/// The running hysteresis.
pub(super) struct Element<'a> {
    core: &'a Core,
    kappa: f64,
    plays: Vec<f64>,
    relays: Option<Relays>,
    /// What the relays make of no drive.
    zero: f64,
    /// State of Bouc and Wen and the drive it belongs to.
    wen: (f64, f64),
}

impl<'a> Element<'a> {
    fn new(core: &'a Core, kappa: f64) -> Self {
        let (mut plays, mut relays, mut zero) = (Vec::new(), None, 0.0);
        match &core.family {
            Family::Plays { thresholds_v, .. } => plays = vec![0.0; thresholds_v.len()],
            Family::Relays(density) => {
                // Without drive nothing comes out, as of the other families.
                let mut plane = Relays::new(*density);
                zero = plane.advance(-core.middle_v);
                relays = Some(plane);
            }
            Family::BoucWen { .. } => {}
        }
        Self {
            core,
            kappa,
            plays,
            relays,
            zero,
            wen: (0.0, 0.0),
        }
    }

    /// The outputs along a path that is moved through too slowly for a rate.
    pub(super) fn moved_slowly(&mut self, path_v: &[f64]) -> Vec<f64> {
        path_v.iter().map(|&u| self.advance(u, u, 0.0)).collect()
    }

    /// The outputs along a drive whose samples are `step_s` apart, from rest at its first.
    pub(super) fn driven(&mut self, drive_v: &[f64], step_s: f64, rate: &RateTerm) -> Vec<f64> {
        let first = drive_v.first().copied().unwrap_or_default();
        let mut last = first;
        let mut dashpot = Dashpot::new(rate, step_s, first);
        let plays = matches!(self.core.family, Family::Plays { .. });
        drive_v
            .iter()
            .map(|&u| {
                let widening = rate.widening((u - last) / step_s);
                // Only plays have envelopes; the other families are pulled along by a dashpot.
                let felt = if plays { u } else { dashpot.advance(last, u) };
                last = u;
                self.advance(u, felt, widening)
            })
            .collect()
    }

    /// `drive_v` for the direct part, `felt_v` and the widening for the hysteresis.
    fn advance(&mut self, drive_v: f64, felt_v: f64, widening: f64) -> f64 {
        let direct = self.core.direct * drive_v;
        let hysteresis = match &self.core.family {
            Family::Plays {
                thresholds_v,
                weights,
            } => {
                let mut sum = 0.0;
                for ((z, r), a) in self.plays.iter_mut().zip(thresholds_v).zip(weights) {
                    let reach = r + widening;
                    *z = z.min(felt_v + reach).max(felt_v - reach);
                    sum += a * *z;
                }
                sum
            }
            Family::Relays(_) => {
                let centred = felt_v - self.core.middle_v;
                let relays = self.relays.as_mut();
                relays.map_or(0.0, |relays| relays.advance(centred)) - self.zero
            }
            &Family::BoucWen {
                grow_per_v,
                shape_per_v,
                weight,
            } => {
                let (mut z, from) = self.wen;
                let way = felt_v - from;
                // Exact while z keeps its sign; the steps are short so that it matters nowhere else.
                let steps = (way.abs() * (grow_per_v + shape_per_v.abs()) * 10.0).ceil();
                let part = way / steps.max(1.0);
                for _ in 0..steps as usize {
                    let rate = grow_per_v.copysign(part) + shape_per_v * z.signum();
                    let decay = (-rate * part).exp();
                    let driven = if rate == 0.0 {
                        part
                    } else {
                        (1.0 - decay) / rate
                    };
                    z = z * decay + driven;
                }
                self.wen = (z, felt_v);
                weight * z
            }
        };
        (direct + hysteresis) / (1.0 - self.kappa * hysteresis)
    }
}

/// What drags families without envelopes behind a fast drive: `|u - x| = beta R (|x'| / R)^p`.
struct Dashpot<'a> {
    rate: &'a RateTerm,
    step_s: f64,
    linear: Amplifier,
    at_v: f64,
}

impl<'a> Dashpot<'a> {
    fn new(rate: &'a RateTerm, step_s: f64, rest_v: f64) -> Self {
        Self {
            rate,
            step_s,
            linear: Amplifier::new(rate.beta_s, step_s, rest_v),
            at_v: rest_v,
        }
    }

    fn advance(&mut self, from_v: f64, to_v: f64) -> f64 {
        let RateTerm {
            beta_s,
            exponent,
            reference,
        } = *self.rate;
        if exponent == 1.0 || beta_s == 0.0 {
            return self.linear.advance(from_v, to_v);
        }
        let behind = to_v - self.at_v;
        let speed = reference * (behind.abs() / (beta_s * reference)).powf(1.0 / exponent);
        self.at_v += (speed * self.step_s).min(behind.abs()).copysign(behind);
        self.at_v
    }
}
