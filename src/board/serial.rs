//! The link on a serial port. An interrupt moves bytes between the port and two queues;
//! the idle loop talks to the queues.

use heapless::spsc::{Consumer, Producer, Queue};

use super::device::Interrupt;
use super::{Board, Hardware, Uart};
use crate::link::Server;
use crate::telemetry::{Alive, Shared};

/// Bytes between port and idle loop, one less than this, each way: 11 ms of line time.
const BYTES_LEN: usize = 1024;

/// Both queues.
pub struct Bytes {
    received: Queue<u8, BYTES_LEN>,
    to_send: Queue<u8, BYTES_LEN>,
}

/// The interrupt's part.
pub struct Port {
    uart: <Hardware as Board>::Uart,
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

    /// Opens the port of a board that was started.
    pub fn open(&'static mut self) -> (Port, Line) {
        let (to_received, received) = self.received.split();
        let (to_send, from_send) = self.to_send.split();
        let port = Port {
            uart: Hardware::uart(),
            received: to_received,
            to_send: from_send,
        };
        (port, Line { received, to_send })
    }
}

impl Port {
    /// Called by the interrupt.
    pub fn serve(&mut self) {
        if let Some(byte) = self.uart.receive() {
            // What does not fit is lost and the frame's checksum tells.
            let _ = self.received.enqueue(byte);
        }
        if self.uart.has_room() {
            let next = self.to_send.dequeue();
            if let Some(byte) = next {
                self.uart.send(byte);
            }
            self.uart.ask_for_room(next.is_some());
        }
    }
}

impl Line {
    /// Serves the link for ever: commands first, then what was recorded, then the watchdog, which is
    /// fed only when samples go on.
    ///
    /// A function of its own, apart from the start: `scripts/interrupt-masks.awk` looks into it.
    #[inline(never)]
    pub fn run<B: Board>(
        &mut self,
        server: &mut Server<'static>,
        shared: &'static Shared,
        board: &mut B,
    ) -> ! {
        let mut applied = *server.valid();
        let mut alive = Alive::new(shared);
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
            if alive.goes_on(shared) {
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
