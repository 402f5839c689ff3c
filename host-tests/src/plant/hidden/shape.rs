//! An effect with everything drawn but its size.

use super::draw::{Draw, Stream};
use super::effect::Effect;
use super::law::Law;
use super::protocol::Plan;
use super::setup::Setup;

/// What the bounds of an effect's parameters follow from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    /// Largest |drive| of all records, V.
    largest_v: f64,
    /// Largest rate of all drives, V/s.
    fastest_v_per_s: f64,
    /// End of the session, s.
    end_s: f64,
}

impl Extent {
    pub(super) fn of(plans: &[Plan]) -> Self {
        let drives = || plans.iter().flat_map(|plan| &plan.drive_v);
        let fastest = |plan: &Plan| {
            let ways = plan
                .drive_v
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).abs());
            ways.fold(0.0, f64::max) / plan.sample_time_s
        };
        let end = |plan: &Plan| plan.start_s + plan.drive_v.len() as f64 * plan.sample_time_s;
        Self {
            largest_v: drives().fold(0.0, |most, u| u.abs().max(most)),
            fastest_v_per_s: plans.iter().map(fastest).fold(0.0, f64::max),
            end_s: plans.iter().map(end).fold(0.0, f64::max),
        }
    }
}

/// An effect with its random choices made; [`Shape::law`] gives it a size.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    effect: Effect,
    sign: f64,
    /// Numbers from 0 to 1 for whatever is left to choose.
    dice: [f64; 6],
    setup: Setup,
    extent: Extent,
}

impl Shape {
    pub(super) fn draw(effect: Effect, seed: u64, setup: &Setup, extent: Extent) -> Self {
        let mut draw = Draw::new(seed, Stream::Effect, effect as u64);
        Self {
            effect,
            sign: draw.sign(),
            dice: std::array::from_fn(|_| draw.uniform(0.0, 1.0)),
            setup: setup.clone(),
            extent,
        }
    }

    /// The law at a size from 0, where it does nothing, to 1, its physical bound.
    pub(super) fn law(&self, size: f64) -> Law {
        let Extent {
            largest_v,
            fastest_v_per_s,
            end_s,
        } = self.extent;
        let Setup {
            stroke_um,
            top_hz,
            sample_rate_hz,
            ..
        } = self.setup;
        let between = |index: usize, low: f64, high: f64| low + (high - low) * self.dice[index];
        let log_between =
            |index: usize, low: f64, high: f64| low * (high / low).powf(self.dice[index]);
        let angle = |index: usize| between(index, 0.0, std::f64::consts::TAU);
        let signed = self.sign * size;
        match self.effect {
            Effect::Saturation => Law::Saturation {
                limit_v: largest_v * (1.0 - 0.5 * size),
            },
            Effect::SlewLimit => Law::SlewLimit {
                slew_v_per_s: fastest_v_per_s * 0.01_f64.powf(size),
            },
            Effect::AmplifierLag => Law::AmplifierLag {
                tau_s: 0.25 / top_hz * size,
            },
            Effect::TransportDelay => Law::TransportDelay {
                delay_s: 0.15 / top_hz * size,
            },
            Effect::RateDependence => Law::RateDependence {
                beta_s: 0.15 / top_hz * size,
            },
            Effect::RateLaw => Law::RateLaw {
                exponent: 1.0 + 0.6 * signed,
                rate_v_per_s: std::f64::consts::TAU * top_hz * 0.5 * self.setup.half_v(),
            },
            Effect::Congruency => Law::Congruency {
                kappa: 0.8 / largest_v * signed,
            },
            Effect::Asymmetry => {
                // Where the drive is on both sides of zero, the bend is on the positive one.
                let low = self.setup.drive_min_v.max(0.0);
                let place = |share: f64| low + share * (self.setup.drive_max_v - low);
                let most = if self.sign > 0.0 { 1.0 } else { -0.8 };
                let first = between(2, 0.4, 0.8);
                Law::Asymmetry {
                    thresholds: vec![place(between(0, 0.15, 0.4)), place(between(1, 0.5, 0.75))],
                    slopes: vec![most * size * first, most * size * (1.0 - first)],
                }
            }
            Effect::Quadratic => Law::Quadratic {
                q: 0.4 / largest_v * signed,
            },
            Effect::Cubic => Law::Cubic {
                c: 0.27 / (largest_v * largest_v) * signed,
            },
            Effect::Backlash => Law::Backlash {
                width: 0.4 * self.setup.half_v() * size,
            },
            Effect::Resonance => {
                // Down from beyond all drives to within their band.
                let high = (0.35 * sample_rate_hz).min(6.0 * top_hz);
                let low = 0.7 * top_hz;
                Law::Resonance {
                    f_n_hz: high * (low / high).powf(size),
                    zeta: log_between(0, 0.01, 0.06),
                }
            }
            Effect::Creep => {
                let tau_min_s = log_between(0, 0.01, 0.1);
                Law::Creep {
                    gain_per_decade: 0.15 * size,
                    tau_min_s,
                    tau_max_s: tau_min_s * 100.0,
                }
            }
            Effect::Interleaving => Law::Interleaving {
                g: 0.3 / largest_v * signed,
            },
            Effect::SensorLag => Law::SensorLag {
                tau_s: 0.25 / top_hz * size,
            },
            Effect::Drift => Law::Drift {
                amplitude: stroke_um * signed,
                tau_s: end_s * between(0, 0.15, 0.6),
                linear: self.dice[1] < 0.25,
            },
            Effect::MainsHum => {
                let nominal = if self.dice[0] < 0.5 { 50.0 } else { 60.0 };
                let amplitude = 0.2 * stroke_um * size;
                Law::MainsHum {
                    frequency_hz: nominal + between(1, -0.05, 0.05),
                    amplitude,
                    phase_rad: angle(2),
                    third: amplitude * between(3, 0.1, 0.4),
                    third_phase_rad: angle(4),
                }
            }
            Effect::Quantisation => Law::Quantisation {
                step: 0.3 * stroke_um * size,
            },
        }
    }
}
