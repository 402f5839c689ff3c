//! Firmware: wiring only. On a host this is a stub, so that a workspace builds as a whole.

#![cfg_attr(target_os = "none", no_std, no_main)]
#![allow(unsafe_code, reason = "what RTIC generates")]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is the firmware: build it for thumbv7em-none-eabihf, see docs/hardware.md");
}

#[cfg(target_os = "none")]
#[rtic::app(device = hysteron::board::device, peripherals = false)]
mod app {
    use hysteron::board::line::{Bytes, Line, Port};
    use hysteron::board::{Board, Hardware, Sampling};
    use hysteron::control::Control;
    use hysteron::link::Server;
    use hysteron::store::{Boot, Store};
    use hysteron::telemetry;
    use hysteron::wiring::Memory;

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        control: Control<'static>,
        samples: <Hardware as Board>::Sampling,
        server: Server<'static>,
        counters: &'static telemetry::Shared,
        board: Hardware,
        port: Port,
        line: Line,
    }

    type Saved = Store<<Hardware as Board>::Flash>;

    /// The output at rest first of all, by what was saved; the samples last.
    #[init(local = [
        memory: Memory<'static> = Memory::new(),
        saved: Option<Saved> = None,
        bytes: Bytes = Bytes::new(),
    ])]
    fn init(cx: init::Context) -> (Shared, Local) {
        let flash = Hardware::flash().expect("taken once");
        let saved = cx.local.saved.insert(Store::new(flash));
        let boot = Boot::load(saved).expect("the default settings are valid");
        let (mut board, samples) = Hardware::start(&boot.valid);
        let connected = cx.local.memory.connect_kept(boot, Some(saved));
        let (control, server, counters) = connected.expect("the default settings are valid");
        let (port, line) = cx.local.bytes.open();
        board.apply(server.valid());
        let local = Local {
            control,
            samples,
            server,
            counters,
            board,
            port,
            line,
        };
        (Shared {}, local)
    }

    /// One sample: reference, compensator, safety, converter.
    ///
    /// Deadline: the next sample, 100 us at 10 kHz; the code goes out within a few us of the timer's
    /// update. Nothing has a higher priority and nothing locks it out. A sample that is still being
    /// computed when the next one is due is counted as late; the next one follows at once and the
    /// one after it is on time again. More than `miss_limit` of them after a start are a fault: the
    /// output ramps to rest. Requests that pile up beyond one are lost and count once.
    ///
    /// Divisions: none, of floats or of integers; `scripts/check-firmware.sh` looks for them.
    #[task(binds = TIM3, priority = 3, local = [control, samples])]
    fn sample(cx: sample::Context) {
        let sample::LocalResources {
            control, samples, ..
        } = cx.local;
        let sampled = samples.begin();
        samples.put(control.tick(sampled.sensor, sampled.late));
    }

    /// Bytes of the link, between samples.
    #[task(binds = USART1, priority = 2, local = [port])]
    fn bytes(cx: bytes::Context) {
        cx.local.port.serve();
    }

    /// Commands, settings, models, recordings: whenever nothing else is due.
    #[idle(local = [server, counters, board, line])]
    fn idle(cx: idle::Context) -> ! {
        let local = cx.local;
        local.line.run(local.server, local.counters, local.board)
    }
}
