//! Samples a second through a whole compensator, asymmetry map included: for a look before and after
//! a change.
//!
//! ```text
//! cargo bench --bench step
//! ```

mod common;

use common::two_tone;
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use hysteron::effect::asymmetry::{Asymmetry, Side};
use hysteron::hysteresis::Parameters;
use hysteron::math::Real;
use hysteron::model::Model;

const SAMPLES: usize = 4000;

#[divan::bench(types = [f32, f64], consts = [3, 10, 100])]
fn compensator<T: Real, const N: usize>(bencher: Bencher) {
    let to = |values: &[f64]| -> Vec<T> { values.iter().map(|&v| T::from_f64(v)).collect() };
    let thresholds: Vec<f64> = (1..=N).map(|i| 30.0 * i as f64 / N as f64).collect();
    let mut weights = vec![0.5 / N as f64; N + 1];
    weights[0] = 0.7;
    let hysteresis = Parameters {
        weights: &to(&weights),
        thresholds: &to(&thresholds),
        beta: T::from_f64(8.572e-4),
    }
    .build::<N>(T::from_f64(1e-4))
    .expect("valid parameters");
    let (slopes, zones) = (to(&[1.0, -0.1, 0.05]), to(&[10.0, 20.0]));
    let side = Side {
        slopes: &slopes,
        thresholds: &zones,
    };
    let asymmetry = Asymmetry::new(side, side).expect("valid parameters");
    let compensator = Model::<T, N, 2>::new(hysteresis, Some(asymmetry), T::ONE, T::ZERO)
        .and_then(|model| model.compensator())
        .expect("valid parameters");
    let reference = to(&two_tone(SAMPLES));
    let mut drive = vec![T::ZERO; SAMPLES];
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut state = compensator.start(reference[0]).expect("finite");
        for (&y, u) in black_box(&reference).iter().zip(&mut drive) {
            *u = compensator.step(&mut state, y).unwrap_or(T::ZERO);
        }
        black_box(&mut drive);
    });
}

fn main() {
    divan::main();
}
