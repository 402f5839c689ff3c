//! The stage behind a hidden case: ranges, units, rates and hysteresis, drawn by the seed.

use crate::dataset::Zero;
use crate::plant::bimorph::RelayDensity;
use crate::units::{LengthUnit, TimeUnit, VoltageUnit};

use super::Tier;
use super::core::{Core, Family};
use super::draw::{Draw, Stream};

/// How a case's data are written and measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// Least drive, V.
    pub drive_min_v: f64,
    /// Largest drive, V.
    pub drive_max_v: f64,
    /// Displacement over the whole range of the drive, um.
    pub stroke_um: f64,
    /// Displacement at a drive of 0 V from the virgin state, um.
    pub offset_um: f64,
    /// Highest sample rate, Hz.
    pub sample_rate_hz: f64,
    /// Highest frequency of the drives, Hz.
    pub top_hz: f64,
    /// Frequency of the slow loops, Hz.
    pub slow_hz: f64,
    /// Unit of the time column.
    pub time_unit: TimeUnit,
    /// Unit of the drive column.
    pub input_unit: VoltageUnit,
    /// Unit of the displacement column.
    pub output_unit: LengthUnit,
    /// Column name of the drive without its unit.
    pub input_name: &'static str,
    /// Column name of the displacement without its unit.
    pub output_name: &'static str,
    /// Whether the displacement's offset is arbitrary in each record.
    pub zero: Zero,
}

impl Setup {
    /// The setup of a seed.
    pub(super) fn draw(seed: u64) -> Self {
        let mut draw = Draw::new(seed, Stream::Stage, 0);
        let (drive_min_v, drive_max_v) =
            draw.pick([(0.0, 10.0), (0.0, 100.0), (-5.0, 5.0), (-20.0, 120.0)]);
        let stroke_um = draw.log_uniform(5.0, 200.0);
        let sample_rate_hz = draw.pick([2e3, 4e3, 5e3, 8e3, 1e4, 2e4]);
        let top_hz = draw.log_uniform(60.0, 300.0).min(sample_rate_hz / 40.0);
        Self {
            drive_min_v,
            drive_max_v,
            stroke_um,
            offset_um: stroke_um * draw.uniform(-0.3, 0.3),
            sample_rate_hz,
            top_hz,
            slow_hz: (top_hz / 150.0).clamp(0.4, 2.0),
            time_unit: draw.pick([TimeUnit::Second, TimeUnit::Second, TimeUnit::Millisecond]),
            input_unit: draw.pick([VoltageUnit::Volt, VoltageUnit::Volt, VoltageUnit::Millivolt]),
            output_unit: draw.pick([
                LengthUnit::Micrometre,
                LengthUnit::Micrometre,
                LengthUnit::Nanometre,
                LengthUnit::Millimetre,
            ]),
            input_name: draw.pick(["drive", "input", "voltage", "u"]),
            output_name: draw.pick(["displacement", "output", "position", "y"]),
            zero: if draw.chance(0.3) {
                Zero::PerRecord
            } else {
                Zero::Shared
            },
        }
    }

    /// Half the range of the drive, V.
    pub fn half_v(&self) -> f64 {
        0.5 * (self.drive_max_v - self.drive_min_v)
    }

    /// Middle of the range of the drive, V.
    pub fn middle_v(&self) -> f64 {
        0.5 * (self.drive_max_v + self.drive_min_v)
    }

    /// Displacement for a core that has moved a volt, um/V.
    pub fn gain_um_per_v(&self) -> f64 {
        self.stroke_um / (2.0 * self.half_v())
    }
}

/// The hysteresis that a baseline is meant to explain.
#[derive(Clone, Debug, PartialEq)]
pub struct Baseline {
    /// Direct part and hysteresis.
    pub core: Core,
    /// Largest width of the slow loop over the whole range, percent of the stroke.
    pub hysteresis_percent: f64,
    /// beta of the rate term, s; 0 for none.
    pub beta_s: f64,
}

/// Which rate term a baseline has.
#[derive(Clone, Copy, Debug)]
pub(super) enum RateTerms {
    None,
    Mild,
    Strong,
    /// None or a mild one.
    Drawn,
}

impl Baseline {
    /// The hysteresis of a seed and tier.
    pub(super) fn draw(seed: u64, tier: Tier, setup: &Setup, rate_term: RateTerms) -> Self {
        let mut draw = Draw::new(seed, Stream::Stage, 1);
        let wanted_percent = draw.uniform(10.0, 25.0);
        let with_rate = draw.chance(0.7);
        let mild_s = draw.log_uniform(0.002, 0.012) / setup.top_hz;
        let half_v = setup.half_v();
        let family = match tier {
            Tier::Same | Tier::Finer => few_plays(&mut draw, half_v),
            Tier::Irregular => irregular_plays(&mut draw, half_v),
            Tier::Other if draw.chance(0.5) => Family::Relays(RelayDensity {
                density_um_per_v2: 1.0 / half_v,
                widening_per_v: draw.uniform(-0.4, 1.0) / half_v,
                tilt_per_v: 0.0,
                reach_v: draw.uniform(6.0, 10.0) * half_v,
            }),
            Tier::Other => {
                // So wide that the output turns with the drive, at any width of the loop.
                let grow_per_v = draw.uniform(1.0, 2.0) / half_v;
                Family::BoucWen {
                    grow_per_v,
                    shape_per_v: draw.uniform(-0.3, 0.3) * grow_per_v,
                    // z runs ahead of the drive and a piezo's displacement behind it.
                    weight: -1.0,
                }
            }
        };
        let (core, hysteresis_percent) =
            Core::calibrated(family, setup.middle_v(), half_v, wanted_percent);
        Self {
            core,
            hysteresis_percent,
            beta_s: match rate_term {
                RateTerms::None => 0.0,
                RateTerms::Drawn if !with_rate => 0.0,
                RateTerms::Drawn | RateTerms::Mild => mild_s,
                // Of a mild term's law not even the exponent could be told.
                RateTerms::Strong => 5.0 * mild_s,
            },
        }
    }
}

/// Two to five plays with thresholds about evenly spaced in the logarithm.
fn few_plays(draw: &mut Draw, half_v: f64) -> Family {
    let count = draw.whole(2, 5);
    let (least, most) = (draw.log_uniform(0.03, 0.08), draw.uniform(0.4, 0.7));
    let step = (most / least).ln() / (count - 1) as f64;
    Family::Plays {
        thresholds_v: (0..count)
            .map(|i| half_v * least * (step * (i as f64 + draw.uniform(-0.2, 0.2))).exp())
            .collect(),
        weights: (0..count).map(|_| draw.uniform(0.3, 1.0)).collect(),
    }
}

/// Twelve plays anywhere, some of them much heavier than others.
fn irregular_plays(draw: &mut Draw, half_v: f64) -> Family {
    let mut thresholds_v: Vec<f64> = (0..12)
        .map(|_| half_v * draw.log_uniform(0.01, 0.8))
        .collect();
    thresholds_v.sort_by(f64::total_cmp);
    Family::Plays {
        thresholds_v,
        weights: (0..12).map(|_| draw.log_uniform(0.05, 1.0)).collect(),
    }
}
