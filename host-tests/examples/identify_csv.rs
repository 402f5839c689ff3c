//! From a CSV file to a model and a compensated drive, in your own program:
//! `identify_csv FILE`, with columns for time, drive and displacement (docs/dataset.md).

use std::path::PathBuf;

use hysteron_host::dataset::Dataset;
use hysteron_host::error::Error;
use hysteron_host::identify::{Options, identify};
use hysteron_host::stage;

fn main() -> Result<(), Error> {
    let file = std::env::args_os().nth(1).map(PathBuf::from);
    let file = file.ok_or_else(|| Error::request("name a CSV file".to_owned()))?;
    // A lone file is split: the first 60 % to fit, 20 % to select, 20 % to report.
    let dataset = Dataset::load(&file)?;
    let found = identify(&dataset, &Options::default(), &|step| eprintln!("{step}"))?;
    println!("{}", found.describe_structure());
    for (role, rms) in [
        ("fit", found.rms.fit),
        ("select", found.rms.select),
        ("report", found.rms.report),
    ] {
        if let Some(rms) = rms {
            println!("{role:<8} {rms:.4} um rms");
        }
    }
    // A move of a fifth of the travel along a raised cosine, 10,000 samples a second.
    let record = &dataset.records[0];
    let bounds = |(low, high): (f64, f64), &y: &f64| (low.min(y), high.max(y));
    let (low, high) = record
        .displacement_um
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), bounds);
    let reference_um: Vec<f64> = (0..=1000)
        .map(|k| {
            let share = 0.5 - 0.5 * (std::f64::consts::PI * f64::from(k) / 1000.0).cos();
            low + (0.4 + 0.2 * share) * (high - low)
        })
        .collect();
    let drive_v = stage::drive(&found.model, 1e-4, &reference_um)?;
    println!("{:.3} V to {:.3} V", drive_v[0], drive_v[1000]);
    Ok(())
}
