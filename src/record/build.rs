//! From a record to its compensator.

use super::target::{Ahead, Parts, TargetCompensator};
use super::{
    ChainRecord, DEAD_ZONES, Effect, Inverse, ModelRecord, ModifiedPlayRecord, PLAYS, Preview,
    RecordError, SAMPLE_TIME_TOLERANCE, WINDOW, Zones,
};
use crate::cascade::Cascade;
use crate::chain::{Chain, DELAY_SPAN, Effects, MODES};
use crate::dim::{Dim, Law};
use crate::effect::asymmetry::{Asymmetry, Side};
use crate::effect::backlash::Backlash;
use crate::effect::creep::Creep;
use crate::effect::cubic::Cubic;
use crate::effect::delay::Delay;
use crate::effect::interleaving::Interleaving;
use crate::effect::lag::Lag;
use crate::effect::quadratic::Quadratic;
use crate::effect::resonance::Resonance;
use crate::error::{Field, ParameterError};
use crate::hysteresis::Parameters;
use crate::hysteresis::modified_play::{BasisParameters, LinearPlane, ModifiedPlay, Terms};
use crate::hysteresis::preview::PreviewSettings;
use crate::model::Model;

/// Samples that a compensator of the target can look ahead: preview, modes, lag, delay.
pub const LOOK_AHEAD: usize = (WINDOW - 1)
    + MODES * Resonance::<f32>::LATENCY
    + Lag::<f32>::LATENCY
    // The delay itself, and what its cubic takes on either side.
    + (DELAY_SPAN - 3 + 2);

impl ModelRecord {
    /// The compensator for samples that are `sample_time` seconds apart, at rest.
    ///
    /// # Errors
    /// See [`RecordError`].
    pub fn compensator(&self, sample_time: f32) -> Result<TargetCompensator, RecordError> {
        let mut place = None;
        self.put_compensator(sample_time, &mut place)?;
        place.ok_or(RecordError::Order(0))
    }

    /// As [`ModelRecord::compensator`], right into its place: it takes a good part of the target's
    /// memory.
    ///
    /// # Errors
    /// See [`RecordError`]; the place is as it was.
    pub fn put_compensator(
        &self,
        sample_time: f32,
        place: &mut Option<TargetCompensator>,
    ) -> Result<(), RecordError> {
        match self {
            Self::ModifiedPlay(record) => record.put_dim(sample_time, place),
            Self::Chain(record) => {
                // Even where they are left as they are: switching over to them must not fail.
                let effects = record.effects(sample_time)?;
                match record.inverse {
                    Inverse::Explicit => record.put_inverse(sample_time, place),
                    Inverse::Preview(preview) => {
                        record.put_ahead(sample_time, Effects::default(), Some(preview), place)
                    }
                    Inverse::Cascade(preview) => {
                        let preview = (record.beta_s != 0.0).then_some(preview);
                        record.put_ahead(sample_time, effects, preview, place)
                    }
                }
            }
        }
    }
}

// No two of the functions that put something are inlined into one: their frames would add up.
impl ChainRecord {
    #[inline(never)]
    fn put_inverse(
        &self,
        sample_time: f32,
        place: &mut Option<TargetCompensator>,
    ) -> Result<(), RecordError> {
        let compensator = self.model(sample_time)?.compensator()?;
        // The first step takes the plays from zero to its sample.
        let state = compensator.hysteresis().start(0.0);
        *place = Some(TargetCompensator::Inverse(Parts { compensator, state }));
        Ok(())
    }

    #[inline(never)]
    fn put_ahead(
        &self,
        sample_time: f32,
        effects: Effects<f32>,
        preview: Option<Preview>,
        place: &mut Option<TargetCompensator>,
    ) -> Result<(), RecordError> {
        let settings = match preview {
            Some(Preview { window, plant_rate }) => {
                let window = usize::from(window);
                if !(2..=WINDOW).contains(&window) {
                    return Err(RecordError::Window);
                }
                Some(PreviewSettings {
                    window,
                    sweeps: 1,
                    plant_rate,
                })
            }
            None => None,
        };
        let cascade = Cascade::new(&Chain::new(self.model(sample_time)?, effects), settings)?;
        // Creep has long been at rest where no drive puts the stage.
        let start = cascade.start(self.offset_um);
        let state = start.map_err(|_| ParameterError::NotFinite(Field::Offset, 0))?;
        *place = Some(TargetCompensator::Ahead(Ahead::new(cascade, state)));
        Ok(())
    }

