//! What the three axes of a measured fine steering mirror say of delay and modes, once the drives that
//! moved all at once are told apart.
//!
//! ```text
//! cargo run --release --example mirror -- DATA DIR
//! ```
//!
//! DATA holds the `.npy` files (host-tests/data/README.md says where they are from). Into DIR go data sets
//! for `hysteron diagnose`: `mixed-1` to `mixed-3`, each sensor beside the drive of its own axis as
//! recorded, and `own-1` to `own-3`, what the other two drives do taken out.

mod modes;
mod recording;
mod response;
mod sets;

use std::error::Error;
use std::path::PathBuf;

use recording::AXES;
use response::Response;

/// Highest driven frequency in Hz.
const TOP_HZ: f64 = 3000.0;
/// Where the phase is taken to be straight: below the modes.
const STRAIGHT_HZ: (f64, f64) = (5.0, 400.0);
/// Where modes stand apart from each other.
const MODES_HZ: (f64, f64) = (500.0, 1500.0);

fn main() -> Result<(), Box<dyn Error>> {
    const USAGE: &str = "usage: mirror DATA DIR";
    let mut arguments = std::env::args_os().skip(1).map(PathBuf::from);
    let data = arguments.next().ok_or(USAGE)?;
    let out = arguments.next().ok_or(USAGE)?;
    for level in ["100mV", "200mV", "300mV"] {
        let fit = recording::read(&data, &format!("{level}_train"))?;
        let held_out = recording::read(&data, &format!("{level}_test"))?;
        let response = Response::separate(&fit, TOP_HZ)?;
        println!("{level}");
        let shares = response.shares(&held_out)?;
        let mut delays = Vec::new();
        for (axis, shares) in shares.iter().enumerate() {
            let (delay_s, at_zero) = modes::delay(&response, axis, STRAIGHT_HZ.0, STRAIGHT_HZ.1);
            delays.push(delay_s);
            println!(
                "  axis {}: its own drive leaves {:.0} % of the rms, all three {:.1} %, noise {:.1} %; delay {:.0} us and {:.1} degrees",
                axis + 1,
                100.0 * shares.left_by_own,
                100.0 * shares.left,
                100.0 * shares.noise,
                1e6 * delay_s,
                at_zero.to_degrees(),
            );
        }
        let guess_s = delays.iter().sum::<f64>() / delays.len() as f64;
        for mode in modes::modes(&response, MODES_HZ.0, MODES_HZ.1, guess_s) {
            println!(
                "  mode {:.1} Hz, damping {:.4}, residues aligned to {:.3}, turned by a delay of {:.0} us; fit leaves {:.1} %",
                mode.hz,
                mode.zeta,
                mode.aligned,
                1e6 * mode.delay_s,
                100.0 * mode.left,
            );
        }
        if level == "300mV" {
            for axis in 0..AXES {
                let name = |what: &str| out.join(format!("{what}-{}", axis + 1));
                sets::mixed(&fit, &held_out, axis)?.save(name("mixed"))?;
                sets::own(&response, &fit, &held_out, axis)?.save(name("own"))?;
            }
        }
    }
    Ok(())
}
