//! A hidden stage that can be run.

use std::f64::consts::TAU;

use super::Tier;
use super::core::{Element, RateTerm};
use super::effect::Effect;
use super::law::Law;
use super::parts;
use super::setup::{Baseline, Setup};

/// Fine steps a sample of tiers 2 and 3, and least of tier 4.
const FINER: usize = 8;
/// Runge-Kutta steps a period of a mode.
const STEPS_A_PERIOD: f64 = 20.0;
/// Most fine steps a sample.
const MOST_STEPS: f64 = 500.0;
/// Parts that a slow move between two records is made in.
const PARTS: usize = 16;
/// How far the contact of a compliant gap yields at the highest rate, as a share of its width. Much more
/// would be a lag in its own right.
const CONTACT: f64 = 0.1;

/// A stage with its effects.
#[derive(Clone, Debug, PartialEq)]
pub struct HiddenPlant {
    /// How it is computed.
    pub tier: Tier,
    /// Ranges, gain and offset.
    pub setup: Setup,
    /// Its hysteresis.
    pub baseline: Baseline,
    /// Its effects, each once.
    pub laws: Vec<Law>,
}

impl HiddenPlant {
    /// Displacement in um without noise for a drive in V, from rest at its first sample, which the
    /// stage was brought to slowly from the virgin state; the first sample is at time 0.
    pub fn run(&self, drive_v: &[f64], sample_time_s: f64) -> Vec<f64> {
        let mut displacement = self.virgin().answer(drive_v, sample_time_s, 0.0);
        self.quantise(&mut displacement);
        displacement
    }

    /// The stage before its first record.
    pub(super) fn virgin(&self) -> Stage<'_> {
        Stage {
            plant: self,
            element: self.baseline.core.virgin(self.kappa()),
            gap: 0.0,
            left_v: vec![0.0],
        }
    }

    /// The same stage seen by a sensor without lag and steps.
    pub fn without_sensor(&self) -> Self {
        let mut plant = self.clone();
        plant
            .laws
            .retain(|law| !matches!(law.effect(), Effect::SensorLag | Effect::Quantisation));
        plant
    }

    /// The same stage without its effects.
    pub fn without_effects(&self) -> Self {
        Self {
            laws: Vec::new(),
            ..self.clone()
        }
    }

    fn law<T>(&self, effect: Effect, found: impl Fn(&Law) -> Option<T>) -> Option<T> {
        let law = self.laws.iter().find(|law| law.effect() == effect)?;
        found(law)
    }

    /// Rounds to the sensor's step, where it has one.
    pub(super) fn quantise(&self, displacement_um: &mut [f64]) {
        for law in &self.laws {
            if let Law::Quantisation { step } = *law
                && step > 0.0
            {
                displacement_um
                    .iter_mut()
                    .for_each(|y| *y = (*y / step).round() * step);
            }
        }
    }

    fn steps(&self, sample_time_s: f64) -> usize {
        match self.tier {
            Tier::Same => 1,
            Tier::Finer | Tier::Irregular => FINER,
            Tier::Other => {
                let mode = self.law(Effect::Resonance, |law| match *law {
                    Law::Resonance { f_n_hz, .. } => Some(f_n_hz),
                    _ => None,
                });
                let needed = STEPS_A_PERIOD * mode.unwrap_or_default() * sample_time_s;
                (needed.min(MOST_STEPS).ceil() as usize).max(FINER)
            }
        }
    }

    /// Saturation, slew limit, lag and delay.
    fn at_the_actuator(&self, mut drive: Vec<f64>, step_s: f64) -> Vec<f64> {
        for law in &self.laws {
            match *law {
                Law::Saturation { limit_v } => drive
                    .iter_mut()
                    .for_each(|u| *u = u.clamp(-limit_v, limit_v)),
                Law::SlewLimit { slew_v_per_s } => {
                    parts::limit_steps(&mut drive, slew_v_per_s * step_s);
                }
                Law::AmplifierLag { tau_s } => parts::lag(&mut drive, tau_s, step_s),
                Law::TransportDelay { delay_s } => drive = parts::delay(&drive, delay_s / step_s),
                _ => {}
            }
        }
        drive
    }

    fn rate_term(&self) -> RateTerm {
        let mut term = RateTerm {
            beta_s: self.baseline.beta_s,
            exponent: 1.0,
            reference: 1.0,
        };
        for law in &self.laws {
            match *law {
                Law::RateDependence { beta_s } => term.beta_s = beta_s,
                Law::RateLaw {
                    exponent,
                    rate_v_per_s,
                } => (term.exponent, term.reference) = (exponent, rate_v_per_s),
                _ => {}
            }
        }
        term
    }

    fn kappa(&self) -> f64 {
        let kappa = self.law(Effect::Congruency, |law| match *law {
            Law::Congruency { kappa } => Some(kappa),
            _ => None,
        });
        kappa.unwrap_or_default()
    }

    /// The curves without memory.
    fn bend(&self, signal: &mut [f64]) {
        for law in &self.laws {
            match law {
                Law::Asymmetry { thresholds, slopes } => {
                    // Tier 4 bends in a curve instead of a corner.
                    let knee = if self.tier == Tier::Other {
                        0.1 * self.setup.half_v()
                    } else {
                        0.0
                    };
                    for w in signal.iter_mut() {
                        let beyond = |rho: f64| 0.5 * ((*w - rho) + (*w - rho).hypot(knee));
                        let sum: f64 = thresholds
                            .iter()
                            .zip(slopes)
                            .map(|(&rho, slope)| slope * beyond(rho))
                            .sum();
                        *w += sum;
                    }
                }
                Law::Quadratic { q } => signal.iter_mut().for_each(|w| *w += q * *w * *w),
                Law::Cubic { c } => signal.iter_mut().for_each(|w| *w += c * w.powi(3)),
                _ => {}
            }
        }
    }

    /// Mode, creep, interleaving and the sensor's lag.
    fn behind_the_gain(&self, signal: &mut [f64], command: &[f64], steps: usize, step_s: f64) {
        let other = self.tier == Tier::Other;
        for law in &self.laws {
            match *law {
                Law::Resonance { f_n_hz, zeta } if other => {
                    parts::mode_by_runge_kutta(signal, f_n_hz, zeta, step_s);
                }
                Law::Resonance { f_n_hz, zeta } => parts::mode(signal, f_n_hz, zeta, step_s),
                Law::Creep {
                    gain_per_decade,
                    tau_min_s,
                    ..
                } if other => {
                    parts::logarithmic_creep(signal, gain_per_decade, tau_min_s, step_s);
                }
                Law::Creep {
                    gain_per_decade,
                    tau_min_s,
                    tau_max_s,
                } => parts::creep(signal, gain_per_decade, tau_min_s, tau_max_s, step_s),
                Law::Interleaving { g } => parts::interleave(signal, command, g, steps),
                Law::SensorLag { tau_s } => parts::lag(signal, tau_s, step_s),
                _ => {}
            }
        }
    }
}

