//! Processor in the loop: in QEMU, samples and link travel over semihosting's standard streams.
//!
//! The idle loop reads a request, pends the very interrupt that the timer would, and writes what the
//! sample task put out. `docs/link.md` has the records. TIM2 counts one for each instruction when
//! QEMU runs with `-icount shift=0,sleep=off`.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use cortex_m::asm;
use cortex_m::peripheral::{NVIC, SCB};
use heapless::Vec;
use semihosting::io::{Read, Write, stdin, stdout};

use super::device::{Interrupt, TIM2, tim2};
use super::stm32f405::Stm32f405Sampling;
use super::{Board, Sampled, Sampling, Single};
use crate::control::Output;
use crate::link::Server;
use crate::safety::State;
use crate::store::RamFlash;
use crate::telemetry::{Alive, Shared};

static SENSOR: AtomicU32 = AtomicU32::new(0);
static LATE: AtomicBool = AtomicBool::new(false);
/// Code, and 1 << 16 when the driver is enabled.
static PUT: AtomicU32 = AtomicU32::new(0);

/// The hardware's sampling, driven all the same, with the simulated world on top.
pub struct Simulated(pub Stm32f405Sampling);

impl Sampling for Simulated {
    #[inline(always)]
    fn begin(&mut self) -> Sampled {
        let _ = self.0.begin();
        Sampled {
            sensor: SENSOR.load(Ordering::Relaxed) as u16,
            late: LATE.load(Ordering::Relaxed),
        }
    }

    #[inline(always)]
    fn put(&mut self, output: Output) {
        self.0.put(output);
        let enabled = u32::from(output.driver_enabled) << 16;
        PUT.store(u32::from(output.code) | enabled, Ordering::Relaxed);
    }
}

/// Bytes of a response before its payload.
const HEADER_LEN: usize = 12;
/// Bytes of the longest payload.
const PAYLOAD_LEN: usize = 2048;

/// Stands for the flash, whose controller QEMU lacks: memory that a reset leaves alone. `None` but for the
/// first time after a reset.
pub fn flash() -> Option<&'static mut RamFlash> {
    #[unsafe(link_section = ".uninit.FLASH")]
    static mut FLASH: MaybeUninit<RamFlash> = MaybeUninit::uninit();
    static TAKEN: Single = Single::new();
    TAKEN.take(|| {
        // SAFETY: once after each reset, and bytes of any value are flash of some content.
        unsafe { (&raw mut FLASH).cast::<RamFlash>().as_mut_unchecked() }
    })
}

/// Starts the instruction counter.
pub fn start_counter() -> &'static tim2::RegisterBlock {
    // SAFETY: nothing else uses TIM2.
    let counter = unsafe { &*TIM2::ptr() };
    counter.psc().write(|w| w.psc().set(0));
    // SAFETY: the longest period.
    counter.arr().write(|w| unsafe { w.bits(u32::MAX) });
    counter.egr().write(|w| w.ug().update());
    counter.cr1().write(|w| w.cen().enabled());
    counter
}

/// Stands for the queues of the serial port: what a response carries. Not on the stack, whose depth is
/// to be that of the board's program.
pub struct Bytes(Vec<u8, PAYLOAD_LEN>);

/// Stands for the serial port, which never asks for its interrupt here.
pub struct Port;

