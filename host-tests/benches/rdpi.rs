//! The inverse of the rate-dependent Prandtl-Ishlinskii model: the step of the core against a plain
//! C loop of the same inverse, side by side.
//!
//! ```text
//! RUSTFLAGS="-C target-cpu=native" cargo bench --bench rdpi
//! ```
//!
//! gcc compiles `c/rdpi.c` with `-O3 -march=native`, so the Rust side needs the native target, too.
//! Both sides read samples from memory and write results to memory; in each round both run a number
//! of times and count their fastest run. The sides take turns. The plain form does what the C does
//! and must agree with it bit for bit; where the core takes the stack form, that is timed, too, and
//! must agree to rounding. Of several builds of the C program the one that looks best beside Rust
//! counts. On a busy machine `taskset -c 0` before the command keeps both sides on one core.

mod common;

use common::{print_machine, spread, two_tone};
use hysteron::hysteresis::{Parameters, RateDependentPi, State};
use hysteron::math::Real;
use hysteron::play::{PlainState, PlayState, STACK_FROM};
use std::hint::black_box;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

const SAMPLES: usize = 4000;
const REPETITIONS: usize = 50;
const ROUNDS: usize = 101;

/// Further options for gcc, of which now one, now the other set gives the fastest code. None of them
/// changes a result.
const BUILDS: [&[&str]; 4] = [
    &[],
    &["-DUNROLL"],
    &["-DUNROLL", "-fno-tree-vectorize"],
    &["-DUNROLL", "-fno-trapping-math"],
];

/// A scalar in both languages.
trait Scalar: Real {
    const C_NAME: &'static str;
    fn bytes(values: &[Self]) -> Vec<u8>;
}

macro_rules! scalar {
    ($float:ident, $c_name:literal) => {
        impl Scalar for $float {
            const C_NAME: &'static str = $c_name;
            fn bytes(values: &[Self]) -> Vec<u8> {
                values.iter().flat_map(|v| v.to_ne_bytes()).collect()
            }
        }
    };
}

scalar!(f32, "float");
scalar!(f64, "double");

/// The stage of paper J for n = 3; its thresholds and total weight spread over more plays else.
fn inverse<T: Scalar, const N: usize>() -> RateDependentPi<T, N> {
    let mut weights = vec![T::from_f64(0.7236)];
    let mut thresholds = Vec::new();
    for i in 0..N {
        let weight = [0.2906, 0.0416, 0.1512][3 * i / N] * 3.0 / N as f64;
        weights.push(T::from_f64(weight));
        thresholds.push(T::from_f64(9.715 * 3.0 / N as f64 * (i + 1) as f64));
    }
    Parameters {
        weights: &weights,
        thresholds: &thresholds,
        beta: T::from_f64(8.572e-4),
    }
    .build::<N>(T::from_f64(1e-4))
    .and_then(|model| model.inverse())
    .expect("valid parameters")
}

fn plain<T: Scalar, const N: usize>(_: &RateDependentPi<T, N>, first: T) -> State<T, N> {
    State::new(PlayState::Plain(PlainState::zero()), first)
}

/// Steps through the input from a state whose form the compiler knows where the core does.
#[inline(never)]
fn run<T: Scalar, const N: usize>(
    inverse: &RateDependentPi<T, N>,
    start: impl Fn(&RateDependentPi<T, N>, T) -> State<T, N>,
    input: &[T],
    output: &mut [T],
) {
    let Some(&first) = input.first() else { return };
    let mut state = start(inverse, first);
    for (&u, v) in input.iter().zip(output) {
        *v = inverse.step(&mut state, u);
    }
}

/// Nanoseconds a sample in the fastest of the repetitions.
fn time<T: Scalar, const N: usize>(
    inverse: &RateDependentPi<T, N>,
    start: impl Fn(&RateDependentPi<T, N>, T) -> State<T, N> + Copy,
    input: &[T],
    output: &mut [T],
) -> f64 {
    (0..REPETITIONS)
        .map(|_| {
            let begin = Instant::now();
            run(
                black_box(inverse),
                start,
                black_box(input),
                black_box(output),
            );
            begin.elapsed().as_secs_f64() * 1e9 / input.len() as f64
        })
        .fold(f64::INFINITY, f64::min)
}

/// A build of the C program that waits for its turns.
struct CLoop {
    process: Child,
    turns: ChildStdin,
    times: BufReader<ChildStdout>,
}

