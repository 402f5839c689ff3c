//! scratch
use hysteron_host::dataset::{Dataset, Role};
use hysteron_host::discover::{baseline, search};
use hysteron_host::identify::joint::JointFit;
use hysteron_host::identify::run::Runs;
use std::time::Instant;
fn main() {
    for path in std::env::args().skip(1) {
        let dataset = Dataset::load(&path).unwrap();
        let t0 = Instant::now();
        let mut runs = Runs::new(&dataset).unwrap();
        let noise = hysteron_host::identify::noise::floor(&runs.runs);
        let base = baseline::saturate(&mut runs, &Default::default(), if std::env::var("SESSION").is_ok() {baseline::Histories::Session} else {baseline::Histories::Each}).unwrap();
        let fit = JointFit::new(&runs, base.between);
        let sel = fit.rms(&base.joint.core, &base.joint.terms, Role::Select).unwrap();
        println!("{path}\n noise {noise:?} baseline fit {:.5} select {sel:.5} plays {} beta {:.3e} {:?} span {:.1} samples {} t {:?}", base.joint.rms, base.joint.core.thresholds.len(), base.joint.core.beta, base.between, runs.frequency_span, runs.runs.iter().map(|r|r.drive.len()).sum::<usize>(), t0.elapsed());
        if std::env::var("REC").is_ok() {
            let pred = fit.predicted(&base.joint.core, &base.joint.terms).unwrap();
            let off = hysteron_host::identify::score::offsets(&runs, &pred);
            for (i, r) in runs.runs.iter().enumerate() {
                let sp = &r.spans[0];
                let (mut s, mut m) = (0.0, 0.0);
                for k in sp.samples.clone() { let e = r.displacement[k]-pred[i][k]-off[i]; s += e*e; m += e; }
                let n = sp.samples.len() as f64;
                println!("   {:22} {:?} h {:.2e} n {} left {} rms {:.5} mean {:.5} start {}", dataset.records[sp.record].name, sp.role, r.sample_time_s, n, r.left_out, (s/n).sqrt(), m/n, r.start.describe());
            }
            println!("thresholds {:.3?} weights {:.4?}", base.joint.core.thresholds, base.joint.core.weights);
            continue;
        }
        let c = search::Candidate::new(&fit, base.joint, vec![]).unwrap();
        let t0 = Instant::now();
        let found = search::expand(&fit, &c, &search::possible(&fit, &c)).unwrap();
        println!(" expand {:?}", t0.elapsed());
        for f in &found {
            let last = f.joint.terms.iter().last();
            println!("  {:16} fit {:.5} select {:.5} {:?}", f.order.last().unwrap().name(), f.joint.rms, f.select, f.joint.terms.iter().map(|t| (t.effect.name(), t.numbers.iter().map(|x| (x*1e4).round()/1e4).collect::<Vec<_>>())).collect::<Vec<_>>());
            let _ = last;
        }
        if std::env::var("AGAIN").is_ok() {
            let mut runs2 = runs.clone();
            baseline::choose_starts(&mut runs2, base.between, &found[0].joint, baseline::Histories::Each).unwrap();
            let fit = JointFit::new(&runs2, base.between);
            let found = search::expand(&fit, &c, &found.iter().take(4).map(|f| *f.order.last().unwrap()).collect::<Vec<_>>()).unwrap();
            for f in &found { println!("  again {:16} fit {:.5} select {:.5}", f.order.last().unwrap().name(), f.joint.rms, f.select); }
        }
        if std::env::var("TWO").is_ok() {
            let best = &found[0];
            let found = search::expand(&fit, best, &search::possible(&fit, best)).unwrap();
            for f in &found { println!("    +{:16} fit {:.5} select {:.5}", f.order.last().unwrap().name(), f.joint.rms, f.select); }
        }
    }
}
