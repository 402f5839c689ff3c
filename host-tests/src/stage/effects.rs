//! From the stages of a model file to the effects of the core.

use hysteron::chain::Effects;
use hysteron::effect::backlash::Backlash;
use hysteron::effect::congruency::Congruency;
use hysteron::effect::creep::Creep;
use hysteron::effect::cubic::Cubic;
use hysteron::effect::delay::Delay;
use hysteron::effect::drift::Drift;
use hysteron::effect::interleaving::Interleaving;
use hysteron::effect::lag::Lag;
use hysteron::effect::mains_hum::{Line, MainsHum};
use hysteron::effect::quadratic::Quadratic;
use hysteron::effect::quantisation::Quantisation;
use hysteron::effect::rate_power::RatePower;
use hysteron::effect::resonance::Resonance;
use hysteron::effect::saturation::Saturation;
use hysteron::effect::slew_limit::SlewLimit;
use hysteron::error::{Field, ParameterError};
use hysteron::hysteresis::bouc_wen::BoucWen;

use crate::model_file::Stage;

/// The blocks of the core for the effects among `stages`, for samples `h` seconds apart; the gain of an
/// output stage among them is that of a congruency, else it is 1 um/V.
///
/// # Errors
/// Numbers that the core refuses, with the name of their stage.
pub(crate) fn effects(
    stages: &[Stage],
    h: f64,
) -> Result<Effects<f64>, (&'static str, ParameterError)> {
    let mut effects = Effects::default();
    let mut modes = 0;
    let gain = stages.iter().find_map(|stage| match stage {
        Stage::Output(output) => Some(output.gain_um_per_v),
        _ => None,
    });
    for stage in stages {
        add(&mut effects, &mut modes, stage, gain.unwrap_or(1.0), h)
            .map_err(|refused| (stage.name(), refused))?;
    }
    Ok(effects)
}

fn add(
    effects: &mut Effects<f64>,
    modes: &mut usize,
    stage: &Stage,
    gain: f64,
    h: f64,
) -> Result<(), ParameterError> {
    match stage {
        Stage::Saturation(limit) => effects.saturation = Some(Saturation::new(limit.limit_v)?),
        Stage::SlewLimit(limit) => {
            effects.slew_limit = Some(SlewLimit::new(limit.slew_v_per_s, h)?);
        }
        Stage::AmplifierLag(lag) => effects.amplifier_lag = Some(Lag::new(lag.tau_s, h)?),
        Stage::TransportDelay(delay) => {
            effects.transport_delay = Some(Delay::new(delay.delay_s, h)?);
        }
        Stage::BoucWen(element) => {
            let [weight, grow, shape] = [element.weight, element.grow_per_v, element.shape_per_v];
            effects.elements.add(BoucWen::new(weight, grow, shape)?)?;
        }
        Stage::RateLaw(law) => effects.rate_law = Some(RatePower::new(law.exponent)?),
        Stage::Congruency(congruency) => {
            effects.congruency = Some(Congruency::new(congruency.kappa, gain)?);
        }
        Stage::Quadratic(map) => effects.quadratic = Some(Quadratic::new(map.q)?),
        Stage::Cubic(map) => effects.cubic = Some(Cubic::new(map.c)?),
        Stage::Backlash(gap) => effects.backlash = Some(Backlash::new(gap.width)?),
        Stage::Resonance(mode) => {
            let slot = effects.resonances.get_mut(*modes);
            let slot = slot.ok_or(ParameterError::TooLarge(Field::Modes))?;
            *slot = Some(Resonance::new(mode.f_n_hz, mode.zeta, h)?);
            *modes += 1;
        }
        Stage::Creep(creep) => {
            let built = Creep::new(creep.gain_per_decade, creep.tau_min_s, creep.tau_max_s, h);
            effects.creep = Some(built?);
        }
        Stage::OutputQuadratic(map) => effects.output_quadratic = Some(Quadratic::new(map.q)?),
        Stage::Interleaving(product) => {
            effects.interleaving = Some(Interleaving::new(product.g)?);
        }
        Stage::SensorLag(lag) => effects.sensor_lag = Some(Lag::new(lag.tau_s, h)?),
        Stage::Drift(drift) => effects.drift = Some(Drift::new(drift.amplitude, drift.tau_s)?),
        Stage::MainsHum(hum) => {
            let first = Line {
                amplitude: hum.amplitude,
                phase: hum.phase_rad,
            };
            let third = Line {
                amplitude: hum.third_amplitude,
                phase: hum.third_phase_rad,
            };
            effects.mains_hum = Some(MainsHum::new(hum.frequency_hz, first, third)?);
        }
        Stage::Quantisation(steps) => {
            effects.quantisation = Some(Quantisation::new(steps.step)?);
        }
        Stage::Hysteresis(_) | Stage::Asymmetry(_) | Stage::Output(_) | Stage::ModifiedPlay(_) => {}
    }
    Ok(())
}
