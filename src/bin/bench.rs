//! Instructions of one compensator step beside those of the same inverse in plain C, on a Cortex-M4F
//! emulated by QEMU, whose TIM2 counts one per instruction under `-icount shift=0,sleep=off`.
//!
//! `scripts/bench-firmware.sh` builds and runs it. Instructions are not cycles: loads, taken branches
//! and dependent floating-point results cost more than one on a real core.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(unsafe_code, reason = "calls the C it compares with")]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a benchmark for QEMU: scripts/bench-firmware.sh runs it");
}

#[cfg(target_os = "none")]
mod bench {
    use core::hint::black_box;

    use cortex_m_rt::entry;
    use heapless::spsc::Queue;
    use hysteron::board::pil::start_counter;
    use hysteron::hysteresis::{Parameters, RateDependentPi, State};
    use hysteron::play::{PlainState, PlayState, StackState};
    use hysteron::reference::{Reference, STREAM_LEN, Tone, Waveform};
    use semihosting::println;
    use stm32f4::stm32f405::tim2::RegisterBlock;

    /// Samples of each reference: one second.
    const SAMPLES: u32 = 10_000;
    const RATE: f32 = 10_000.0;

    /// Paper J's references in the unit of the inverse's input, 29 being 40 V of drive times a_0.
    fn references() -> [Waveform; 7] {
        let tone = |amplitude, frequency_hz| Tone {
            amplitude,
            frequency_hz,
        };
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

    /// The inverse in C: parameters and state as `benches-c/inverse.c` has them.
    #[repr(C)]
    struct InC<const N: usize> {
        weight_0: f32,
        beta_per_sample: f32,
        previous: f32,
        thresholds: [f32; N],
        weights: [f32; N],
        z: [f32; N],
    }

    type StepInC<'a, const N: usize> = &'a dyn Fn(&mut InC<N>, f32) -> f32;

    unsafe extern "C" {
        fn inverse_3(state: *mut InC<3>, v: f32) -> f32;
        fn inverse_10(state: *mut InC<10>, v: f32) -> f32;
        fn inverse_100(state: *mut InC<100>, v: f32) -> f32;
    }

    #[derive(Clone, Copy)]
    struct Count {
        sum: u32,
        samples: u32,
        worst: u32,
    }

    impl Count {
        const NONE: Self = Self {
            sum: 0,
            samples: 0,
            worst: 0,
        };

        fn add(&mut self, instructions: u32) {
            self.sum += instructions;
            self.samples += 1;
            self.worst = self.worst.max(instructions);
        }

        fn mean(self) -> f32 {
            self.sum as f32 / self.samples as f32
        }
    }

    #[inline(never)]
    fn step<const N: usize>(
        inverse: &RateDependentPi<f32, N>,
        state: &mut State<f32, N>,
        v: f32,
    ) -> f32 {
        inverse.step(state, v)
    }

    /// An inverse with `plays` plays; thresholds over the range, weights like the published stage's.
    fn inverse<const N: usize>(plays: usize) -> RateDependentPi<f32, N> {
        let mut thresholds = [0.0; 100];
        let mut weights = [0.0; 101];
        weights[0] = 0.7236;
        for i in 0..plays {
            thresholds[i] = 38.86 * (i + 1) as f32 / (plays + 1) as f32;
            weights[i + 1] = 0.4834 / plays as f32;
        }
        Parameters {
            weights: &weights[..=plays],
            thresholds: &thresholds[..plays],
            beta: 8.572e-4,
        }
        .build::<N>(1.0 / RATE)
        .and_then(|model| model.inverse())
        .expect("the parameters are valid")
    }

    /// Plain, stack and C on the same samples.
    fn row<const N: usize>(timer: &RegisterBlock, plays: usize, in_c: Option<StepInC<'_, N>>) {
        let now = || timer.cnt().read().bits();
        let begin = now();
        let empty = now() - begin;
        let op = inverse::<N>(plays);
        let bank = op.bank();
        let mut counts = [Count::NONE; 3];
        let mut difference = 0.0f32;
        for waveform in references() {
            let mut plain = State::new(PlayState::Plain(PlainState::zero()), 0.0);
            let mut stack = State::new(PlayState::Stack(StackState::zero(bank)), 0.0);
            let mut c = InC {
                weight_0: op.weight_0(),
                beta_per_sample: op.beta() * RATE,
                previous: 0.0,
                thresholds: [0.0; N],
                weights: [0.0; N],
                z: [0.0; N],
            };
            c.thresholds[..plays].copy_from_slice(bank.thresholds());
            c.weights[..plays].copy_from_slice(bank.weights());
            let mut queue = Queue::<f32, STREAM_LEN>::new();
            let (_, mut stream) = queue.split();
            let mut reference = Reference::new(&waveform, RATE).expect("it can be played");
            for _ in 0..SAMPLES {
                let v = black_box(reference.next(&mut stream).unwrap_or(0.0));
                let begin = now();
                let first = step(&op, &mut plain, v);
                let middle = now();
                let second = step(&op, &mut stack, v);
                let end = now();
                counts[0].add(middle - begin - empty);
                counts[1].add(end - middle - empty);
                difference = difference.max((first - second).abs());
                if let Some(in_c) = in_c {
                    let begin = now();
                    let third = in_c(&mut c, v);
                    counts[2].add(now() - begin - empty);
                    difference = difference.max((first - third).abs());
                }
            }
        }
        let [plain, stack, c] = counts;
        println!(
            "n {plays} capacity {N} plain {:.1} {} stack {:.1} {} c {:.1} {} difference {difference:e}",
            plain.mean(),
            plain.worst,
            stack.mean(),
            stack.worst,
            c.mean(),
            c.worst,
        );
    }

    #[entry]
    fn main() -> ! {
        // SAFETY: one write, before the counter is used.
        unsafe { &*stm32f4::stm32f405::RCC::ptr() }
            .apb1enr()
            .modify(|_, w| w.tim2en().enabled());
        let timer = start_counter();
        println!("form: mean and worst instructions a step over paper J's references");
        // SAFETY: the C reads and writes its own state only, laid out as here.
        unsafe {
            row::<3>(timer, 3, Some(&|c, v| inverse_3(c, v)));
            row::<10>(timer, 10, Some(&|c, v| inverse_10(c, v)));
            row::<100>(timer, 100, Some(&|c, v| inverse_100(c, v)));
        }
        row::<16>(timer, 3, None);
        row::<16>(timer, 10, None);
        semihosting::process::exit(0)
    }
}
