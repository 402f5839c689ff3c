//! What an effect does, with its parameters; `docs/hidden-data.md` has the equations.

use std::f64::consts::TAU;

use super::effect::Effect;

/// An effect with parameters. Before the gain the signal is in volts, behind it in micrometres.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// The drive is limited to `+-limit_v`.
    Saturation {
        /// Limit, V.
        limit_v: f64,
    },
    /// The rate of the drive is limited.
    SlewLimit {
        /// Limit, V/s.
        slew_v_per_s: f64,
    },
    /// `tau x' + x = u` on the drive.
    AmplifierLag {
        /// Time constant, s.
        tau_s: f64,
    },
    /// `u(t - delay)`.
    TransportDelay {
        /// Delay, s.
        delay_s: f64,
    },
    /// Thresholds widen by `beta |u'|`.
    RateDependence {
        /// beta, s.
        beta_s: f64,
    },
    /// Thresholds widen by `beta R (|u'| / R)^p`.
    RateLaw {
        /// p.
        exponent: f64,
        /// R, the rate at which the law is that of p = 1, V/s.
        rate_v_per_s: f64,
    },
    /// `w = a_0 u + (1 + kappa w) sum a_i z_i`.
    Congruency {
        /// kappa, 1/V.
        kappa: f64,
    },
    /// `w + sum s_i max(w - rho_i, 0)`.
    Asymmetry {
        /// rho_i, V.
        thresholds: Vec<f64>,
        /// s_i.
        slopes: Vec<f64>,
    },
    /// `w + q w^2`.
    Quadratic {
        /// q, 1/V.
        q: f64,
    },
    /// `w + c w^3`.
    Cubic {
        /// c, 1/V^2.
        c: f64,
    },
    /// A play of this full width behind the curvature.
    Backlash {
        /// Distance between the branches in w, V.
        width: f64,
    },
    /// `y'' + 2 zeta w_n y' + w_n^2 y = w_n^2 x`.
    Resonance {
        /// Undamped natural frequency, Hz.
        f_n_hz: f64,
        /// Damping ratio.
        zeta: f64,
    },
    /// Exponentials a decade apart from `tau_min_s` to `tau_max_s`; in tier 4
    /// `gain log10(1 + t / tau_min)` after a step.
    Creep {
        /// Growth of a step response a decade of time, as a share of the step.
        gain_per_decade: f64,
        /// Shortest time constant, s.
        tau_min_s: f64,
        /// Longest time constant, s; none in tier 4.
        tau_max_s: f64,
    },
    /// `y = x + g y u` one sample ago.
    Interleaving {
        /// g, 1/V.
        g: f64,
    },
    /// `tau y' + y = x` on the displacement.
    SensorLag {
        /// Time constant, s.
        tau_s: f64,
    },
    /// `amplitude (1 - exp(-t / tau))`, or `amplitude t / tau` where linear.
    Drift {
        /// Amplitude, um.
        amplitude: f64,
        /// Time constant, s.
        tau_s: f64,
        /// Whether it goes on for ever.
        linear: bool,
    },
    /// A line of the mains and its third harmonic, in absolute time.
    MainsHum {
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Amplitude of the line, um.
        amplitude: f64,
        /// Phase of its sine at time 0.
        phase_rad: f64,
        /// Amplitude of the third harmonic, um.
        third: f64,
        /// Phase of the third harmonic at time 0.
        third_phase_rad: f64,
    },
    /// `round(y / step) step`.
    Quantisation {
        /// Step, um.
        step: f64,
    },
}

impl Law {
    /// The effect it is a law of.
    pub fn effect(&self) -> Effect {
        match self {
            Self::Saturation { .. } => Effect::Saturation,
            Self::SlewLimit { .. } => Effect::SlewLimit,
            Self::AmplifierLag { .. } => Effect::AmplifierLag,
            Self::TransportDelay { .. } => Effect::TransportDelay,
            Self::RateDependence { .. } => Effect::RateDependence,
            Self::RateLaw { .. } => Effect::RateLaw,
            Self::Congruency { .. } => Effect::Congruency,
            Self::Asymmetry { .. } => Effect::Asymmetry,
            Self::Quadratic { .. } => Effect::Quadratic,
            Self::Cubic { .. } => Effect::Cubic,
            Self::Backlash { .. } => Effect::Backlash,
            Self::Resonance { .. } => Effect::Resonance,
            Self::Creep { .. } => Effect::Creep,
            Self::Interleaving { .. } => Effect::Interleaving,
            Self::SensorLag { .. } => Effect::SensorLag,
            Self::Drift { .. } => Effect::Drift,
            Self::MainsHum { .. } => Effect::MainsHum,
            Self::Quantisation { .. } => Effect::Quantisation,
        }
    }

