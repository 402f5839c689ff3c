//! What each drive does to each sensor: the frequency response of three inputs that move at once,
//! separated by their realisations.

use std::error::Error;

use nalgebra::{Complex, Matrix3, Vector3};
use realfft::RealFftPlanner;

use super::recording::{AXES, RATE_HZ, Realisation};

/// Spectra of one realisation by line, averaged over its periods: drives in V, displacements in um.
struct Spectra {
    drive: Vec<Vector3<Complex<f64>>>,
    displacement: Vec<Vector3<Complex<f64>>>,
}

/// Response of every sensor (row, um) to every drive (column, V), by line.
pub struct Response {
    /// Samples in a period.
    pub period: usize,
    /// By line from zero up to the highest driven one; zero at line zero.
    pub lines: Vec<Matrix3<Complex<f64>>>,
}

/// Shares of the rms displacement of one sensor.
#[derive(Clone, Copy, Debug)]
pub struct Shares {
    /// What the response to all three drives leaves.
    pub left: f64,
    /// What the response to its own drive alone leaves.
    pub left_by_own: f64,
    /// What one period differs from the next by, as it shows in their mean.
    pub noise: f64,
}

impl Response {
    /// Least squares over the realisations, line by line up to `top_hz`.
    ///
    /// # Errors
    /// Fewer than three realisations, or drives that are not independent at some line.
    pub fn separate(records: &[Realisation], top_hz: f64) -> Result<Self, Box<dyn Error>> {
        let spectra = spectra(records)?;
        let period = records.first().map_or(0, period);
        let top = ((top_hz * period as f64 / RATE_HZ) as usize).min(period / 2);
        let mut lines = vec![Matrix3::zeros()];
        for line in 1..=top {
            let mut across = Matrix3::zeros();
            let mut drives = Matrix3::zeros();
            for one in &spectra {
                let u = one.drive[line];
                across += one.displacement[line] * u.adjoint();
                drives += u * u.adjoint();
            }
            // Drives that are multiples of each other make the product of all three vanish.
            let size = drives.trace().re / AXES as f64;
            let inverse = drives
                .try_inverse()
                .filter(|_| drives.determinant().re > 1e-3 * size.powi(3))
                .ok_or_else(|| {
                    format!("line {line}: the realisations do not tell the drives apart")
                })?;
            lines.push(across * inverse);
        }
        Ok(Self { period, lines })
    }

    /// Frequency of a line in Hz.
    pub fn hz(&self, line: usize) -> f64 {
        line as f64 * RATE_HZ / self.period as f64
    }

    /// What the response leaves of records, those it was made from or others.
    ///
    /// # Errors
    /// Records of another period.
    pub fn shares(&self, records: &[Realisation]) -> Result<[Shares; AXES], Box<dyn Error>> {
        let spectra = spectra(records)?;
        let driven = 1..self.lines.len();
        let mut shares = Vec::new();
        for axis in 0..AXES {
            let (mut whole, mut left, mut left_by_own) = (0.0, 0.0, 0.0);
            for one in &spectra {
                for line in driven.clone() {
                    let (g, u, y) = (
                        &self.lines[line],
                        one.drive[line],
                        one.displacement[line][axis],
                    );
                    whole += y.norm_sqr();
                    left += (y - (g * u)[axis]).norm_sqr();
                    left_by_own += (y - g[(axis, axis)] * u[axis]).norm_sqr();
                }
            }
            shares.push(Shares {
                left: (left / whole).sqrt(),
                left_by_own: (left_by_own / whole).sqrt(),
                noise: scatter(records, axis),
            });
        }
        shares
            .try_into()
            .map_err(|_| "not three axes".to_owned().into())
    }

    /// Displacement of one sensor less what the other axes' drives do to it, um, by period.
    ///
    /// # Errors
    /// A record of another period.
    pub fn of_own_drive(
        &self,
        record: &Realisation,
        axis: usize,
    ) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
        let inverse = RealFftPlanner::<f64>::new().plan_fft_inverse(self.period);
        let mut periods = record.displacement_um[axis].clone();
        for (index, displacement) in periods.iter_mut().enumerate() {
            let mut others = inverse.make_input_vec();
            for input in (0..AXES).filter(|&input| input != axis) {
                let drive = spectrum(&record.drive_v[input][index])?;
                for (line, g) in self.lines.iter().enumerate() {
                    others[line] += g[(axis, input)] * drive[line];
                }
            }
            let mut moved = inverse.make_output_vec();
            inverse.process(&mut others, &mut moved)?;
            for (y, moved) in displacement.iter_mut().zip(moved) {
                *y -= moved;
            }
        }
        Ok(periods)
    }
}

fn period(record: &Realisation) -> usize {
    record.drive_v[0].first().map_or(0, Vec::len)
}

/// Transform over the number of samples.
fn spectrum(samples: &[f64]) -> Result<Vec<Complex<f64>>, Box<dyn Error>> {
    let forward = RealFftPlanner::new().plan_fft_forward(samples.len());
    let mut lines = forward.make_output_vec();
    forward.process(&mut samples.to_vec(), &mut lines)?;
    let count = samples.len() as f64;
    lines.iter_mut().for_each(|line| *line /= count);
    Ok(lines)
}

fn spectra(records: &[Realisation]) -> Result<Vec<Spectra>, Box<dyn Error>> {
    let mean = |periods: &[Vec<f64>]| {
        let share = 1.0 / periods.len() as f64;
        let samples = periods.first().map_or(0, Vec::len);
        let at = |k: usize| periods.iter().map(|period| share * period[k]).sum();
        spectrum(&(0..samples).map(at).collect::<Vec<f64>>())
    };
    let by_line = |axes: &[Vec<Vec<f64>>; AXES]| -> Result<Vec<_>, Box<dyn Error>> {
        let [first, second, third] = [mean(&axes[0])?, mean(&axes[1])?, mean(&axes[2])?];
        let lines = first.into_iter().zip(second).zip(third);
        Ok(lines.map(|((a, b), c)| Vector3::new(a, b, c)).collect())
    };
    records
        .iter()
        .map(|record| {
            Ok(Spectra {
                drive: by_line(&record.drive_v)?,
                displacement: by_line(&record.displacement_um)?,
            })
        })
        .collect()
}

/// Rms of half the difference of a record's first two periods over its rms.
fn scatter(records: &[Realisation], axis: usize) -> f64 {
    let (mut noise, mut whole) = (0.0, 0.0);
    for record in records {
        if let [first, second, ..] = &record.displacement_um[axis][..] {
            for (a, b) in first.iter().zip(second) {
                noise += (0.5 * (a - b)).powi(2);
                whole += (0.5 * (a + b)).powi(2);
            }
        }
    }
    (noise / whole).sqrt()
}
