//! The blocks of the core that a set of stages is made of, built for one sample time.

use hysteron::chain::Effects;
use hysteron::effect::asymmetry::Asymmetry;

use crate::error::Error;
use crate::model_file::Stage;
use crate::stage;

/// Highest frequency of a mode that is computed, over the sample rate.
pub const FASTEST_MODE: f64 = 0.45;

/// What stands around the plays, in volts before and micrometres behind them.
pub struct Blocks {
    /// All effects but the asymmetry.
    pub effects: Effects<f64>,
    /// The asymmetry map.
    pub asymmetry: Option<Asymmetry<f64, { stage::CORNERS }>>,
}

impl Blocks {
    /// The blocks of `stages`, whose hysteresis yields micrometres.
    ///
    /// # Errors
    /// Numbers that the core refuses.
    pub fn new(stages: &[Stage], sample_time_s: f64) -> Result<Self, Error> {
        let refused = |stage: &str, refused: hysteron::error::ParameterError| {
            Error::request(format!("an effect of the fit: {stage}.{refused}"))
        };
        // A mode beyond what a slow record can hold follows at once.
        let slow = |stage: &&Stage| match stage {
            Stage::Resonance(mode) => mode.f_n_hz * sample_time_s < FASTEST_MODE,
            _ => true,
        };
        let within: Vec<Stage> = stages.iter().filter(slow).cloned().collect();
        let effects = stage::effects(&within, sample_time_s)
            .map_err(|(stage, error)| refused(stage, error))?;
        let map = stages.iter().find_map(|stage| match stage {
            Stage::Asymmetry(map) => Some(map),
            _ => None,
        });
        let asymmetry = map
            .map(stage::asymmetry)
            .transpose()
            .map_err(|error| refused("asymmetry", error))?;
        Ok(Self { effects, asymmetry })
    }

    /// Whether anything behind the hysteresis remembers.
    pub fn remember_behind(&self) -> bool {
        let effects = &self.effects;
        effects.backlash.is_some()
            || effects.resonances.iter().flatten().next().is_some()
            || effects.creep.is_some()
            || effects.interleaving.is_some()
            || effects.sensor_lag.is_some()
    }
}
