//! The next step of who has a sensor: feedback around the compensator.

use hysteron::feedback::{Feedback, Gains, State};
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use crate::experiment::refused;

use super::compensators::{Compensator, Identified};
use super::inputs::{Input, Shape, Target, target};
use super::plants::{Device, Plant};
use super::sweep::{Errors, WRONG_PLANTS, median, score};

/// Frequencies of the references, Hz.
pub const FREQUENCIES_HZ: [f64; 4] = [1.0, 5.0, 20.0, 50.0];

/// Errors of the four ways to drive one plant along one sine.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FourWays {
    /// Whether the plant is 10 % off what was identified: the median of the draws.
    pub wrong: bool,
    /// The plant.
    pub plant: Plant,
    /// Frequency of the reference, Hz.
    pub frequency_hz: f64,
    /// The reference over the mean gain.
    pub linear: Errors,
    /// The cascade.
    pub compensated: Errors,
    /// Feedback alone.
    pub feedback: Errors,
    /// Feedback around the cascade.
    pub both: Errors,
}

/// Gains for a plant: mostly integral, and at a quarter to a half of where its mode begins to sing.
pub fn gains(plant: Plant) -> Gains<f64> {
    let (proportional, integral) = match plant {
        Plant::Plays => (0.05, 300.0),
        Plant::Relays => (0.0, 300.0),
        Plant::Bimorph => (0.0, 0.3),
    };
    Gains {
        proportional,
        integral,
        derivative: 0.0,
        filter: 0.0,
    }
}

/// A plant along sines, as it was identified and 10 % off; `done` is called once a frequency.
///
/// # Errors
/// A drive or reference that is refused.
pub fn run(
    plant: Plant,
    identified: &Identified,
    frequencies_hz: &[f64],
    done: &(dyn Fn() + Sync),
) -> Result<Vec<FourWays>, Error> {
    let rows = frequencies_hz
        .par_iter()
        .map(|&frequency_hz| at(plant, identified, frequency_hz))
        .inspect(|_| done())
        .collect::<Result<Vec<_>, _>>()?;
    Ok(rows.concat())
}

fn at(plant: Plant, identified: &Identified, frequency_hz: f64) -> Result<[FourWays; 2], Error> {
    let input = Input {
        shape: Shape::Sine,
        frequency_hz,
    };
    let target = target(plant, input)?;
    let linear = identified.drive(Compensator::None, None, &target)?;
    let cascade = identified.drive(Compensator::Cascade, None, &target)?;
    let nothing = vec![0.0; target.samples.len()];
    let draws = |devices: &[Device], feedforward: &[f64], closed: bool| {
        let errors = devices
            .iter()
            .map(|device| follow(plant, device, &target, feedforward, closed))
            .collect::<Result<Vec<_>, _>>()?;
        Ok::<_, Error>(median(&errors))
    };
    let ways = |wrong: bool, devices: &[Device]| {
        Ok::<_, Error>(FourWays {
            wrong,
            plant,
            frequency_hz,
            linear: draws(devices, &linear, false)?,
            compensated: draws(devices, &cascade, false)?,
            feedback: draws(devices, &nothing, true)?,
            both: draws(devices, &cascade, true)?,
        })
    };
    let off: Vec<Device> = (1..=WRONG_PLANTS).map(|seed| plant.wrong(seed)).collect();
    Ok([ways(false, &[plant.device(7)])?, ways(true, &off)?])
}

fn follow(
    plant: Plant,
    device: &Device,
    target: &Target,
    feedforward: &[f64],
    closed: bool,
) -> Result<Errors, Error> {
    let full_v = plant.full_drive_v();
    let controller =
        Feedback::new(gains(plant), target.sample_time_s, -full_v, full_v).map_err(refused)?;
    let mut state = State::at_rest(0.0);
    let mut running = device.start(target.sample_time_s).map_err(refused)?;
    // The sensor's sample comes at the end of a sample time: what it is compared with is the reference
    // of that time, not of the one to come, or a perfect feedforward would be pulled off its path.
    let (mut measured, mut due) = (0.0, 0.0);
    let mut displacement = Vec::with_capacity(target.samples.len());
    for (&wanted, &u) in target.samples.iter().zip(feedforward) {
        let drive = if closed {
            controller
                .step(&mut state, due, measured, u)
                .map_err(refused)?
        } else {
            u
        };
        measured = running.step(drive).map_err(refused)?;
        due = wanted;
        displacement.push(measured);
    }
    score(&displacement, target).map_err(refused)
}
