//! What the benchmarks on the target run, in the emulator and on a board alike: an inverse on paper
//! J's references and on an adverse one, a whole sample, and the sines there are to choose from.
//!
//! The clock is the caller's: instructions in the emulator, cycles on a board.

use core::f64::consts::TAU;
use core::hint::black_box;
use core::sync::atomic::{Ordering, compiler_fence};

use heapless::spsc::Queue;
use hysteron::control::{Control, Output, Path};
use hysteron::dac;
use hysteron::dim::Law;
use hysteron::hysteresis::modified_play::Harmonics;
use hysteron::hysteresis::preview::{PlantRate, PreviewInverse, PreviewSettings};
use hysteron::hysteresis::{Parameters, RateDependentPi, State};
use hysteron::link::{Command, FRAME_LEN, Request, Server, encode};
use hysteron::play::{PlainState, PlayState, StackState};
use hysteron::record::{
    ChainRecord, Effect, Inverse, ModelRecord, ModifiedPlayRecord, Preview, WINDOW,
};
use hysteron::reference::{Reference, STREAM_LEN, Tone, Waveform};
use hysteron::settings::Settings;
use hysteron::wiring::Memory;
use micromath::F32Ext;

/// Samples of each reference: one second.
const SAMPLES: u32 = 10_000;
/// Samples a second.
pub const RATE: f32 = 10_000.0;
/// Rate coefficient of paper J's stage, s.
const BETA: f32 = 8.572e-4;

/// What a clock counted.
#[derive(Clone, Copy, Default)]
pub struct Count {
    samples: u32,
    sum: u64,
    squares: u64,
    /// Most in one sample.
    pub worst: u32,
}

impl Count {
    fn add(&mut self, counted: u32) {
        self.samples += 1;
        self.sum += u64::from(counted);
        self.squares += u64::from(counted) * u64::from(counted);
        self.worst = self.worst.max(counted);
    }

    /// Of a sample.
    pub fn mean(self) -> f32 {
        self.sum as f32 / self.samples as f32
    }

    /// Standard deviation, for display: micromath's root is off by some 5 %, which is enough for it.
    pub fn spread(self) -> f32 {
        let samples = u64::from(self.samples);
        let scatter = samples * self.squares - self.sum * self.sum;
        F32Ext::sqrt(scatter as f32) / self.samples as f32
    }
}

/// What the clock counts between two readings with nothing between them.
fn overhead(now: impl Fn() -> u32) -> u32 {
    let begin = now();
    now().wrapping_sub(begin)
}

fn tone(amplitude: f32, frequency_hz: f32) -> Tone {
    Tone {
        amplitude,
        frequency_hz,
    }
}

/// Paper J's references in the unit of the inverse's input, 29 being 40 V of drive times a_0.
fn references() -> [Waveform; 7] {
    let tones = |first, second| Waveform::Tones {
        offset: 0.0,
        tones: [first, second],
    };
    let sine = |frequency| tones(tone(29.0, frequency), tone(0.0, 0.0));
    let major_and_minor = |f: f32| tones(tone(13.5, f), tone(15.5, 3.0 * f));
    [
        sine(1.0),
        sine(10.0),
        sine(50.0),
        sine(100.0),
        Waveform::Triangle {
            offset: 0.0,
            tone: tone(29.0, 50.0),
        },
        major_and_minor(10.0),
        major_and_minor(60.0),
    ]
}

/// Oscillations that die away and leave a segment of the stack for each play, and at their end a jump
/// that merges all of them in one sample. Each value comes twice: at the second the rate is zero and
/// the envelope closed.
fn unwinding() -> impl Iterator<Item = f32> {
    [0.8, 0.85, 0.9, 0.93, 0.95, 0.97, 0.99, 0.995]
        .into_iter()
        .flat_map(|decay| {
            (0..300).scan(45.0, move |next, _| {
                let now = *next;
                *next = now * -decay;
                Some(now)
            })
        })
        .flat_map(|value| [value; 2])
}

