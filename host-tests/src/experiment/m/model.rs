//! The proposed model, with and without its term g, and its recursive identification.

use hysteron::hysteresis::modified_play::{
    Basis, BasisParameters, Harmonics, LinearPlane, ModifiedPlay, Signals, Terms,
};
use hysteron::rls::Rls;

use crate::error::Error;
use crate::experiment::refused;

use super::record::{Record, SAMPLE_TIME_S};

/// The paper's N.
pub const DIVISIONS: usize = 10;
/// Coefficients: 2A, nine slopes and an offset, which is what the 55 weights of the printed plane
/// amount to, then g, c_1 to c_3 and the six of the harmonic terms.
pub const COEFFICIENTS: usize = DIVISIONS + 1 + 10;
/// Place of g.
pub const G: usize = DIVISIONS + 1;

/// The printed plane, collapsed.
pub type Plane = LinearPlane<f64, DIVISIONS>;
/// The model in double precision.
pub type Model = ModifiedPlay<f64, DIVISIONS, Plane>;

/// Which model, and how it is identified recursively.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recipe {
    /// Whether it has the term `g y[k-1] u[k-1]`.
    pub interleaving: bool,
    /// Form of the harmonic terms.
    pub harmonics: Harmonics,
    /// Slope of both envelopes, s.
    pub envelope_s: f64,
    /// Entries of the initial covariance's diagonal; the estimate starts at zero, nothing is
    /// forgotten.
    pub covariance: f64,
    /// Time between samples, s.
    pub sample_time_s: f64,
}

impl Recipe {
    /// Initial covariance of the models that compensate. A sine leaves most of the 21 coefficients
    /// to it: less, or 1e4 and more, and a model runs away in free run at some frequency.
    pub const COVARIANCE: f64 = 1.0;
    /// Initial covariance that leaves the least one-step error.
    pub const WEAK_COVARIANCE: f64 = 1e8;

    /// As in the paper.
    pub const PROPOSED: Self = Self {
        interleaving: true,
        harmonics: Harmonics::Printed,
        envelope_s: 0.0,
        covariance: Self::COVARIANCE,
        sample_time_s: SAMPLE_TIME_S,
    };

    /// The terms at one frequency.
    ///
    /// # Errors
    /// A frequency above half the sample rate.
    pub fn basis(&self, frequency_hz: f64) -> Result<Basis<f64, DIVISIONS>, Error> {
        let parameters = BasisParameters {
            u_max: 1.0,
            divisions: DIVISIONS,
            alpha: self.envelope_s,
            beta: self.envelope_s,
            harmonics: self.harmonics,
            frequency: frequency_hz,
        };
        parameters.build(self.sample_time_s).map_err(refused)
    }

    /// The terms along a record with measured outputs, one row a sample.
    ///
    /// # Errors
    /// As [`Recipe::basis`].
    pub fn rows(&self, record: &Record) -> Result<Vec<[f64; COEFFICIENTS]>, Error> {
        let basis = self.basis(record.frequency_hz)?;
        let mut state = basis.start();
        let samples = record.drive.iter().zip(&record.displacement_mm);
        let rows = samples.map(|(&drive, &measured)| {
            let rate = basis.backward_rate(&state, drive);
            let signals = basis.advance(&mut state, drive, rate);
            state.remember(drive, measured);
            self.row(&basis, &signals)
        });
        Ok(rows.collect())
    }

    fn row(
        &self,
        basis: &Basis<f64, DIVISIONS>,
        signals: &Signals<f64, DIVISIONS>,
    ) -> [f64; COEFFICIENTS] {
        let mut row = [0.0; COEFFICIENTS];
        let terms = basis.linear_terms(signals).chain(signals.other_terms());
        for (entry, term) in row.iter_mut().zip(terms) {
            *entry = term;
        }
        if !self.interleaving {
            row[G] = 0.0;
        }
        row
    }

    /// Identifies the coefficients by recursive least squares over a record, measured outputs in
    /// their terms.
    ///
    /// # Errors
    /// A covariance that is out of range.
    pub fn identify(&self, record: &Record) -> Result<[f64; COEFFICIENTS], Error> {
        let trace = 2.0 * COEFFICIENTS as f64 * self.covariance;
        let rls = Rls::new(1.0, self.covariance, trace).map_err(refused)?;
        let mut estimate = rls.start([0.0; COEFFICIENTS]);
        for (row, &measured) in self.rows(record)?.iter().zip(&record.displacement_mm) {
            rls.update(&mut estimate, row, measured).map_err(refused)?;
        }
        Ok(*estimate.parameters())
    }

    /// The model with these coefficients.
    ///
    /// # Errors
    /// Coefficients that are not finite.
    pub fn model(
        &self,
        frequency_hz: f64,
        coefficients: &[f64; COEFFICIENTS],
    ) -> Result<Model, Error> {
        let basis = self.basis(frequency_hz)?;
        let (plane, others) = coefficients.split_at(DIVISIONS + 1);
        let (slopes, offset) = plane.split_at(DIVISIONS);
        let plane = Plane::new(basis.grid(), slopes, offset[0]).map_err(refused)?;
        let others = others.try_into().map_err(refused)?;
        ModifiedPlay::new(&basis, plane, Terms::from_list(others)).map_err(refused)
    }
}

/// Output along a drive from the model's own outputs, mm.
pub fn free_run(model: &Model, drive: &[f64]) -> Vec<f64> {
    let mut state = model.start();
    drive.iter().map(|&u| model.step(&mut state, u)).collect()
}

/// Output along a record from the measured outputs before each sample, mm.
pub fn one_step(model: &Model, record: &Record) -> Vec<f64> {
    let mut state = model.start();
    let samples = record.drive.iter().zip(&record.displacement_mm);
    samples
        .map(|(&drive, &measured)| {
            let rate = model.basis().backward_rate(&state, drive);
            model.predict(&mut state, drive, rate, measured)
        })
        .collect()
}
