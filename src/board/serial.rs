//! The link on USART1: 921,600 baud, 8N1. An interrupt moves bytes between the port and two queues;
//! the idle loop talks to the queues.

use heapless::spsc::{Consumer, Producer, Queue};
use stm32f4::stm32f405::{Interrupt, USART1};

use super::Board;
use crate::link::Server;
use crate::telemetry::Shared;

/// Bytes between port and idle loop, one less than this, each way: 11 ms of line time.
const BYTES_LEN: usize = 1024;

/// Both queues.
pub struct Bytes {
    received: Queue<u8, BYTES_LEN>,
    to_send: Queue<u8, BYTES_LEN>,
}

/// The interrupt's part.
pub struct Port {
    usart: USART1,
    received: Producer<'static, u8, BYTES_LEN>,
    to_send: Consumer<'static, u8, BYTES_LEN>,
}

/// The idle loop's part.
pub struct Line {
    received: Consumer<'static, u8, BYTES_LEN>,
    to_send: Producer<'static, u8, BYTES_LEN>,
}

impl Default for Bytes {
    fn default() -> Self {
        Self::new()
    }
}

impl Bytes {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            received: Queue::new(),
            to_send: Queue::new(),
        }
    }

    /// Opens the port, whose clock and pins the board has set up.
    pub fn open(&'static mut self) -> (Port, Line) {
        // SAFETY: only the port uses USART1.
        let usart = unsafe { stm32f4::stm32f405::Peripherals::steal() }.USART1;
        // 84 MHz / 91 = 923,077 baud, 0.16 % off.
        // SAFETY: a divider as the reference manual has it.
        usart.brr().write(|w| unsafe { w.bits(91) });
        usart.cr1().write(|w| {
            w.ue().enabled().te().enabled().re().enabled();
            w.rxneie().enabled()
        });
        let (to_received, received) = self.received.split();
        let (to_send, from_send) = self.to_send.split();
        let port = Port {
            usart,
            received: to_received,
            to_send: from_send,
        };
        (port, Line { received, to_send })
    }
}

impl Port {
    /// Called by the interrupt.
    pub fn serve(&mut self) {
        let status = self.usart.sr().read();
        if status.rxne().bit_is_set() || status.ore().bit_is_set() {
            let byte = self.usart.dr().read().bits() as u8;
            // What does not fit is lost and the frame's checksum tells.
            let _ = self.received.enqueue(byte);
        }
        if status.txe().bit_is_set() {
            match self.to_send.dequeue() {
                Some(byte) => {
                    // SAFETY: every value is a byte to send.
                    self.usart.dr().write(|w| unsafe { w.bits(byte.into()) });
                    self.usart.cr1().modify(|_, w| w.txeie().enabled());
                }
                None => {
                    self.usart.cr1().modify(|_, w| w.txeie().disabled());
                }
            }
        }
    }
}

impl Line {
    /// Serves the link for ever: commands first, then what was recorded, then the watchdog, which is
    /// fed only when samples go on.
    pub fn run<B: Board>(
        &mut self,
        server: &mut Server<'static>,
        shared: &'static Shared,
        board: &mut B,
    ) -> ! {
        let mut applied = *server.valid();
        let mut fed_at = shared.ticks().wrapping_sub(1);
        loop {
            while let Some(byte) = self.received.dequeue() {
                if let Some(frame) = server.receive(byte) {
                    Self::send(&mut self.to_send, frame);
                }
                if *server.valid() != applied {
                    applied = *server.valid();
                    board.apply(&applied);
                }
            }
            // Only whole frames, and only when there is room: recording must not delay a reply.
            if self.to_send.capacity() - self.to_send.len() >= BYTES_LEN / 2
                && let Some(frame) = server.recorded(false)
            {
                Self::send(&mut self.to_send, frame);
            }
            let ticks = shared.ticks();
            if ticks != fed_at {
                fed_at = ticks;
                board.feed_watchdog();
            }
        }
    }

    fn send(to_send: &mut Producer<'static, u8, BYTES_LEN>, frame: &[u8]) {
        for &byte in frame {
            // A frame is shorter than the queue; the port empties it in the meantime.
            while to_send.enqueue(byte).is_err() {
                cortex_m::peripheral::NVIC::pend(Interrupt::USART1);
            }
        }
        cortex_m::peripheral::NVIC::pend(Interrupt::USART1);
    }
}
