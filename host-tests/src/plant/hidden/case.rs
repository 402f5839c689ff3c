//! From a request to a data set, its truth and a stage that can be run again.

use std::path::Path;

use crate::dataset::{self, Columns, Dataset, Record, Zero};
use crate::error::Error;
use crate::output::OutputFolder;
use crate::units::Unit;

use super::Tier;
use super::chain::HiddenPlant;
use super::core::Family;
use super::draw::{Draw, Stream};
use super::effect::{Choice, Effect};
use super::law::Law;
use super::protocol::{Plan, Protocol, plan};
use super::session::Session;
use super::setup::{Baseline, RateTerms, Setup};
use super::shape::{Extent, Shape};
use super::truth::{EffectTruth, StageTruth, Truth};

/// Least size of an effect that is tried.
const LEAST: f64 = 1e-7;
/// How near a strength has to come to that asked for, relative.
const NEAR: f64 = 1e-3;
/// Most sizes tried.
const TRIES: usize = 40;
/// Decay from sample to sample of the coloured half of coloured noise.
const DECAY: f64 = 0.95;

/// What to hide.
#[derive(Clone, Debug, PartialEq)]
pub struct HiddenCase {
    /// The effects.
    pub choice: Choice,
    /// Seed of everything random, at most 2^63 - 1.
    pub seed: u64,
    /// How far the truth is from the models.
    pub tier: Tier,
    /// Size of each effect alone: rms over all records of what the answers without it, with a new
    /// gain and offset, leave; percent of the stroke, above 0 and at most 20.
    pub strength: f64,
    /// Rms of the sensor's noise, percent of the stroke, 0 to 10.
    pub noise_percent: f64,
    /// What is recorded.
    pub protocol: Protocol,
    /// Whether the baseline has a rate term; drawn by the seed where not said. A hidden
    /// `rate-dependence` means none, a hidden `rate-law` a strong one.
    pub rate_term: Option<bool>,
}

impl Default for HiddenCase {
    fn default() -> Self {
        Self {
            choice: Choice::Random(1),
            seed: 1,
            tier: Tier::Same,
            strength: 1.0,
            noise_percent: 0.1,
            protocol: Protocol::Full,
            rate_term: None,
        }
    }
}

/// A data set with its truth.
#[derive(Clone, Debug)]
pub struct Hidden {
    /// The data set, as it loads from the files.
    pub dataset: Dataset,
    /// What is hidden in it.
    pub truth: Truth,
    /// The stage with its effects, to be run again.
    pub plant: HiddenPlant,
}

impl HiddenCase {
    /// Draws the stage, sizes the effects, runs the session.
    ///
    /// # Errors
    /// A strength, noise or choice out of range.
    pub fn make(&self) -> Result<Hidden, Error> {
        let in_range = |name: &str, value: f64, least: f64, most: f64| {
            if (least..=most).contains(&value) {
                Ok(())
            } else {
                Err(Error::request(format!(
                    "{name} {value} is out of range; take {least} to {most} percent of the stroke"
                )))
            }
        };
        in_range("strength", self.strength, 1e-3, 20.0)?;
        in_range("noise", self.noise_percent, 0.0, 10.0)?;
        let effects = self.choice.effects(self.seed)?;

        let setup = Setup::draw(self.seed);
        let session = Session {
            plans: plan(self.protocol, &setup, self.seed),
        };
        let rate_term = if effects.contains(&Effect::RateDependence) {
            RateTerms::None
        } else if effects.contains(&Effect::RateLaw) {
            RateTerms::Strong
        } else {
            match self.rate_term {
                None => RateTerms::Drawn,
                Some(false) => RateTerms::None,
                Some(true) => RateTerms::Mild,
            }
        };
        let bare = HiddenPlant {
            tier: self.tier,
            baseline: Baseline::draw(self.seed, self.tier, &setup, rate_term),
            setup,
            laws: Vec::new(),
        };
        let without = session.answers(&bare);
        let extent = Extent::of(&session.plans);
        let (mut laws, mut details) = (Vec::new(), Vec::new());
        for effect in effects {
            let shape = Shape::draw(effect, self.seed, &bare.setup, extent);
            let (law, detail) = self.sized(&shape, &bare, &session, &without);
            laws.push(law);
            details.push(detail);
        }

        let plant = HiddenPlant { laws, ..bare };
        let clean = session.answers(&plant);
        let mut rounded = clean.clone();
        rounded.iter_mut().for_each(|record| plant.quantise(record));
        let truth = Truth {
            version: 1,
            effects: details
                .iter()
                .map(|one: &EffectTruth| one.name.clone())
                .collect(),
            seed: self.seed,
            tier: self.tier.number(),
            protocol: self.protocol.name().to_owned(),
            strength: self.strength,
            noise_percent: self.noise_percent,
            noise_um: self.noise_um(&plant.setup),
            noise_coloured: self.tier.coloured(),
            moves_um: session.moved(&rounded, &without),
            leaves_um: session.left(&rounded, &without).0,
            stage: stage_truth(&plant),
            details,
        };
        Ok(Hidden {
            dataset: self.measured(&session.plans, clean, &plant),
            truth,
            plant,
        })
    }

