//! Preisach's plane of relays, without a single relay in it.
//!
//! A relay switches up when the drive rises to alpha and down when it falls to beta. What all relays
//! inside the triangle `low <= beta <= alpha <= high` carry together, the Everett function, has a
//! closed form for the density chosen here, and the relays that are up at any time differ from those
//! after the last turning point by one such triangle. So the state is the list of turning points that
//! have not been passed again, and any number of relays costs one evaluation a step.

use crate::plant::error::{StageError, require};

/// Density of relays over their thresholds,
/// `density (1 + widening r) (1 + tilt m - (m / reach)^2)` with half width `r = (alpha - beta) / 2` and
/// middle `m = (alpha + beta) / 2`, um/V^2.
///
/// Because it depends on where a relay lies and not only on how wide it is, no weighted sum of plays
/// has these loops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayDensity {
    /// Density of narrow relays around 0 V, um/V^2.
    pub density_um_per_v2: f64,
    /// Relative growth of the density with the half width, 1/V.
    pub widening_per_v: f64,
    /// Relative growth of the density with the middle, 1/V: loops are larger on one side.
    pub tilt_per_v: f64,
    /// Distance from 0 V at which no relay is left without a tilt, V; the drive stays within it.
    pub reach_v: f64,
}

impl RelayDensity {
    /// Checks the ranges of all values.
    ///
    /// # Errors
    /// [`StageError::Parameter`] with the field's name.
    pub fn validate(&self) -> Result<(), StageError> {
        require(
            (0.0..=1e6).contains(&self.density_um_per_v2),
            "relays.density_um_per_v2",
            self.density_um_per_v2,
            "must be 0 to 1e6 um/V^2",
        )?;
        require(
            (0.0..=1e6).contains(&self.widening_per_v),
            "relays.widening_per_v",
            self.widening_per_v,
            "must be 0 to 1e6 1/V",
        )?;
        require(
            self.tilt_per_v.abs() <= 1e6,
            "relays.tilt_per_v",
            self.tilt_per_v,
            "must be within +-1e6 1/V",
        )?;
        require(
            self.reach_v > 0.0 && self.reach_v <= 1e6,
            "relays.reach_v",
            self.reach_v,
            "must be above 0 and at most 1e6 V",
        )
    }

    /// The density itself at the thresholds `alpha >= beta`, um/V^2.
    pub fn at(&self, alpha_v: f64, beta_v: f64) -> f64 {
        let (half, middle) = (0.5 * (alpha_v - beta_v), 0.5 * (alpha_v + beta_v));
        let place = middle / self.reach_v;
        self.density_um_per_v2
            * (1.0 + self.widening_per_v * half)
            * (1.0 + self.tilt_per_v * middle - place * place).max(0.0)
    }

    /// Everett function: what the relays with `low <= beta <= alpha <= high` carry, um.
    pub fn everett_um(&self, high_v: f64, low_v: f64) -> f64 {
        // Over the triangle, m runs from c - (R - r) to c + (R - r) for every r up to R, and an area
        // element is 2 dm dr.
        let (half, middle) = (0.5 * (high_v - low_v), 0.5 * (high_v + low_v));
        let (place, size) = (middle / self.reach_v, half / self.reach_v);
        let grown = self.widening_per_v * half;
        4.0 * self.density_um_per_v2
            * half
            * half
            * ((1.0 + self.tilt_per_v * middle - place * place) * (0.5 + grown / 6.0)
                - size * size / 3.0 * (0.25 + grown / 20.0))
    }
}

/// The relays under a drive: its turning points that still matter.
#[derive(Debug, Clone)]
pub struct Relays {
    density: RelayDensity,
    /// Turning points in V, each with what all relays carried there in um. The first is the drive
    /// farthest from zero so far; each later one lies between the two before it.
    turns: Vec<(f64, f64)>,
    drive_v: f64,
    displacement_um: f64,
}

impl Relays {
    /// The virgin state at 0 V: of the relays of every width, those in the lower half are up.
    pub fn new(density: RelayDensity) -> Self {
        Self {
            density,
            turns: Vec::new(),
            drive_v: 0.0,
            displacement_um: 0.0,
        }
    }

    /// Takes the drive to `drive_v`, limited to the reach; returns what all relays carry, um.
    pub fn advance(&mut self, drive_v: f64) -> f64 {
        let reach = self.density.reach_v;
        let drive_v = drive_v.clamp(-reach, reach);
        if drive_v == self.drive_v {
            return self.displacement_um;
        }
        let back = match self.turns.last() {
            Some(&(turn_v, _)) => (drive_v > self.drive_v) != (self.drive_v > turn_v),
            None => (drive_v > self.drive_v) != (self.drive_v > 0.0) && self.drive_v != 0.0,
        };
        if back {
            self.turns.push((self.drive_v, self.displacement_um));
        }
        self.wipe_out(drive_v);
        self.drive_v = drive_v;
        self.displacement_um = match self.turns.last() {
            Some(&(turn_v, turn_um)) => {
                let (high, low) = (drive_v.max(turn_v), drive_v.min(turn_v));
                turn_um + (2.0 * self.density.everett_um(high, low)).copysign(drive_v - turn_v)
            }
            // By symmetry the virgin curve takes along half of what a full swing would.
            None => {
                let size = drive_v.abs();
                self.density.everett_um(size, -size).copysign(drive_v)
            }
        };
        self.displacement_um
    }

    /// Forgets the turning points that the drive has passed again.
    fn wipe_out(&mut self, drive_v: f64) {
        while let [earlier @ .., (turn_v, _)] = self.turns.as_slice() {
            // Off the virgin curve at a turn, the drive is on it again at the turn's mirror image.
            let until_v = earlier.last().map_or(-turn_v, |&(before_v, _)| before_v);
            let passed = if until_v > *turn_v {
                drive_v >= until_v
            } else {
                drive_v <= until_v
            };
            if !passed {
                return;
            }
            self.turns.pop();
            self.turns.pop();
        }
    }

    /// Turning points remembered now.
    pub fn remembered(&self) -> usize {
        self.turns.len()
    }
}
