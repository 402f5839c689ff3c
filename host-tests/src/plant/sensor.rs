//! Displacement sensor: seeded noise and rounding.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::error::{StageError, require};

/// What separates a sensor sample from the displacement.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensor {
    /// Rms of white Gaussian noise, um; 0 for none.
    pub noise_um: f64,
    /// Step of the output, um; 0 for none.
    pub step_um: f64,
    /// Seed of the noise. A seed means the same noise on every platform; only samples beyond 3.6
    /// times the rms, which take a logarithm, may differ in their last digit.
    pub seed: u64,
}

impl Sensor {
    /// Checks noise and step.
    ///
    /// # Errors
    /// [`StageError::Parameter`] with the field's name.
    pub fn validate(&self) -> Result<(), StageError> {
        for (field, value) in [
            ("sensor.noise_um", self.noise_um),
            ("sensor.step_um", self.step_um),
        ] {
            require(
                (0.0..=1e6).contains(&value),
                field,
                value,
                "must be 0 to 1e6 um",
            )?;
        }
        Ok(())
    }

    /// The noise generator at its start.
    pub(super) fn generator(&self) -> Pcg64 {
        Pcg64::seed_from_u64(self.seed)
    }

    /// One sample of a displacement, um.
    pub(super) fn sample(&self, generator: &mut Pcg64, displacement_um: f64) -> f64 {
        let normal: f64 = StandardNormal.sample(generator);
        let noisy = displacement_um + self.noise_um * normal;
        if self.step_um > 0.0 {
            (noisy / self.step_um).round() * self.step_um
        } else {
            noisy
        }
    }
}
