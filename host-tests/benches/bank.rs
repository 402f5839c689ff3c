//! The plain form of a play bank against its stack form, side by side: mean and worst sample.
//!
//! ```text
//! cargo bench --bench bank
//! ```
//!
//! Inputs, as envelopes in memory so that the bank alone is timed:
//!
//! - *smooth*: two tones at 10 kHz with the rate term of paper J;
//! - *noise*: white noise over the full range, no rate term;
//! - *unwinding*: swings that each capture one play less, so that every play ends in a segment of its
//!   own, then a swing that captures them all: the dearest sample that the stack can meet.
//!
//! The mean is over a run of all samples; the forms take turns, and the ratio is formed in each round.
//! The worst sample is the largest of the samples' times, each the shortest of many repetitions less
//! the shortest time of an empty measurement: what a sample costs, not what the machine did meanwhile.

mod common;

use common::{Spread, print_machine, spread, two_tone, white_noise};
use hysteron::math::Real;
use hysteron::play::{Envelope, PlainState, PlayBank, StackState};
use std::hint::black_box;
use std::time::{Duration, Instant};

const SAMPLES: usize = 4000;
const STRETCH: usize = 250;
const ROUNDS: usize = 31;
const RANGE: f64 = 40.0;

trait Form<T: Real, const N: usize>: Copy {
    fn start(bank: &PlayBank<T, N>) -> Self;
    fn step(&mut self, bank: &PlayBank<T, N>, envelope: Envelope<T>) -> T;
}

impl<T: Real, const N: usize> Form<T, N> for PlainState<T, N> {
    fn start(_: &PlayBank<T, N>) -> Self {
        Self::zero()
    }
    #[inline(always)]
    fn step(&mut self, bank: &PlayBank<T, N>, envelope: Envelope<T>) -> T {
        self.step(bank, envelope)
    }
}

impl<T: Real, const N: usize> Form<T, N> for StackState<T, N> {
    fn start(bank: &PlayBank<T, N>) -> Self {
        Self::zero(bank)
    }
    #[inline(always)]
    fn step(&mut self, bank: &PlayBank<T, N>, envelope: Envelope<T>) -> T {
        self.step(bank, envelope)
    }
}

/// Thresholds evenly over the range of the input, weights that fall with the threshold.
fn bank<T: Real, const N: usize>() -> PlayBank<T, N> {
    let thresholds: Vec<T> = (1..=N).map(|i| T::from_f64(threshold::<N>(i))).collect();
    let weights: Vec<T> = (1..=N)
        .map(|i| T::from_f64((-(i as f64) / N as f64).exp() / N as f64))
        .collect();
    PlayBank::new(&thresholds, &weights).expect("valid parameters")
}

fn threshold<const N: usize>(i: usize) -> f64 {
    RANGE * i as f64 / (N + 1) as f64
}

fn smooth<T: Real>() -> Vec<Envelope<T>> {
    let (beta, sample_time) = (8.572e-4, 1e-4);
    let input = two_tone(SAMPLES);
    let mut before = input[0];
    input
        .into_iter()
        .map(|u: f64| {
            let half_width = beta / sample_time * (u - before).abs();
            before = u;
            Envelope {
                lo: T::from_f64(u - half_width),
                hi: T::from_f64(u + half_width),
            }
        })
        .collect()
}

fn noise<T: Real>() -> Vec<Envelope<T>> {
    white_noise(SAMPLES)
        .into_iter()
        .map(|u| Envelope::closed(T::from_f64(u)))
        .collect()
}

fn unwinding<T: Real, const N: usize>() -> Vec<Envelope<T>> {
    let gap = threshold::<N>(1);
    let mut input = Vec::new();
    while input.len() < SAMPLES {
        let (mut u, mut direction) = (-3.0 * RANGE, 1.0);
        input.push(u);
        for i in (1..=N).rev() {
            // Captures the plays whose gap 2 r is below the swing: those up to `i`.
            u += direction * (2.0 * threshold::<N>(i) + gap);
            direction = -direction;
            input.push(u);
        }
    }
    input
        .into_iter()
        .map(|u| Envelope::closed(T::from_f64(u)))
        .collect()
}

#[inline(never)]
fn run<T: Real, F: Form<T, N>, const N: usize>(
    bank: &PlayBank<T, N>,
    state: &mut F,
    input: &[Envelope<T>],
    output: &mut [T],
) {
    for (&envelope, v) in input.iter().zip(output) {
        *v = state.step(bank, envelope);
    }
}

/// Nanoseconds a sample: the shortest time of each stretch of samples in a few runs. Stretches are
/// shorter than what the operating system leaves a process alone for; whole runs of a large bank
/// are not.
fn mean<T: Real, F: Form<T, N>, const N: usize>(
    bank: &PlayBank<T, N>,
    input: &[Envelope<T>],
    output: &mut [T],
) -> f64 {
    let mut shortest = vec![Duration::MAX; input.len().div_ceil(STRETCH)];
    for _ in 0..7 {
        let mut state = F::start(bank);
        let stretches = input.chunks(STRETCH).zip(output.chunks_mut(STRETCH));
        for ((input, output), shortest) in stretches.zip(&mut shortest) {
            let start = Instant::now();
            run(black_box(bank), &mut state, black_box(input), output);
            *shortest = start.elapsed().min(*shortest);
        }
    }
    shortest.iter().sum::<Duration>().as_secs_f64() * 1e9 / input.len() as f64
}

