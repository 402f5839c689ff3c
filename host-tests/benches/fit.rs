//! Time of the fit of paper J's case, on the records that `py/fit_paper_j.py` fits with scipy: three
//! steady loops of 200 points, beta, the spacing and four weights free, weighted by A_p.
//!
//! ```text
//! cargo run --release --example paper_j_data -- DIR
//! HYSTERON_PAPER_J=DIR cargo bench --bench fit
//! python3 host-tests/benches/py/fit_paper_j.py DIR
//! ```

use std::path::PathBuf;

use divan::{Bencher, black_box};
use hysteron_host::dataset::{Dataset, Role};
use hysteron_host::identify::fit_spaced;

const POINTS_A_PERIOD: usize = 200;
const A_P: [f64; 3] = [1.0, 1.56, 2.0];

/// The last period of each fit record: a steady loop, as the script scores it.
fn loops() -> Dataset {
    let folder = std::env::var_os("HYSTERON_PAPER_J").map(PathBuf::from);
    let folder = folder.expect("set HYSTERON_PAPER_J to the folder that paper_j_data wrote");
    let mut dataset = Dataset::load(&folder).expect("the folder holds a data set");
    dataset.records.retain(|record| record.role == Role::Fit);
    for record in &mut dataset.records {
        let from = record.drive_v.len() - POINTS_A_PERIOD;
        record.time_s.drain(..from);
        record.drive_v.drain(..from);
        record.displacement_um.drain(..from);
    }
    dataset
}

#[divan::bench]
fn paper_j(bencher: Bencher) {
    let dataset = loops();
    bencher.bench(|| fit_spaced(black_box(&dataset), 3, true, &A_P).expect("fits"));
}

fn main() {
    let dataset = loops();
    let (model, rms) = fit_spaced(&dataset, 3, true, &A_P).expect("fits");
    let hysteresis = model.hysteresis().expect("a fitted stage has one");
    let (gain, offset) = model.output();
    let weights: Vec<f64> = hysteresis.weights.iter().map(|a| a * gain).collect();
    // Half the weighted sum of squares, as scipy counts it.
    let cost = 0.5 * rms * rms * A_P.iter().sum::<f64>() * POINTS_A_PERIOD as f64;
    println!(
        "beta {:.5e}  zeta {:.6}  weights {weights:.6?}  offset {offset:.2e}  cost {cost:.6}",
        hysteresis.beta_s, hysteresis.thresholds_v[0]
    );
    divan::main();
}
