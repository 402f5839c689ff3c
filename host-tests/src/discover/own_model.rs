//! A model of the user's own as the baseline: its plays and effects as a start for joint fits.

use crate::dataset::{Dataset, Role};
use crate::error::Error;
use crate::identify::catalogue::Effect;
use crate::identify::joint::{Core, Element, Joint, JointFit, SETTLED, Terms};
use crate::identify::run::Runs;
use crate::model_file::{ModelFile, Stage};
use crate::stage;

use super::baseline::{Histories, choose_starts};
use super::diagnosis::Diagnosis;
use super::search::{Candidate, Ground};
use super::workflow::{residuals, roles};

/// The model as it is given, offset apart, with its rms on the fit records.
///
/// # Errors
/// A model that the core refuses or that joint fits do not hold: a modified play model, plays with
/// negative weights, a gain of the other sign than the data's.
pub fn given(model: &ModelFile, runs: &Runs) -> Result<Joint, Error> {
    let fit = JointFit::new(runs);
    let seen = fit.seen();
    let refused = |why: String| Error::request(format!("model \"{}\": {why}", model.name));
    // The core checks the numbers.
    stage::chain(model, seen.sample_time_s)?;
    let hysteresis = model
        .hysteresis()
        .ok_or_else(|| refused("it has no stage hysteresis".to_owned()))?;
    let (gain, _) = model.output();
    if gain * runs.sign < 0.0 {
        return Err(refused(
            "its gain has the other sign than these records; correct the sign of one of them"
                .to_owned(),
        ));
    }
    if let Some(i) = hysteresis.weights.iter().position(|a| *a < 0.0) {
        return Err(refused(format!(
            "weight {i} is negative, which the fit of a diagnosis does not allow; name another baseline"
        )));
    }
    let gain = gain.abs();
    // A map's slope at zero is the gain's.
    let slope = model
        .asymmetry()
        .and_then(|map| map.slopes.positive.first())
        .copied()
        .unwrap_or(1.0);
    let mut core = Core {
        thresholds: hysteresis.thresholds_v.clone(),
        weights: hysteresis
            .weights
            .iter()
            .map(|a| a * gain * slope)
            .collect(),
        beta: hysteresis.beta_s,
        elements: Vec::new(),
    };
    for stage in &model.stages {
        if let Stage::BoucWen(element) = stage {
            let weight = element.weight * gain * slope;
            let known = Element::known(element.grow_per_v, element.shape_per_v);
            if let Some(same) = core.elements.iter().position(|other| *other == known) {
                core.weights[hysteresis.weights.len() + same] += weight;
            } else {
                core.elements.push(known);
                core.weights.push(weight);
            }
        }
    }
    let mut terms = Terms::none();
    if core.beta > 0.0 {
        let exponent = model.stages.iter().find_map(|stage| match stage {
            Stage::RateLaw(law) => Some(law.exponent),
            _ => None,
        });
        let rate = seen.rate_v_per_s.powf(exponent.unwrap_or(1.0));
        let share = core.beta * rate / seen.threshold_v;
        terms = terms.with(Effect::RateDependence, vec![share]);
    }
    for stage in &model.stages {
        let before = matches!(stage, Stage::Asymmetry(_));
        let stage = with_gain_up(stage, runs.sign, slope);
        let gain = if before { gain * slope } else { gain };
        let found = Effect::ALL.into_iter().find_map(|effect| {
            let numbers = effect.template().numbers(&stage, seen, gain)?;
            Some((effect, numbers))
        });
        match found {
            // Without a rate term the power of the rate says nothing.
            Some((Effect::RateLaw, _)) if core.beta <= 0.0 => {}
            Some((effect, numbers)) => terms = terms.with(effect, numbers),
            // Hysteresis and output are the core's.
            None => {}
        }
    }
    core.beta = terms.beta(seen);
    let rms = fit.rms(&core, &terms, Role::Fit)?;
    Ok(Joint { core, terms, rms })
}

/// A stage as it is where the displacement rises with the drive, for an output of the hysteresis that
/// has the slope of the map at zero already.
fn with_gain_up(stage: &Stage, sign: f64, slope: f64) -> Stage {
    let mut stage = stage.signed(sign);
    if let Stage::Congruency(law) = &mut stage {
        law.kappa /= slope;
    }
    stage
}

/// The model among many more plays, all its numbers fitted anew, on histories chosen by it.
///
/// # Errors
/// As [`given`].
pub fn fitted_anew(
    model: &ModelFile,
    runs: &mut Runs,
    histories: Histories,
) -> Result<Joint, Error> {
    let mut joint = given(model, runs)?;
    choose_starts(runs, &joint, histories)?;
    joint = given(model, runs)?;
    for _ in 0..2 {
        let ground = Ground {
            runs: runs.clone(),
            histories,
        };
        let start = Candidate::new(&ground.fit(), joint, Vec::new())?;
        joint = ground.refit(&start)?.joint;
        choose_starts(runs, &joint, histories)?;
    }
    let fit = JointFit::new(runs);
    joint.rms = fit.rms(&joint.core, &joint.terms, Role::Fit)?;
    fit.settle(&mut joint, SETTLED.0)?;
    Ok(joint)
}

/// Makes the model as it was given the baseline of a diagnosis that has searched from its refit on
/// `ground`: figures, residuals and what is said of them.
///
/// # Errors
/// As [`given`].
pub fn report(
    model: &ModelFile,
    ground: &Ground,
    dataset: &Dataset,
    found: &mut Diagnosis,
) -> Result<(), Error> {
    let joint = given(model, &ground.runs)?;
    let as_given = Candidate::new(&ground.fit(), joint, Vec::new())?;
    found.refitted = Some(std::mem::replace(
        &mut found.baseline,
        roles(ground, &as_given)?,
    ));
    found.before = residuals(dataset, ground, &as_given)?;
    found.baseline_model = model.clone();
    let offset = if ground.runs.own_offsets {
        "which is fitted to each record"
    } else {
        "one for all records, which is fitted to the fit records"
    };
    found.notes.insert(
        0,
        format!(
            "The baseline is the model \"{}\" as it was given, but for its offset, {offset}. Effects are \
             looked for beside it with all its weights and numbers fitted anew, and counted from what \
             that leaves.",
            model.name
        ),
    );
    Ok(())
}
