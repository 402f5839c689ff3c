//! Instructions of one compensator step beside those of the same inverse in plain C, on a Cortex-M4F
//! emulated by QEMU, whose TIM2 counts one per instruction under `-icount shift=0,sleep=off`.
//!
//! `scripts/bench-firmware.sh` builds and runs it; it fails when a limit is exceeded. Instructions are
//! not cycles: loads, taken branches and dependent floating-point results cost more than one on a
//! real core; `cycles.rs` counts those on a board.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(unsafe_code, reason = "calls the C it compares with")]

#[cfg(target_os = "none")]
#[path = "common/workload.rs"]
mod workload;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a benchmark for QEMU: scripts/bench-firmware.sh runs it");
}

#[cfg(target_os = "none")]
mod bench {
    use cortex_m_rt::entry;
    use hysteron::board::pil::start_counter;
    use hysteron::dim::Law;
    use hysteron::hysteresis::RateDependentPi;
    use hysteron::hysteresis::preview::PlantRate;
    use hysteron::wiring::Memory;
    use semihosting::println;

    use crate::workload::{
        Choice, Nobody, RATE, Rival, Row, connect, preview, row, sines, whole_sample,
    };

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

    unsafe extern "C" {
        fn inverse_3(state: *mut InC<3>, v: f32) -> f32;
        fn inverse_10(state: *mut InC<10>, v: f32) -> f32;
        fn inverse_100(state: *mut InC<100>, v: f32) -> f32;
    }

    macro_rules! rival {
        ($n:literal, $step:ident) => {
            impl Rival<$n> for InC<$n> {
                fn new(inverse: &RateDependentPi<f32, $n>) -> Self {
                    let mut c = Self {
                        weight_0: inverse.weight_0(),
                        beta_per_sample: inverse.beta() * RATE,
                        previous: 0.0,
                        thresholds: [0.0; $n],
                        weights: [0.0; $n],
                        z: [0.0; $n],
                    };
                    c.thresholds.copy_from_slice(inverse.bank().thresholds());
                    c.weights.copy_from_slice(inverse.bank().weights());
                    c
                }

                #[inline(always)]
                fn step(&mut self, v: f32) -> Option<f32> {
                    // SAFETY: the C reads and writes its own state only, laid out as here.
                    Some(unsafe { $step(self, v) })
                }
            }
        };
    }

    rival!(3, inverse_3);
    rival!(10, inverse_10);
    rival!(100, inverse_100);

    /// Of the form that the core takes: most in one sample, and most of the rival's mean in the mean.
    const LIMITS: [(usize, Option<u32>, f32); 3] =
        [(3, Some(75), 1.0), (10, Some(220), 0.5), (100, None, 0.1)];

    /// Most of a tick of the preview inverse.
    const AHEAD_LIMIT: u32 = 10_000;

    /// Clock of the part in Hz.
    const CLOCK_HZ: u32 = 168_000_000;
    /// Cycles of an instruction, at most and in the mean: see docs/performance.md.
    const CYCLES: u32 = 2;
    /// Instructions of the interrupt around a whole sample: entry, return, both converters.
    const AROUND: u32 = 120;

    /// Every compensator, and the most that a whole sample with it may take.
    const WHOLE: [(&str, Choice, u32); 16] = [
        ("explicit, n = 3", Choice::Explicit(3, false), 380),
        ("explicit, n = 10", Choice::Explicit(10, false), 410),
        ("explicit, n = 16", Choice::Explicit(16, false), 410),
        ("rate-independent, n = 3", Choice::Explicit(3, true), 380),
        ("rate-independent, n = 10", Choice::Explicit(10, true), 410),
        ("DIM printed, N = 10", Choice::Dim(10, Law::Printed), 520),
        ("DIM printed, N = 16", Choice::Dim(16, Law::Printed), 550),
        ("DIM exact, N = 10", Choice::Dim(10, Law::Exact), 550),
        ("DIM exact, N = 16", Choice::Dim(16, Law::Exact), 600),
        (
            "preview forward, n = 3",
            Choice::Preview(3, PlantRate::Forward),
            6_100,
        ),
        (
            "preview forward, n = 10",
            Choice::Preview(10, PlantRate::Forward),
            6_700,
        ),
        (
            "preview midpoint, n = 3",
            Choice::Preview(3, PlantRate::Midpoint),
            7_600,
        ),
        (
            "preview midpoint, n = 10",
            Choice::Preview(10, PlantRate::Midpoint),
            8_600,
        ),
        (
            "cascade midpoint, n = 3",
            Choice::Cascade(3, PlantRate::Midpoint),
            8_000,
        ),
        (
            "cascade forward, n = 10",
            Choice::Cascade(10, PlantRate::Forward),
            7_400,
        ),
        (
            "cascade midpoint, n = 10",
            Choice::Cascade(10, PlantRate::Midpoint),
            9_300,
        ),
    ];