/// Nanoseconds of the dearest sample.
fn worst<T: Real, F: Form<T, N>, const N: usize>(
    bank: &PlayBank<T, N>,
    input: &[Envelope<T>],
) -> f64 {
    let mut shortest = vec![Duration::MAX; input.len()];
    let mut empty = Duration::MAX;
    for _ in 0..100 {
        let mut state = F::start(bank);
        for (&envelope, shortest) in input.iter().zip(&mut shortest) {
            let start = Instant::now();
            black_box(state.step(bank, black_box(envelope)));
            *shortest = start.elapsed().min(*shortest);
        }
        for _ in 0..input.len() {
            let start = Instant::now();
            black_box(());
            empty = start.elapsed().min(empty);
        }
    }
    // The first sample meets every play in a segment of its own, which no other sample does.
    let largest = shortest.iter().skip(1).max();
    largest.map_or(0.0, |t| t.saturating_sub(empty).as_secs_f64() * 1e9)
}

/// Mean and largest number of segments after a sample.
fn depth<T: Real, const N: usize>(bank: &PlayBank<T, N>, input: &[Envelope<T>]) -> (f64, usize) {
    let mut state = StackState::zero(bank);
    let depths: Vec<usize> = input
        .iter()
        .map(|&envelope| {
            state.step(bank, envelope);
            state.depth()
        })
        .skip(1)
        .collect();
    let sum: usize = depths.iter().sum();
    (
        sum as f64 / depths.len() as f64,
        depths.into_iter().max().unwrap_or(0),
    )
}

/// Nanoseconds in the mean of plain and stack, and how many times faster the stack is.
fn compare_means<T: Real, const N: usize>(
    bank: &PlayBank<T, N>,
    input: &[Envelope<T>],
) -> (Spread, Spread, Spread) {
    let (mut plain_output, mut stack_output) =
        (vec![T::ZERO; input.len()], vec![T::ZERO; input.len()]);
    let (mut plain, mut stack) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        plain.push(mean::<T, PlainState<T, N>, N>(
            bank,
            input,
            &mut plain_output,
        ));
        stack.push(mean::<T, StackState<T, N>, N>(
            bank,
            input,
            &mut stack_output,
        ));
    }
    let tolerance = 1e3 * RANGE * T::EPSILON.to_f64();
    for (a, b) in plain_output.iter().zip(&stack_output) {
        let difference = (*a - *b).abs().to_f64();
        assert!(difference <= tolerance, "plain {a:?}, stack {b:?}");
    }
    let ratio = spread(plain.iter().zip(&stack).map(|(plain, stack)| plain / stack));
    (spread(plain), spread(stack), ratio)
}

fn mean_and_worst<T: Real, const N: usize>() {
    let bank = bank::<T, N>();
    let inputs = [
        ("smooth", smooth()),
        ("noise", noise()),
        ("unwinding", unwinding::<T, N>()),
    ];
    for (name, input) in &inputs {
        let (plain, stack, ratio) = compare_means(&bank, input);
        let plain_worst = worst::<T, PlainState<T, N>, N>(&bank, input);
        let stack_worst = worst::<T, StackState<T, N>, N>(&bank, input);
        let (mean_depth, largest_depth) = depth(&bank, input);
        println!(
            "| {} | {N} | {name} | {:.1} | {:.1} | {:.2} | **{:.2}** | {:.2} | {plain_worst:.0} \
             | {stack_worst:.0} | {mean_depth:.1} | {largest_depth} |",
            std::any::type_name::<T>(),
            plain.median,
            stack.median,
            ratio.min,
            ratio.median,
            ratio.max,
        );
    }
}

fn crossover<const N: usize>() {
    fn ratio<T: Real, const N: usize>(input: &[Envelope<T>]) -> f64 {
        compare_means(&bank::<T, N>(), input).2.median
    }
    println!(
        "| {N} | {:.2} | {:.2} | {:.2} | {:.2} |",
        ratio::<f32, N>(&smooth()),
        ratio::<f64, N>(&smooth()),
        ratio::<f32, N>(&noise()),
        ratio::<f64, N>(&noise()),
    );
}

fn main() {
    print_machine(&["rustc"]);
    println!(
        "\nTimes in ns a sample; plain over stack (above 1: the stack is faster), {ROUNDS} rounds"
    );
    println!("in turns; segments of the stack.\n");
    println!(
        "| scalar | N | input | plain mean | stack mean | min | median | max | plain worst \
         | stack worst | segments mean | most |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|");
    mean_and_worst::<f32, 3>();
    mean_and_worst::<f32, 10>();
    mean_and_worst::<f32, 100>();
    mean_and_worst::<f32, 1000>();
    mean_and_worst::<f64, 3>();
    mean_and_worst::<f64, 10>();
    mean_and_worst::<f64, 100>();
    mean_and_worst::<f64, 1000>();

    println!("\nFrom which N on the stack is the faster: plain over stack in the mean.\n");
    println!("| N | smooth f32 | smooth f64 | noise f32 | noise f64 |");
    println!("|---|---|---|---|---|");
    crossover::<4>();
    crossover::<6>();
    crossover::<8>();
    crossover::<12>();
    crossover::<16>();
    crossover::<20>();
    crossover::<24>();
    crossover::<32>();
    crossover::<48>();
}