/// The idle loop's part.
pub struct Line(&'static mut Vec<u8, PAYLOAD_LEN>);

impl Bytes {
    /// Empty.
    #[allow(clippy::new_without_default, reason = "as the serial port's")]
    pub const fn new() -> Self {
        Self(Vec::new())
    }

    /// The two parts.
    pub fn open(&'static mut self) -> (Port, Line) {
        (Port, Line(&mut self.0))
    }
}

impl Port {
    /// Never called.
    pub fn serve(&mut self) {}
}

impl Line {
    /// Serves requests until standard input ends, then leaves the emulator with exit code 0.
    pub fn run<B: Board>(
        &mut self,
        server: &mut Server<'static>,
        shared: &'static Shared,
        board: &mut B,
    ) -> ! {
        run(server, shared, board, self.0)
    }
}

fn run<B: Board>(
    server: &mut Server<'static>,
    shared: &'static Shared,
    board: &mut B,
    payload: &mut Vec<u8, PAYLOAD_LEN>,
) -> ! {
    let counter = start_counter();
    let mut applied = *server.valid();
    let mut alive = Alive::new(shared);
    while let Some([kind, len, low, high]) = receive::<4>() {
        payload.clear();
        let mut instructions = 0;
        match kind {
            b'T' | b'O' => {
                SENSOR.store(u16::from_le_bytes([low, high]).into(), Ordering::Relaxed);
                LATE.store(kind == b'O', Ordering::Relaxed);
                let before = counter.cnt().read().bits();
                NVIC::pend(Interrupt::TIM3);
                asm::isb();
                instructions = counter.cnt().read().bits().wrapping_sub(before);
            }
            b'L' => {
                for _ in 0..len {
                    let Some([byte]) = receive::<1>() else { break };
                    if let Some(frame) = server.receive(byte) {
                        // Replies are shorter than a payload, and a request brings one or two.
                        let _ = payload.extend_from_slice(frame);
                    }
                    if *server.valid() != applied {
                        applied = *server.valid();
                        board.apply(&applied);
                    }
                }
                while payload.len() + crate::link::FRAME_LEN <= PAYLOAD_LEN
                    && let Some(frame) = server.recorded(high != 0)
                {
                    let _ = payload.extend_from_slice(frame);
                }
            }
            b'S' => instructions = stack_used(),
            b'R' => {
                respond(kind, 0, false, 0, &[]);
                SCB::sys_reset();
            }
            b'P' => panic!("forced"),
            b'H' => asm::udf(),
            _ => break,
        }
        let statistics = shared.statistics(0);
        let state = match statistics.state {
            State::Off => 0,
            State::Hold => 1,
            State::Run => 2,
            State::Fault => 3,
        };
        // QEMU lacks the watchdog, so the host is told and takes its place.
        let fed = alive.goes_on(shared);
        if fed {
            board.feed_watchdog();
        }
        respond(kind, state, fed, instructions, payload);
    }
    semihosting::process::exit(0)
}

/// Bytes of stack that were ever written: cortex-m-rt paints the rest before `main`.
fn stack_used() -> u32 {
    const PAINT: u32 = 0xcccc_cccc;
    unsafe extern "C" {
        static _stack_start: u32;
        static _stack_end: u32;
    }
    let (top, bottom) = (&raw const _stack_start, &raw const _stack_end);
    let mut at = bottom;
    // SAFETY: reads of aligned words between the linker's bounds of the stack.
    unsafe {
        while at < top && at.read_volatile() == PAINT {
            at = at.add(1);
        }
        top.byte_offset_from(at) as u32
    }
}

/// What the fault handler put out, for the host to see.
pub fn report_fault(code: u16) {
    PUT.store(code.into(), Ordering::Relaxed);
    respond(b'F', 3, false, 0, &[]);
}

fn respond(kind: u8, state: u8, fed: bool, instructions: u32, payload: &[u8]) {
    let put = PUT.load(Ordering::Relaxed);
    let [code_low, code_high, enabled, _] = put.to_le_bytes();
    let [len_low, len_high] = (payload.len() as u16).to_le_bytes();
    let [a, b, c, d] = instructions.to_le_bytes();
    let header: [u8; HEADER_LEN] = [
        kind,
        state,
        code_low,
        code_high,
        enabled,
        fed.into(),
        len_low,
        len_high,
        a,
        b,
        c,
        d,
    ];
    // A host that has gone away is noticed when reading.
    if let Ok(mut out) = stdout() {
        let _ = out.write_all(&header);
        let _ = out.write_all(payload);
    }
}

/// The next bytes of standard input; `None` at its end.
fn receive<const LEN: usize>() -> Option<[u8; LEN]> {
    let mut bytes = [0; LEN];
    stdin().ok()?.read_exact(&mut bytes).ok()?;
    Some(bytes)
}
