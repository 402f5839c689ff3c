//! Writes the identification case of paper J as a data set: the loops that the fit of hysteron and
//! `benches/py/fit_paper_j.py` both read.
//!
//! ```text
//! cargo run --release --example paper_j_data -- DIR
//! ```
//!
//! 40 V sines of 1, 50 and 100 Hz with 200 points a period through the corrected model of paper J,
//! with 0.05 um of seeded white sensor noise. A record holds two periods from rest: one to settle,
//! one to fit. Each role has records of its own noise.

use hysteron::hysteresis::Parameters;
use std::error::Error;
use std::f64::consts::TAU;
use std::fs;
use std::path::PathBuf;

const POINTS_A_PERIOD: usize = 200;
const PERIODS: usize = 2;
const NOISE_UM: f64 = 0.05;

/// The corrected constants of paper J.
const STAGE: Parameters<'static, f64> = Parameters {
    weights: &[0.7236, 0.2906, 0.0416, 0.1512],
    thresholds: &[9.715, 2.0 * 9.715, 3.0 * 9.715],
    beta: 8.572e-4,
};

/// Standard normal noise: SplitMix64 and the Box-Muller transform.
struct Noise(u64);

impl Noise {
    /// Uniform in (0, 1].
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^= bits >> 31;
        ((bits >> 11) + 1) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let directory = std::env::args_os().nth(1).map(PathBuf::from);
    let directory = directory.ok_or("usage: paper_j_data DIR")?;
    fs::create_dir_all(&directory)?;
    let mut noise = Noise(1);
    let mut toml = String::from(
        "name = \"paper J, identification\"\n\n[signals]\n\
         time   = { column = \"time_s\", unit = \"s\" }\n\
         input  = { column = \"drive_v\", unit = \"V\" }\n\
         output = { column = \"displacement_um\", unit = \"um\" }\n",
    );
    for role in ["fit", "select", "report"] {
        for hz in [1.0, 50.0, 100.0] {
            let file = format!("{role}_{hz}hz.csv");
            let sample_time = 1.0 / (hz * POINTS_A_PERIOD as f64);
            let model = STAGE.build::<3>(sample_time)?;
            let mut state = model.start(0.0);
            let mut csv = csv::Writer::from_path(directory.join(&file))?;
            csv.write_record(["time_s", "drive_v", "displacement_um"])?;
            for k in 0..PERIODS * POINTS_A_PERIOD {
                let drive = 40.0 * (TAU * k as f64 / POINTS_A_PERIOD as f64).sin();
                let displacement = model.step(&mut state, drive) + NOISE_UM * noise.normal();
                let row = [k as f64 * sample_time, drive, displacement];
                csv.write_record(row.map(|value| value.to_string()))?;
            }
            csv.flush()?;
            toml += &format!("\n[[record]]\nfile = \"{file}\"\nrole = \"{role}\"\n");
        }
    }
    fs::write(directory.join("dataset.toml"), toml)?;
    Ok(())
}