    /// The records of the same stage with the same noise, had only these of its laws been hidden in it.
    pub fn with_laws(&self, hidden: &Hidden, laws: Vec<Law>) -> Dataset {
        let plant = HiddenPlant {
            laws,
            ..hidden.plant.clone()
        };
        let session = Session {
            plans: plan(self.protocol, &plant.setup, self.seed),
        };
        self.measured(&session.plans, session.answers(&plant), &plant)
    }

    fn noise_um(&self, setup: &Setup) -> f64 {
        1e-2 * self.noise_percent * setup.stroke_um
    }

    /// The law of the size that has the strength asked for, or of the bound.
    fn sized(
        &self,
        shape: &Shape,
        bare: &HiddenPlant,
        session: &Session,
        without: &[Vec<f64>],
    ) -> (Law, EffectTruth) {
        let wanted_um = 1e-2 * self.strength * bare.setup.stroke_um;
        let with = |law: Law| {
            let plant = HiddenPlant {
                laws: vec![law],
                ..bare.clone()
            };
            let mut answers = session.answers(&plant);
            answers.iter_mut().for_each(|record| plant.quantise(record));
            answers
        };
        let (mut low, mut high, mut size) = (LEAST, 1.0, 1.0);
        let mut answers = with(shape.law(size));
        let (mut leaves_um, mut left) = session.left(&answers, without);
        let bounded = left < wanted_um * (1.0 - NEAR);
        if !bounded {
            for _ in 0..TRIES {
                if (left / wanted_um - 1.0).abs() <= NEAR {
                    break;
                }
                if left > wanted_um {
                    high = size;
                } else {
                    low = size;
                }
                // What an effect in proportion to its size would need, kept within the bracket.
                let guess = size * wanted_um / left.max(f64::MIN_POSITIVE);
                size = if guess > low && guess < high {
                    guess
                } else {
                    (low * high).sqrt()
                };
                answers = with(shape.law(size));
                (leaves_um, left) = session.left(&answers, without);
            }
        }
        let law = shape.law(size);
        let detail = EffectTruth {
            name: law.effect().name().to_owned(),
            strength: 1e2 * left / bare.setup.stroke_um,
            bounded,
            parameters: law.parameters(),
            moves_um: session.moved(&answers, without),
            leaves_um,
        };
        (law, detail)
    }