/// A stage in a session: what it remembers from one record to the next. Between records it comes to
/// rest, and everything but the hysteresis and the gap forgets.
pub(super) struct Stage<'a> {
    plant: &'a HiddenPlant,
    element: Element<'a>,
    /// Where the middle of the gap is, V.
    gap: f64,
    /// What reached the actuator at the end of the last record, and where that came to rest, V.
    left_v: Vec<f64>,
}

impl Stage<'_> {
    /// Displacement before noise and rounding, um: a slow move to the first sample of the drive, V, and
    /// then the record.
    pub(super) fn answer(&mut self, drive_v: &[f64], sample_time_s: f64, start_s: f64) -> Vec<f64> {
        let plant = self.plant;
        let steps = plant.steps(sample_time_s);
        let step_s = sample_time_s / steps as f64;
        let command = parts::refine(drive_v, steps);
        let drive = plant.at_the_actuator(command.clone(), step_s);
        let (Some(&first), Some(&last)) = (drive.first(), drive.last()) else {
            return Vec::new();
        };

        self.left_v.push(first);
        let mut before = self
            .element
            .moved_slowly(&parts::refine(&self.left_v, PARTS));
        let mut signal = self.element.driven(&drive, step_s, &plant.rate_term());
        // What lagged behind the command reaches its end.
        self.left_v = vec![last];
        let end = drive_v.last().copied().into_iter().collect();
        self.left_v.extend(plant.at_the_actuator(end, step_s));

        plant.bend(&mut before);
        plant.bend(&mut signal);
        for law in &plant.laws {
            if let Law::Backlash { width } = *law {
                let half = 0.5 * width;
                self.gap = parts::backlash(self.gap, &mut before, half);
                self.gap = if plant.tier == Tier::Other {
                    let highest = TAU * plant.setup.top_hz * plant.setup.half_v();
                    let contact_s = CONTACT * width / highest;
                    parts::soft_backlash(self.gap, &mut signal, half, contact_s, step_s)
                } else {
                    parts::backlash(self.gap, &mut signal, half)
                };
            }
        }
        let gain = plant.setup.gain_um_per_v();
        signal.iter_mut().for_each(|w| *w *= gain);
        plant.behind_the_gain(&mut signal, &command, steps, step_s);

        let at = |k: usize| start_s + k as f64 * sample_time_s;
        let other = plant.tier == Tier::Other;
        let added = |k: usize| -> f64 {
            let laws = plant.laws.iter();
            laws.map(|law| law.added_um(at(k), other)).sum()
        };
        signal
            .iter()
            .step_by(steps)
            .enumerate()
            .map(|(k, y)| y + plant.setup.offset_um + added(k))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::hidden::{Choice, HiddenCase};

    /// What is remembered between two records is what is remembered within one.
    #[test]
    fn two_records_answer_like_one() -> Result<(), crate::error::Error> {
        for effect in [Effect::Backlash, Effect::Saturation, Effect::Quadratic] {
            let hidden = HiddenCase {
                choice: Choice::Named(vec![effect]),
                ..HiddenCase::default()
            };
            let mut plant = hidden.make()?.plant;
            // The rate of the first step of a record is not known to it.
            plant.baseline.beta_s = 0.0;
            let setup = plant.setup.clone();
            let drive: Vec<f64> = (0..4000)
                .map(|k| {
                    let t = f64::from(k) * 0.01;
                    let swing = 0.6 * t.sin() + 0.35 * (2.7 * t).sin();
                    setup.middle_v() + setup.half_v() * swing
                })
                .collect();
            let whole = plant.virgin().answer(&drive, 1e-3, 0.0);
            for end in [17, 900, 2345] {
                let mut stage = plant.virgin();
                let mut parts = stage.answer(&drive[..end], 1e-3, 0.0);
                parts.extend(stage.answer(&drive[end..], 1e-3, 0.0));
                for (a, b) in parts.iter().zip(&whole) {
                    assert!((a - b).abs() < 1e-9, "{effect:?} {end}: {a} {b}");
                }
            }
        }
        Ok(())
    }
}
