//! Cycles on a board: the debug unit's cycle counter, results over defmt and RTT.
//!
//! `cargo fw-cycles` builds, flashes and prints; `docs/hardware.md` has the table that the results
//! are for. It leaves converters and driver-enable pin as they are after a reset: high impedance.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "common/workload.rs"]
mod workload;

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a benchmark for a board: cargo fw-cycles, see docs/hardware.md");
}

#[cfg(target_os = "none")]
mod cycles {
    use cortex_m::peripheral::DWT;
    use cortex_m_rt::entry;
    use defmt::println;
    use defmt_rtt as _;
    use hysteron::board::part::full_speed;
    use hysteron::dim::Law;
    use hysteron::hysteresis::preview::PlantRate;
    use hysteron::wiring::Memory;

    use crate::workload::{Choice, Nobody, Row, connect, row, sines, whole_sample};

    fn print(row: &Row) {
        let (plain, stack) = (row.plain, row.stack);
        println!(
            "n {} of {} (used: {}): plain {} {} {}, stack {} {} {}, unwinding {}, difference {}",
            row.plays,
            row.capacity,
            if row.takes_stack { "stack" } else { "plain" },
            plain.mean(),
            plain.spread(),
            plain.worst,
            stack.mean(),
            stack.spread(),
            stack.worst,
            row.unwinding,
            row.difference,
        );
    }

    #[entry]
    fn main() -> ! {
        static mut MEMORY: Memory<'static> = Memory::new();
        full_speed();
        let Some(mut core) = cortex_m::Peripherals::take() else {
            panic!("taken once");
        };
        core.DCB.enable_trace();
        core.DWT.set_cycle_count(0);
        core.DWT.enable_cycle_counter();
        let now = DWT::cycle_count;

        println!("cycles at 168 MHz: mean, spread, worst; the counter's reading taken off");
        println!("inverse on paper J's references, and the stack's worst on unwinding");
        print(&row::<3, Nobody>(now, 3));
        print(&row::<10, Nobody>(now, 10));
        print(&row::<100, Nobody>(now, 100));
        print(&row::<16, Nobody>(now, 3));
        print(&row::<16, Nobody>(now, 10));
        println!("sample without interrupt and converter");
        let mut ends = connect(MEMORY);
        let (rate, exact) = (PlantRate::Midpoint, Law::Exact);
        for (name, choice) in [
            ("explicit, n = 3", Choice::Explicit(3, false)),
            ("explicit, n = 10", Choice::Explicit(10, false)),
            ("DIM exact, N = 10", Choice::Dim(10, exact)),
            ("preview midpoint, n = 3", Choice::Preview(3, rate)),
            ("preview midpoint, n = 10", Choice::Preview(10, rate)),
            ("cascade midpoint, n = 3", Choice::Cascade(3, rate)),
            ("cascade midpoint, n = 10", Choice::Cascade(10, rate)),
        ] {
            let count = whole_sample(&mut ends, now, choice);
            let (mean, spread) = (count.mean(), count.spread());
            println!("{}: {} {} {}", name, mean, spread, count.worst);
        }
        println!("sine, the call included, and its largest error");
        for (name, count, error) in sines(now) {
            let (mean, spread) = (count.mean(), count.spread());
            println!("{}: {} {} {} {}", name, mean, spread, count.worst, error);
        }
        println!("done");
        // Not asleep: a sleeping core may not answer the probe.
        loop {
            cortex_m::asm::nop();
        }
    }
}