/// Thresholds over the range of the references; weights that fall by e over the plays and sum up to
/// 0.4834, that of the published stage.
fn parameters(plays: usize) -> ([f32; 100], [f32; 101]) {
    let (mut thresholds, mut weights) = ([0.0; 100], [0.0; 101]);
    let fraction = |i: usize| i as f32 / plays as f32;
    let total: f32 = (0..plays).map(|i| libm::expf(-fraction(i))).sum();
    weights[0] = 0.7236;
    for i in 0..plays {
        thresholds[i] = 38.86 * (i + 1) as f32 / (plays + 1) as f32;
        weights[i + 1] = 0.4834 * libm::expf(-fraction(i)) / total;
    }
    (thresholds, weights)
}

fn model<const N: usize>(plays: usize) -> RateDependentPi<f32, N> {
    let (thresholds, weights) = parameters(plays);
    Parameters {
        weights: &weights[..=plays],
        thresholds: &thresholds[..plays],
        beta: BETA,
    }
    .build::<N>(1.0 / RATE)
    .expect("the parameters are valid")
}

/// Another implementation of the same inverse.
pub trait Rival<const N: usize> {
    /// One at rest.
    fn new(inverse: &RateDependentPi<f32, N>) -> Self;

    /// The output for the next input; `None` where there is no rival.
    fn step(&mut self, v: f32) -> Option<f32>;
}

/// No other implementation.
pub struct Nobody;

impl<const N: usize> Rival<N> for Nobody {
    fn new(_: &RateDependentPi<f32, N>) -> Self {
        Self
    }

    #[inline(always)]
    fn step(&mut self, _: f32) -> Option<f32> {
        None
    }
}

/// Results of an inverse.
#[derive(Clone, Copy, Default)]
pub struct Row {
    /// Plays.
    pub plays: usize,
    /// Plays that there is room for.
    pub capacity: usize,
    /// The plain form on the references.
    pub plain: Count,
    /// The stack form.
    pub stack: Count,
    /// The rival, if any.
    pub rival: Count,
    /// Whether the core takes the stack form.
    pub takes_stack: bool,
    /// Most of a sample of the stack form on the adverse input.
    pub unwinding: u32,
    /// Largest difference between the outputs.
    pub difference: f32,
}

/// What the clock counts for a step that is part of a larger function, as in the sample task: the
/// sample comes from memory and the output goes there. The larger function is this one.
#[inline(never)]
fn count_step<const N: usize>(
    now: impl Fn() -> u32,
    inverse: &RateDependentPi<f32, N>,
    state: &mut State<f32, N>,
    sample: &f32,
    output: &mut f32,
) -> u32 {
    let begin = now();
    compiler_fence(Ordering::SeqCst);
    *output = inverse.step(state, *sample);
    compiler_fence(Ordering::SeqCst);
    now().wrapping_sub(begin)
}

/// All forms on the same samples, from rest.
fn race<const N: usize, R: Rival<N>>(
    inverse: &RateDependentPi<f32, N>,
    row: &mut Row,
    now: impl Fn() -> u32 + Copy,
    samples: impl Iterator<Item = f32>,
) {
    let empty = overhead(now);
    let mut plain = State::new(PlayState::Plain(PlainState::zero()), 0.0);
    let mut stack = State::new(PlayState::Stack(StackState::zero(inverse.bank())), 0.0);
    let mut rival = R::new(inverse);
    let (mut first, mut second) = (0.0, 0.0);
    for v in samples {
        let counted = count_step(now, inverse, &mut plain, black_box(&v), &mut first);
        row.plain.add(counted - empty);
        let counted = count_step(now, inverse, &mut stack, black_box(&v), &mut second);
        row.stack.add(counted - empty);
        let (first, second) = (black_box(first), black_box(second));
        row.difference = row.difference.max((first - second).abs());
        let v = black_box(v);
        let begin = now();
        let third = rival.step(v);
        let end = now();
        if let Some(third) = third {
            row.rival.add(end.wrapping_sub(begin) - empty);
            row.difference = row.difference.max((first - third).abs());
        }
    }
}