    /// The records with noise and rounding, as they read back from a file in the stage's units.
    fn measured(&self, plans: &[Plan], clean: Vec<Vec<f64>>, plant: &HiddenPlant) -> Dataset {
        let setup = &plant.setup;
        let noise_um = self.noise_um(setup);
        let mut offsets = Draw::new(self.seed, Stream::Noise, 0);
        let records = plans
            .iter()
            .zip(clean)
            .enumerate()
            .map(|(index, (plan, mut y))| {
                if setup.zero == Zero::PerRecord {
                    let offset = setup.stroke_um * offsets.uniform(-0.05, 0.05);
                    y.iter_mut().for_each(|y| *y += offset);
                }
                let noise = self.noise(y.len(), index as u64 + 1);
                y.iter_mut()
                    .zip(noise)
                    .for_each(|(y, noise)| *y += noise_um * noise);
                plant.quantise(&mut y);
                let time: Vec<f64> = (0..y.len())
                    .map(|k| plan.start_s + k as f64 * plan.sample_time_s)
                    .collect();
                let time_s = through(&time, setup.time_unit);
                let start_s = time_s[0];
                Record {
                    name: plan.name.clone(),
                    role: plan.role,
                    start_s,
                    sample_time_s: (time_s[time_s.len() - 1] - start_s) / (time_s.len() - 1) as f64,
                    time_s,
                    drive_v: through(&plan.drive_v, setup.input_unit),
                    displacement_um: through(&y, setup.output_unit),
                    continues: None,
                }
            });
        Dataset {
            name: format!("hidden stage {}", self.seed),
            output_unit: setup.output_unit,
            zero: setup.zero,
            input_zero: Zero::Shared,
            records: records.collect(),
        }
    }

    /// Noise of unit variance: white, or half of its power with a memory of some twenty samples.
    fn noise(&self, samples: usize, record: u64) -> Vec<f64> {
        let mut draw = Draw::new(self.seed, Stream::Noise, record);
        let mut slow = draw.normal();
        let fresh = (1.0 - DECAY * DECAY).sqrt();
        (0..samples)
            .map(|_| {
                let white = draw.normal();
                if !self.tier.coloured() {
                    return white;
                }
                slow = DECAY * slow + fresh * draw.normal();
                (white + slow) * std::f64::consts::FRAC_1_SQRT_2
            })
            .collect()
    }
}

impl Hidden {
    /// Stages `data/` and `truth.toml`, to appear with the folder's commit.
    ///
    /// # Errors
    /// What the system refuses.
    pub fn add_to(&self, folder: &mut OutputFolder) -> Result<(), Error> {
        let setup = &self.plant.setup;
        dataset::add_files(
            &self.dataset,
            &Columns {
                time_unit: setup.time_unit,
                input: setup.input_name,
                input_unit: setup.input_unit,
                output: setup.output_name,
            },
            folder,
            Path::new("data"),
        )?;
        folder.add("truth.toml", self.truth.to_toml()?)
    }
}

fn through<U: Unit>(values: &[f64], unit: U) -> Vec<f64> {
    let scale = unit.scale();
    values
        .iter()
        .map(|&value| scale.apply(scale.undo(value)))
        .collect()
}

fn stage_truth(plant: &HiddenPlant) -> StageTruth {
    let HiddenPlant {
        setup, baseline, ..
    } = plant;
    let (family, thresholds_v, weights) = match &baseline.core.family {
        Family::Plays {
            thresholds_v,
            weights,
        } => ("plays", thresholds_v.clone(), weights.clone()),
        Family::Relays(_) => ("relays", Vec::new(), Vec::new()),
        Family::BoucWen { .. } => ("bouc-wen", Vec::new(), Vec::new()),
    };
    StageTruth {
        family: family.to_owned(),
        stroke_um: setup.stroke_um,
        gain_um_per_v: setup.gain_um_per_v(),
        offset_um: setup.offset_um,
        hysteresis_percent: baseline.hysteresis_percent,
        beta_s: baseline.beta_s,
        direct: baseline.core.direct,
        thresholds_v,
        weights,
    }
}