    fn model(&self, sample_time: f32) -> Result<Model<f32, PLAYS, DEAD_ZONES>, RecordError> {
        let asymmetry = self
            .asymmetry
            .as_ref()
            .map(|sides| Asymmetry::new(sides.positive.side(), sides.negative.side()));
        let hysteresis = Parameters {
            weights: &self.weights,
            thresholds: &self.thresholds_v,
            beta: self.beta_s,
        };
        Ok(Model::new(
            hysteresis.build(sample_time)?,
            asymmetry.transpose()?,
            self.gain_um_per_v,
            self.offset_um,
        )?)
    }

    #[inline(never)]
    fn effects(&self, sample_time: f32) -> Result<Effects<f32>, RecordError> {
        let mut effects = Effects::default();
        let mut modes = effects.resonances.iter_mut();
        let mut before = None;
        for (index, &effect) in self.effects.iter().enumerate() {
            let place = effect.place();
            let again = matches!(effect, Effect::Resonance { .. }) && before == Some(place);
            if before.is_some_and(|before| before >= place) && !again {
                return Err(RecordError::Order(index as u8));
            }
            before = Some(place);
            match effect {
                Effect::AmplifierLag { tau_s } => {
                    effects.amplifier_lag = Some(Lag::new(tau_s, sample_time)?);
                }
                Effect::TransportDelay { delay_s } => {
                    effects.transport_delay = Some(Delay::new(delay_s, sample_time)?);
                }
                Effect::Quadratic { q } => effects.quadratic = Some(Quadratic::new(q)?),
                Effect::Cubic { c } => effects.cubic = Some(Cubic::new(c)?),
                Effect::Resonance { f_n_hz, zeta } => {
                    let slot = modes.next().ok_or(ParameterError::TooLarge(Field::Modes))?;
                    *slot = Some(Resonance::new(f_n_hz, zeta, sample_time)?);
                }
                Effect::Creep {
                    gain_per_decade,
                    tau_min_s,
                    tau_max_s,
                } => {
                    effects.creep = Some(Creep::new(
                        gain_per_decade,
                        tau_min_s,
                        tau_max_s,
                        sample_time,
                    )?);
                }
                Effect::OutputQuadratic { q } => {
                    effects.output_quadratic = Some(Quadratic::new(q)?);
                }
                Effect::Backlash { width } => effects.backlash = Some(Backlash::new(width)?),
                Effect::Interleaving { g } => effects.interleaving = Some(Interleaving::new(g)?),
            }
        }
        Ok(effects)
    }
}

impl ModifiedPlayRecord {
    #[inline(never)]
    fn put_dim(
        &self,
        sample_time: f32,
        place: &mut Option<TargetCompensator>,
    ) -> Result<(), RecordError> {
        let apart = (self.sample_time_s - sample_time).abs();
        // A NaN is no match either.
        let matches = apart <= SAMPLE_TIME_TOLERANCE * sample_time;
        if !matches {
            return Err(RecordError::SampleTime);
        }
        let basis = BasisParameters {
            u_max: self.u_max_v,
            divisions: self.slopes_um_per_v.len(),
            alpha: self.alpha_s,
            beta: self.beta_s,
            harmonics: self.harmonics,
            frequency: self.frequency_hz,
        }
        .build(sample_time)?;
        let plane = LinearPlane::new(basis.grid(), &self.slopes_um_per_v, self.offset_um)?;
        let terms = Terms {
            interleaving: self.interleaving_per_v,
            feedback: self.feedback,
            sine: self.sine,
            cosine: self.cosine,
        };
        let model = ModifiedPlay::new(&basis, plane, terms)?;
        let compensator = match self.law {
            Law::Printed => Dim::printed(model)?,
            Law::Exact => Dim::exact(model)?,
        };
        let state = compensator.start();
        *place = Some(TargetCompensator::Dim(Parts { compensator, state }));
        Ok(())
    }
}

impl Zones {
    fn side(&self) -> Side<'_, f32> {
        Side {
            slopes: &self.slopes,
            thresholds: &self.thresholds,
        }
    }
}