/// An inverse of `plays` plays in a bank for `N`.
pub fn row<const N: usize, R: Rival<N>>(now: impl Fn() -> u32 + Copy, plays: usize) -> Row {
    let inverse = model::<N>(plays).inverse().expect("it has one");
    let mut row = Row {
        plays,
        capacity: N,
        takes_stack: matches!(inverse.bank().start(), PlayState::Stack(_)),
        ..Row::default()
    };
    let mut queue = Queue::<f32, STREAM_LEN>::new();
    let (_, mut stream) = queue.split();
    for waveform in references() {
        let mut reference = Reference::new(&waveform, RATE).expect("it can be played");
        let samples = (0..SAMPLES).map_while(|_| reference.next(&mut stream));
        race::<N, R>(&inverse, &mut row, now, samples);
    }
    let mut adverse = row;
    adverse.stack = Count::default();
    race::<N, R>(&inverse, &mut adverse, now, unwinding());
    Row {
        unwinding: adverse.stack.worst,
        difference: adverse.difference,
        ..row
    }
}

/// A preview inverse of `N` plays with one sweep in a tick, on the references.
#[allow(dead_code, reason = "for the emulator only")]
pub fn preview<const N: usize>(
    now: impl Fn() -> u32 + Copy,
    window: usize,
    plant_rate: PlantRate,
) -> Count {
    let settings = PreviewSettings {
        window,
        sweeps: 1,
        plant_rate,
    };
    let inverse = PreviewInverse::<f32, N, 32>::new(&model(N), settings).expect("it has one");
    let empty = overhead(now);
    let mut count = Count::default();
    let mut queue = Queue::<f32, STREAM_LEN>::new();
    let (_, mut stream) = queue.split();
    for waveform in references() {
        let mut reference = Reference::new(&waveform, RATE).expect("it can be played");
        let mut state = inverse.start(0.0);
        for v in (0..SAMPLES).map_while(|_| reference.next(&mut stream)) {
            let v = black_box(v);
            let begin = now();
            let drive = inverse.step(&mut state, v);
            count.add(now().wrapping_sub(begin) - empty);
            black_box(drive);
        }
    }
    count
}

#[inline(never)]
fn sample(control: &mut Control<'_>, sensor: u16, late: bool) -> Output {
    control.tick(sensor, late)
}

fn tell(server: &mut Server<'_>, control: &mut Control<'_>, command: Command) {
    let mut frame = [0; FRAME_LEN];
    let request = Request {
        sequence: 0,
        command,
    };
    let len = encode(&request, &mut frame).expect("it fits");
    for &byte in &frame[..len] {
        server.receive(byte);
    }
    // The order, and the first sample of what it begins.
    for _ in 0..2 {
        sample(control, 0, false);
    }
}

/// Both ends of the queues: a bipolar converter, an amplifier of ten, +-50 V.
pub fn connect<'a>(memory: &'a mut Memory<'a>) -> (Control<'a>, Server<'a>) {
    let settings = Settings {
        dac: dac::Kind::Bipolar16,
        drive_min_v: -50.0,
        drive_max_v: 50.0,
        slew_v_per_s: 1e6,
        ..Settings::default()
    };
    let connected = memory.connect(settings);
    let (control, server, _) = connected.expect("the settings are valid");
    (control, server)
}

/// Which compensator a whole sample has.
#[derive(Clone, Copy)]
pub enum Choice {
    /// The explicit inverse of so many plays; without its rate term where told so.
    Explicit(usize, bool),
    /// A preview of the target's window.
    Preview(usize, PlantRate),
    /// That, with a mode, a lag, a delay and eight decades of creep around it.
    Cascade(usize, PlantRate),
    /// Direct inverse multiplication with so many divisions.
    Dim(usize, Law),
}

fn record(choice: Choice) -> ModelRecord {
    let (plays, inverse) = match choice {
        Choice::Dim(divisions, law) => return modified_play(divisions, law),
        Choice::Explicit(plays, _) => (plays, Inverse::Explicit),
        Choice::Preview(plays, rate) => (plays, Inverse::Preview(ahead(rate))),
        Choice::Cascade(plays, rate) => (plays, Inverse::Cascade(ahead(rate))),
    };
    let (thresholds, weights) = parameters(plays);
    let effects = [
        Effect::AmplifierLag { tau_s: 2e-4 },
        Effect::TransportDelay { delay_s: 1.3e-4 },
        Effect::Resonance {
            f_n_hz: 900.0,
            zeta: 0.05,
        },
        Effect::Creep {
            gain_per_decade: 0.01,
            tau_min_s: 1e-2,
            tau_max_s: 1e5,
        },
    ];
    ModelRecord::Chain(ChainRecord {
        thresholds_v: thresholds[..plays].iter().copied().collect(),
        weights: weights[..=plays].iter().copied().collect(),
        beta_s: match choice {
            Choice::Explicit(_, true) => 0.0,
            _ => BETA,
        },
        asymmetry: None,
        effects: effects.into_iter().collect(),
        gain_um_per_v: 1.0,
        offset_um: 0.0,
        inverse,
    })
}

