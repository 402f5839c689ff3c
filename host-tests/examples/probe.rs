//! scratch
use hysteron_host::dataset::Dataset;
use hysteron_host::discover::{Options, diagnose};
use std::time::Instant;
fn main() {
    for path in std::env::args().skip(1) {
        let dataset = Dataset::load(&path).unwrap();
        let t0 = Instant::now();
        let d = diagnose(&dataset, &Options::default(), &|_| ()).unwrap();
        let names =
            |e: &[hysteron_host::identify::Effect]| e.iter().map(|e| e.name()).collect::<Vec<_>>();
        if std::env::var("SCR").is_ok() {
            println!(
                "  base fit {:.4} beta {:.2e} screened {:.4?}",
                d.baseline.fit.unwrap(),
                d.baseline_model.hysteresis().unwrap().beta_s,
                d.screened
                    .iter()
                    .map(|(e, r)| (e.name(), *r))
                    .collect::<Vec<_>>()
            );
        }
        if std::env::var("REC").is_ok() {
            for (a, b) in d.before.records.iter().zip(&d.after.records) {
                let rms =
                    |v: &[f64]| (v.iter().map(|x| x * x).sum::<f64>() / v.len() as f64).sqrt();
                let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
                println!(
                    "  {:20} {:?} before {:.4} (mean {:.4}) after {:.4} (mean {:.4})",
                    a.name,
                    a.role,
                    rms(&a.residual_um),
                    mean(&a.residual_um),
                    rms(&b.residual_um),
                    mean(&b.residual_um)
                );
            }
        }
        let found: Vec<_> = d.effects.iter().map(|e| e.effect).collect();
        println!(
            "{path}: {:?} {:?} also {:?} left {:.3?} noise {:.4} base {:.4?} ext {:.4?} closed {:.3?} t {:.2}",
            d.verdict,
            names(&found),
            d.effects
                .iter()
                .map(|e| names(&e.also_possible))
                .collect::<Vec<_>>(),
            d.effects.iter().map(|e| e.left_over).collect::<Vec<_>>(),
            d.noise.0,
            d.baseline.select.unwrap(),
            d.extended.select.unwrap(),
            d.closed(),
            t0.elapsed().as_secs_f64()
        );
    }
}