    fn within(row: &Row) -> bool {
        LIMITS.iter().all(|&(plays, most, share)| {
            let (taken, worst) = if row.takes_stack {
                (row.stack, row.stack.worst.max(row.unwinding))
            } else {
                (row.plain, row.plain.worst)
            };
            row.plays != plays
                || most.is_none_or(|most| worst <= most)
                    && taken.mean() <= share * row.rival.mean()
                    && row.difference < 1e-4
        })
    }

    #[entry]
    fn main() -> ! {
        static mut MEMORY: Memory<'static> = Memory::new();
        // SAFETY: one write, before the counter is used.
        unsafe { &*hysteron::board::device::RCC::ptr() }
            .apb1enr()
            .modify(|_, w| w.tim2en().enabled());
        let timer = start_counter();
        let now = || timer.cnt().read().bits();

        println!("inverse: instructions a step on paper J's references, mean and worst;");
        println!("unwinding: worst of the stack on an input made to be the dearest for it");
        let against_c = [
            row::<3, InC<3>>(now, 3),
            row::<10, InC<10>>(now, 10),
            row::<100, InC<100>>(now, 100),
        ];
        let with_room = [row::<16, Nobody>(now, 3), row::<16, Nobody>(now, 10)];
        for row in against_c.iter().chain(&with_room) {
            let (plain, stack, c) = (row.plain, row.stack, row.rival);
            println!(
                "n {} of {}: plain {:.1} {} stack {:.1} {} unwinding {} C {:.1} {} difference {:e}",
                row.plays,
                row.capacity,
                plain.mean(),
                plain.worst,
                stack.mean(),
                stack.worst,
                row.unwinding,
                c.mean(),
                c.worst,
                row.difference,
            );
        }
        println!("preview inverse, one sweep: mean and worst");
        let mut ahead = 0;
        for (name, rate) in [
            ("forward", PlantRate::Forward),
            ("backward", PlantRate::Backward),
        ] {
            for window in [24, 30] {
                let counts = [
                    (3, preview::<3>(now, window, rate)),
                    (10, preview::<10>(now, window, rate)),
                ];
                for (plays, count) in counts {
                    println!(
                        "n {plays}, window {window}, {name}: {:.1} {}",
                        count.mean(),
                        count.worst
                    );
                    ahead = ahead.max(count.worst);
                }
            }
        }
        println!(
            "whole sample without interrupt and converter: mean, worst, and the rate in Hz that 168 \
             MHz hold at {CYCLES} cycles an instruction"
        );
        let mut ends = connect(MEMORY);
        let mut within_limits = true;
        for (name, choice, most) in WHOLE {
            let count = whole_sample(&mut ends, now, choice);
            let rate = CLOCK_HZ / (CYCLES * (count.worst + AROUND));
            println!("{name}: {:.0} {} {rate}", count.mean(), count.worst);
            within_limits &= count.worst <= most;
        }
        println!("sine, the call included: mean and worst, largest error");
        for (name, count, error) in sines(now) {
            println!("{name}: {:.1} {} {error:.1e}", count.mean(), count.worst);
        }
        if against_c.iter().all(within) && ahead <= AHEAD_LIMIT && within_limits {
            println!("within the limits");
            semihosting::process::exit(0)
        }
        println!("beyond the limits");
        semihosting::process::exit(1)
    }
}
