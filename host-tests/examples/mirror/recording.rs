//! The mirror's records: `.npy` arrays of samples x channels x realisations x periods.

use std::error::Error;
use std::fs;
use std::path::Path;

/// Axes, drives and sensors alike.
pub const AXES: usize = 3;
/// Samples a second.
pub const RATE_HZ: f64 = 6400.0;

/// One realisation of the drives, as many periods as were recorded in its steady state.
#[derive(Clone, Debug)]
pub struct Realisation {
    /// Drive in V, by axis and period.
    pub drive_v: [Vec<Vec<f64>>; AXES],
    /// Displacement in um, by axis and period.
    pub displacement_um: [Vec<Vec<f64>>; AXES],
}

/// Reads `u_NAME.npy` (V) and `y_NAME.npy` (m) from a folder.
///
/// # Errors
/// A file that is missing or no `.npy` of 64-bit floats in the order of C, shapes that differ or are not
/// samples x 3 x realisations x periods.
pub fn read(folder: &Path, name: &str) -> Result<Vec<Realisation>, Box<dyn Error>> {
    let drives = array(&folder.join(format!("u_{name}.npy")), 1.0)?;
    let displacements = array(&folder.join(format!("y_{name}.npy")), 1e6)?;
    if drives.len() != displacements.len() {
        return Err(format!("{name}: u and y differ in their realisations").into());
    }
    Ok(drives
        .into_iter()
        .zip(displacements)
        .map(|(drive_v, displacement_um)| Realisation {
            drive_v,
            displacement_um,
        })
        .collect())
}

/// By realisation, axis, period, sample.
type Array = Vec<[Vec<Vec<f64>>; AXES]>;

fn array(path: &Path, scale: f64) -> Result<Array, Box<dyn Error>> {
    let told = |problem: &str| format!("{}: {problem}", path.display());
    let bytes = fs::read(path).map_err(|e| told(&e.to_string()))?;
    let (shape, data) = npy(&bytes).map_err(told)?;
    let [samples, AXES, realisations, periods] = shape[..] else {
        return Err(told("not samples x 3 x realisations x periods").into());
    };
    let step = AXES * realisations * periods;
    if step.checked_mul(samples) != Some(data.len()) {
        return Err(told("fewer or more numbers than its header says").into());
    }
    let column = |channel: usize, realisation: usize, period: usize| -> Vec<f64> {
        let from = (channel * realisations + realisation) * periods + period;
        let picked = data.iter().skip(from).step_by(step);
        picked
            .map(|number| scale * f64::from_le_bytes(*number))
            .collect()
    };
    Ok((0..realisations)
        .map(|realisation| {
            std::array::from_fn(|channel| {
                (0..periods)
                    .map(|period| column(channel, realisation, period))
                    .collect()
            })
        })
        .collect())
}

/// Shape and numbers of a `.npy` file, version 1.0, of little-endian 64-bit floats in the order of C: the
/// one kind that the mirror's files are of.
fn npy(bytes: &[u8]) -> Result<(Vec<usize>, &[[u8; 8]]), &'static str> {
    const ANOTHER: &str = "not a .npy file, version 1.0, of 64-bit floats in the order of C";
    let rest = bytes.strip_prefix(b"\x93NUMPY\x01\x00").ok_or(ANOTHER)?;
    let (length, rest) = rest.split_first_chunk::<2>().ok_or(ANOTHER)?;
    let length = usize::from(u16::from_le_bytes(*length));
    let (header, data) = rest.split_at_checked(length).ok_or(ANOTHER)?;
    let header = std::str::from_utf8(header).map_err(|_| ANOTHER)?;
    if !header.contains("'descr': '<f8'") || !header.contains("'fortran_order': False") {
        return Err(ANOTHER);
    }
    let shape = header
        .split_once("'shape': (")
        .and_then(|(_, rest)| rest.split_once(')'))
        .ok_or(ANOTHER)?
        .0;
    let shape: Result<Vec<usize>, _> = shape
        .split(',')
        .map(str::trim)
        .filter(|axis| !axis.is_empty())
        .map(str::parse)
        .collect();
    let (numbers, odd) = data.as_chunks::<8>();
    match shape {
        Ok(shape) if odd.is_empty() => Ok((shape, numbers)),
        _ => Err(ANOTHER),
    }
}