fn ahead(plant_rate: PlantRate) -> Preview {
    Preview {
        window: WINDOW as u8,
        plant_rate,
    }
}

/// A full modified play model, steep enough for the references.
fn modified_play(divisions: usize, law: Law) -> ModelRecord {
    let steep = |i: usize| 0.3 * libm::expf(-0.2 * i as f32);
    let slopes = core::iter::once(0.9).chain((1..divisions).map(steep));
    ModelRecord::ModifiedPlay(ModifiedPlayRecord {
        u_max_v: 50.0,
        slopes_um_per_v: slopes.collect(),
        offset_um: 0.0,
        alpha_s: 2e-5,
        beta_s: 3e-5,
        interleaving_per_v: 1e-3,
        feedback: [0.3, 0.1, -0.05],
        frequency_hz: 50.0,
        harmonics: Harmonics::Corrected,
        sine: [1e-2, 1e-5, 1e-9],
        cosine: [-1e-2, 2e-5, 1e-9],
        sample_time_s: 1.0 / RATE,
        law,
    })
}

/// A whole sample but for interrupt and converter: reference, compensator, safety, recording,
/// counters, on the references.
pub fn whole_sample(
    (control, server): &mut (Control<'_>, Server<'_>),
    now: impl Fn() -> u32 + Copy,
    choice: Choice,
) -> Count {
    let empty = overhead(now);
    let mut count = Count::default();
    tell(server, control, Command::SetModel(Some(record(choice))));
    tell(server, control, Command::Record { every: 1 });
    for waveform in references() {
        let start = Command::Start {
            path: Path::Compensated,
            waveform,
            samples: 0,
        };
        tell(server, control, start);
        for _ in 0..SAMPLES {
            let (sensor, late) = black_box((1234, false));
            let begin = now();
            let output = sample(control, sensor, late);
            count.add(now().wrapping_sub(begin) - empty);
            black_box(output);
            while server.recorded(false).is_some() {}
        }
        tell(server, control, Command::Hold);
    }
    count
}

/// A way to a sine: its name, what the clock counted, and its largest error.
pub type Sine = (&'static str, Count, f64);

/// Ways to a sine on a period; libm in double precision is the truth.
pub fn sines(now: impl Fn() -> u32 + Copy) -> [Sine; 3] {
    // A power of two, so that phases are exact.
    const STEPS: u16 = 2_048;
    let tones = [tone(1.0, RATE / f32::from(STEPS)), tone(0.0, 0.0)];
    let waveform = Waveform::Tones { offset: 0.0, tones };
    let mut reference = Reference::new(&waveform, RATE).expect("it can be played");
    let mut queue = Queue::<f32, STREAM_LEN>::new();
    let (_, mut stream) = queue.split();
    let turns = |k: u16| f64::from(k) / f64::from(STEPS);
    let mut next = |_: f32| reference.next(&mut stream).unwrap_or(f32::NAN);
    let measure = |name, sine: &mut dyn FnMut(f32) -> f32, phase: &dyn Fn(u16) -> f64| {
        let empty = overhead(now);
        let (mut count, mut error) = (Count::default(), 0.0f64);
        for k in 0..STEPS {
            let x = black_box((TAU * turns(k)) as f32);
            let begin = now();
            let y = black_box(sine(x));
            count.add(now().wrapping_sub(begin) - empty);
            error = error.max((f64::from(y) - libm::sin(phase(k))).abs());
        }
        (name, count, error)
    };
    let exact = |k| TAU * turns(k);
    let rounded = |k| f64::from(exact(k) as f32);
    [
        measure("reference", &mut next, &exact),
        measure("libm", &mut libm::sinf, &rounded),
        measure("micromath", &mut F32Ext::sin, &rounded),
    ]
}
