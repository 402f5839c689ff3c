#![no_std]
#![no_main]
//! Instructions a sample of the plain and the stack bank, mean and worst, on a Cortex-M4F emulated
//! by QEMU, whose TIM2 counts one per instruction under `-icount shift=0`. Instructions are not
//! cycles. `scripts/count-bank-instructions.sh` builds and runs it.

use core::hint::black_box;
use cortex_m_rt::entry;
use hysteron::play::{Envelope, PlainState, PlayBank, StackState};
use semihosting::println;
use stm32f4::stm32f405::{Peripherals, TIM2};

const SAMPLES: usize = 4000;
const RANGE: f32 = 40.0;

trait Form<const N: usize> {
    fn step(&mut self, bank: &PlayBank<f32, N>, envelope: Envelope<f32>) -> f32;
}

impl<const N: usize> Form<N> for PlainState<f32, N> {
    #[inline(never)]
    fn step(&mut self, bank: &PlayBank<f32, N>, envelope: Envelope<f32>) -> f32 {
        self.step(bank, envelope)
    }
}

impl<const N: usize> Form<N> for StackState<f32, N> {
    #[inline(never)]
    fn step(&mut self, bank: &PlayBank<f32, N>, envelope: Envelope<f32>) -> f32 {
        self.step(bank, envelope)
    }
}

/// A tone by rotation: no sine on the target.
struct Tone {
    cos: f32,
    sin: f32,
    re: f32,
    im: f32,
}

impl Tone {
    fn new(cos: f32, sin: f32, amplitude: f32) -> Self {
        Self {
            cos,
            sin,
            re: amplitude,
            im: 0.0,
        }
    }

    fn next(&mut self) -> f32 {
        let Self { cos, sin, re, im } = *self;
        (self.re, self.im) = (cos * re - sin * im, sin * re + cos * im);
        self.im
    }
}

/// 25 V at 5 Hz and 15 V at 12.3 Hz, 10 kHz, with the rate term of paper J.
fn smooth() -> impl Iterator<Item = Envelope<f32>> {
    // cos and sin of 2 pi f h.
    let mut low = Tone::new(0.999_995_07, 0.003_141_587_5, 25.0);
    let mut high = Tone::new(0.999_970_14, 0.007_728_24, 15.0);
    let mut before = 0.0;
    core::iter::repeat_with(move || {
        let u = low.next() + high.next();
        let half_width = 8.572 * (u - before).abs();
        before = u;
        Envelope {
            lo: u - half_width,
            hi: u + half_width,
        }
    })
}

/// White noise over the full range, no rate term.
fn noise() -> impl Iterator<Item = Envelope<f32>> {
    let mut state = 1u32;
    core::iter::repeat_with(move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        Envelope::closed(2.0 * RANGE * ((state >> 8) as f32 / (1 << 24) as f32 - 0.5))
    })
}

/// Swings that each capture one play less, then one that captures them all.
fn unwinding<const N: usize>() -> impl Iterator<Item = Envelope<f32>> {
    let gap = RANGE / (N + 1) as f32;
    let (mut swing, mut u, mut direction) = (0, 0.0, 1.0);
    core::iter::repeat_with(move || {
        if swing == 0 {
            (u, direction) = (-3.0 * RANGE, 1.0);
        } else {
            u += direction * gap * (2 * (N + 1 - swing) + 1) as f32;
            direction = -direction;
        }
        swing = (swing + 1) % (N + 1);
        Envelope::closed(u)
    })
}

/// Instructions of the mean and of the worst sample.
fn count<const N: usize>(
    timer: &TIM2,
    bank: &PlayBank<f32, N>,
    mut state: impl Form<N>,
    input: impl Iterator<Item = Envelope<f32>>,
) -> (u32, u32) {
    let now = || timer.cnt().read().bits();
    let start = now();
    let empty = now() - start;
    let (mut sum, mut worst) = (0, 0);
    for envelope in input.take(SAMPLES) {
        let envelope = black_box(envelope);
        let start = now();
        let output = state.step(bank, envelope);
        let spent = now() - start - empty;
        black_box(output);
        sum += spent;
        worst = worst.max(spent);
    }
    (sum / SAMPLES as u32, worst)
}

fn row<const N: usize>(timer: &TIM2) {
    let mut thresholds = [0.0; N];
    for (i, r) in thresholds.iter_mut().enumerate() {
        *r = RANGE * (i + 1) as f32 / (N + 1) as f32;
    }
    let Ok(bank) = PlayBank::<f32, N>::new(&thresholds, &[0.1; N]) else {
        return;
    };
    let plain = count(timer, &bank, PlainState::zero(), smooth());
    let stack = [
        count(timer, &bank, StackState::zero(&bank), smooth()),
        count(timer, &bank, StackState::zero(&bank), noise()),
        count(timer, &bank, StackState::zero(&bank), unwinding::<N>()),
    ];
    println!(
        "| {N} | {} | {} | {} | {} | {} | {} | {} |",
        plain.0, stack[0].0, stack[0].1, stack[1].0, stack[1].1, stack[2].0, stack[2].1
    );
}

#[entry]
fn main() -> ! {
    if let Some(peripherals) = Peripherals::take() {
        peripherals
            .RCC
            .apb1enr()
            .modify(|_, w| w.tim2en().set_bit());
        peripherals.TIM2.cr1().modify(|_, w| w.cen().set_bit());
        let timer = &peripherals.TIM2;
        println!(
            "| N | plain | smooth mean | worst | noise mean | worst | unwinding mean | worst |"
        );
        println!("|---|---|---|---|---|---|---|---|");
        row::<3>(timer);
        row::<4>(timer);
        row::<6>(timer);
        row::<8>(timer);
        row::<10>(timer);
        row::<12>(timer);
        row::<16>(timer);
        row::<20>(timer);
        row::<24>(timer);
        row::<32>(timer);
        row::<100>(timer);
        row::<1000>(timer);
    }
    semihosting::process::exit(0)
}