    /// Its parameters by key, for `truth.toml`.
    pub fn parameters(&self) -> toml::Table {
        let numbers = |pairs: &[(&str, f64)]| -> toml::Table {
            pairs
                .iter()
                .map(|&(key, value)| (key.to_owned(), value.into()))
                .collect()
        };
        match self {
            Self::Saturation { limit_v } => numbers(&[("limit_v", *limit_v)]),
            Self::SlewLimit { slew_v_per_s } => numbers(&[("slew_v_per_s", *slew_v_per_s)]),
            Self::AmplifierLag { tau_s } | Self::SensorLag { tau_s } => {
                numbers(&[("tau_s", *tau_s)])
            }
            Self::TransportDelay { delay_s } => numbers(&[("delay_s", *delay_s)]),
            Self::RateDependence { beta_s } => numbers(&[("beta_s", *beta_s)]),
            Self::RateLaw {
                exponent,
                rate_v_per_s,
            } => numbers(&[("exponent", *exponent), ("rate_v_per_s", *rate_v_per_s)]),
            Self::Congruency { kappa } => numbers(&[("kappa", *kappa)]),
            Self::Asymmetry { thresholds, slopes } => [
                ("thresholds".to_owned(), thresholds.clone().into()),
                ("slopes".to_owned(), slopes.clone().into()),
            ]
            .into_iter()
            .collect(),
            Self::Quadratic { q } => numbers(&[("q", *q)]),
            Self::Cubic { c } => numbers(&[("c", *c)]),
            Self::Backlash { width } => numbers(&[("width", *width)]),
            Self::Resonance { f_n_hz, zeta } => numbers(&[("f_n_hz", *f_n_hz), ("zeta", *zeta)]),
            Self::Creep {
                gain_per_decade,
                tau_min_s,
                tau_max_s,
            } => numbers(&[
                ("gain_per_decade", *gain_per_decade),
                ("tau_min_s", *tau_min_s),
                ("tau_max_s", *tau_max_s),
            ]),
            Self::Interleaving { g } => numbers(&[("g", *g)]),
            Self::Drift {
                amplitude,
                tau_s,
                linear,
            } => {
                let mut table = numbers(&[("amplitude", *amplitude), ("tau_s", *tau_s)]);
                table.insert("linear".to_owned(), (*linear).into());
                table
            }
            Self::MainsHum {
                frequency_hz,
                amplitude,
                phase_rad,
                third,
                third_phase_rad,
            } => numbers(&[
                ("frequency_hz", *frequency_hz),
                ("amplitude", *amplitude),
                ("phase_rad", *phase_rad),
                ("third", *third),
                ("third_phase_rad", *third_phase_rad),
            ]),
            Self::Quantisation { step } => numbers(&[("step", *step)]),
        }
    }

    /// What is added to the displacement at an absolute time, um; 0 for all but drift and hum.
    /// In tier 4 drift that settles is `amplitude t / (t + tau)`.
    pub(super) fn added_um(&self, time_s: f64, other_family: bool) -> f64 {
        match *self {
            Self::Drift {
                amplitude,
                tau_s,
                linear,
            } => {
                amplitude
                    * if linear {
                        time_s / tau_s
                    } else if other_family {
                        time_s / (time_s + tau_s)
                    } else {
                        -(-time_s / tau_s).exp_m1()
                    }
            }
            Self::MainsHum {
                frequency_hz,
                amplitude,
                phase_rad,
                third,
                third_phase_rad,
            } => {
                let angle = TAU * frequency_hz * time_s;
                amplitude * (angle + phase_rad).sin()
                    + third * (3.0 * angle + third_phase_rad).sin()
            }
            _ => 0.0,
        }
    }
}
