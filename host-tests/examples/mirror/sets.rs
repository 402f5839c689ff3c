//! One axis of the mirror as a data set: its drive and its sensor.

use std::error::Error;

use hysteron_host::dataset::{Dataset, LengthUnit, Record, Role, Zero};

use super::recording::{RATE_HZ, Realisation};
use super::response::Response;

/// One sensor beside the drive of its own axis, everything else left in.
///
/// # Errors
/// Too few realisations.
pub fn mixed(
    fit: &[Realisation],
    held_out: &[Realisation],
    axis: usize,
) -> Result<Dataset, Box<dyn Error>> {
    set("mirror, mixed", fit, held_out, axis, 1.0, |record| {
        Ok(record.displacement_um[axis].clone())
    })
}

/// The same with what the other two drives do taken out. The drive's sign is that of the response at
/// the lowest line, so that drive and displacement rise together.
///
/// # Errors
/// Too few realisations, or of another period than the response.
pub fn own(
    response: &Response,
    fit: &[Realisation],
    held_out: &[Realisation],
    axis: usize,
) -> Result<Dataset, Box<dyn Error>> {
    let sign = sign(response, axis)?;
    set("mirror, own drive", fit, held_out, axis, sign, |record| {
        response.of_own_drive(record, axis)
    })
}

fn sign(response: &Response, axis: usize) -> Result<f64, Box<dyn Error>> {
    let lowest = response.lines.get(1).ok_or("no line is driven")?;
    Ok(lowest[(axis, axis)].re.signum())
}

fn set(
    name: &str,
    fit: &[Realisation],
    held_out: &[Realisation],
    axis: usize,
    sign: f64,
    displacement: impl Fn(&Realisation) -> Result<Vec<Vec<f64>>, Box<dyn Error>>,
) -> Result<Dataset, Box<dyn Error>> {
    const REST_S: f64 = 1.0;
    let ([first, second, third, ..], [last, ..]) = (fit, held_out) else {
        return Err("three realisations to fit and choose and one to report are needed".into());
    };
    let mut records = Vec::new();
    let mut start_s = 0.0;
    for (name, role, one) in [
        ("fit-1", Role::Fit, first),
        ("fit-2", Role::Fit, second),
        ("select", Role::Select, third),
        ("report", Role::Report, last),
    ] {
        let drive_v: Vec<f64> = one.drive_v[axis]
            .concat()
            .iter()
            .map(|u| sign * u)
            .collect();
        let time_s: Vec<f64> = (0..drive_v.len())
            .map(|k| start_s + k as f64 / RATE_HZ)
            .collect();
        let end_s = start_s + drive_v.len() as f64 / RATE_HZ;
        records.push(Record {
            name: name.to_owned(),
            role,
            start_s,
            sample_time_s: 1.0 / RATE_HZ,
            time_s,
            drive_v,
            displacement_um: displacement(one)?.concat(),
            continues: None,
        });
        start_s = end_s + REST_S;
    }
    Ok(Dataset {
        name: name.to_owned(),
        output_unit: LengthUnit::Micrometre,
        zero: Zero::PerRecord,
        input_zero: Zero::Shared,
        records,
    })
}
