//! Writes the records of a worked example as a data set.
//!
//! ```text
//! cargo run --release --example worked_examples -- paper-j|paper-m DIR
//! ```
//!
//! docs/worked-examples.md has what `hysteron diagnose` makes of them.

use std::error::Error;
use std::path::PathBuf;

use hysteron_host::experiment::worked;

fn main() -> Result<(), Box<dyn Error>> {
    const USAGE: &str = "usage: worked_examples paper-j|paper-m DIR";
    let mut arguments = std::env::args_os().skip(1);
    let which = arguments.next().ok_or(USAGE)?;
    let folder = arguments.next().map(PathBuf::from).ok_or(USAGE)?;
    let dataset = match which.to_str() {
        Some("paper-j") => worked::paper_j()?,
        Some("paper-m") => worked::paper_m()?,
        _ => return Err(USAGE.into()),
    };
    dataset.save(folder)?;
    Ok(())
}