impl CLoop {
    fn start<T: Scalar, const N: usize>(directory: &Path, build: &[&str]) -> Self {
        let source = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/c/rdpi.c");
        let compiled = Command::new("gcc")
            .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-O3"])
            .args(["-march=native", "-ffp-contract=off"])
            .arg(format!("-DREAL={}", T::C_NAME))
            .arg(format!("-DN={N}"))
            .args(build)
            .arg(source)
            .arg("-o")
            .arg(directory.join("rdpi"))
            .status()
            .expect("gcc is needed for this comparison");
        assert!(compiled.success(), "gcc failed");
        let mut process = Command::new(directory.join("rdpi"))
            .args(["parameters", "input", "output"].map(|name| directory.join(name)))
            .arg(REPETITIONS.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the compiled program starts");
        let turns = process.stdin.take().expect("piped");
        let times = BufReader::new(process.stdout.take().expect("piped"));
        Self {
            process,
            turns,
            times,
        }
    }

    /// Nanoseconds a sample in the fastest of the repetitions.
    fn time(&mut self) -> f64 {
        self.turns.write_all(b"\n").expect("the program waits");
        let mut line = String::new();
        self.times.read_line(&mut line).expect("the program prints");
        line.trim().parse().expect("nanoseconds")
    }

    /// Ends the program and hands out what it wrote.
    fn finish(self, directory: &Path) -> Vec<u8> {
        let Self {
            mut process, turns, ..
        } = self;
        drop(turns);
        assert!(process.wait().expect("the program ends").success());
        std::fs::read(directory.join("output")).expect("the program wrote its output")
    }
}

fn compare<T: Scalar, const N: usize>() {
    let input: Vec<T> = two_tone(SAMPLES).into_iter().map(T::from_f64).collect();
    let mut output = vec![T::ZERO; SAMPLES];
    let inverse = inverse::<T, N>();
    let parameters = [
        &[inverse.weight_0(), inverse.beta() / inverse.sample_time()][..],
        inverse.bank().thresholds(),
        inverse.bank().weights(),
    ]
    .concat();

    let directories: Vec<_> = BUILDS
        .iter()
        .map(|_| tempfile::tempdir().expect("a temporary directory"))
        .collect();
    let mut builds: Vec<CLoop> = BUILDS
        .iter()
        .zip(&directories)
        .map(|(build, directory)| {
            let directory = directory.path();
            std::fs::write(directory.join("parameters"), T::bytes(&parameters)).expect("written");
            std::fs::write(directory.join("input"), T::bytes(&input)).expect("written");
            CLoop::start::<T, N>(directory, build)
        })
        .collect();

    // (C, plain, as the core takes it) in nanoseconds, a list of rounds for each build.
    let mut used_output = output.clone();
    let mut times = vec![Vec::new(); BUILDS.len()];
    for _ in 0..ROUNDS {
        for (build, times) in builds.iter_mut().zip(&mut times) {
            times.push((
                build.time(),
                time(&inverse, plain, &input, &mut output),
                time(&inverse, RateDependentPi::start, &input, &mut used_output),
            ));
        }
    }
    for (build, directory) in builds.into_iter().zip(&directories) {
        assert!(
            build.finish(directory.path()) == T::bytes(&output),
            "the outputs of C and Rust differ"
        );
    }
    let tolerance = 1e3 * 40.0 * T::EPSILON.to_f64();
    for (a, b) in output.iter().zip(&used_output) {
        assert!((*a - *b).abs().to_f64() <= tolerance, "{a:?} and {b:?}");
    }

    let row = |form: &str, rust: fn(&(f64, f64, f64)) -> f64| {
        let (ratio, times, build) = times
            .iter()
            .zip(BUILDS)
            .map(|(times, build)| (spread(times.iter().map(|t| t.0 / rust(t))), times, build))
            .min_by(|(a, ..), (b, ..)| a.median.total_cmp(&b.median))
            .expect("there are builds");
        println!(
            "| {} | {N} | {form} | {:.2} | {:.2} | {:.2} | **{:.2}** | {:.2} | {} |",
            std::any::type_name::<T>(),
            spread(times.iter().map(rust)).median,
            spread(times.iter().map(|t| t.0)).median,
            ratio.min,
            ratio.median,
            ratio.max,
            match build {
                [] => "plain".to_owned(),
                options => options.join(" "),
            }
        );
    };
    row("plain", |t| t.1);
    if N >= STACK_FROM {
        row("stack", |t| t.2);
    }
}

fn main() {
    print_machine(&["rustc", "gcc"]);
    if !cfg!(target_feature = "avx") && cfg!(target_arch = "x86_64") {
        println!("Rust side not built for this processor: set RUSTFLAGS=\"-C target-cpu=native\"");
    }
    println!("\nSpeed of Rust over C (above 1: Rust is faster), {ROUNDS} rounds in turns:\n");
    println!("| scalar | n | form | Rust ns | C ns | min | median | max | best C build |");
    println!("|---|---|---|---|---|---|---|---|---|");
    compare::<f32, 3>();
    compare::<f32, 10>();
    compare::<f64, 3>();
    compare::<f64, 10>();
}
