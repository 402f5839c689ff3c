//! scratch
use hysteron_host::dataset::Dataset;
use hysteron_host::discover::{Options, diagnose};
use std::time::Instant;
fn main() {
    for path in std::env::args().skip(1) {
        let dataset = Dataset::load(&path).unwrap();
        let t0 = Instant::now();
        let d = diagnose(&dataset, &Options::default(), &|_| ()).unwrap();
        println!(
            "{path}: {:?} {:?} also {:?} left {:.3?} noise {:.4} base {:.4?} ext {:.4?} closed {:.3?} t {:.2}",
            d.verdict,
            d.effects
                .iter()
                .map(|e| e.effect.name())
                .collect::<Vec<_>>(),
            d.effects
                .iter()
                .map(|e| e.also_possible.iter().map(|e| e.name()).collect::<Vec<_>>())
                .collect::<Vec<_>>(),
            d.effects.iter().map(|e| e.left_over).collect::<Vec<_>>(),
            d.noise.0,
            d.baseline.select,
            d.extended.select,
            d.closed(),
            t0.elapsed().as_secs_f64()
        );
    }
}
