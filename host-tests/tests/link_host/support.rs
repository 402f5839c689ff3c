//! A bench in simulated time, and lines that damage what passes.

use std::io;
use std::time::Duration;

use hysteron::link::Command;
use hysteron_host::link::{Client, Port};
use hysteron_host::pil::{Bench, Hardware, Replica};
use hysteron_host::plant::Stage;

pub fn bench() -> Bench<Replica> {
    bench_with(&Stage::p753())
}

pub fn bench_with(stage: &Stage) -> Bench<Replica> {
    let replica = Replica::power_on().unwrap();
    Bench::new(replica, Hardware::paper_j().unwrap(), stage).unwrap()
}

/// A client whose target has the settings of its bench.
pub fn client(port: &mut dyn Port) -> Client<'_> {
    let (mut client, _) = Client::connect(port).unwrap();
    client.wait(Duration::from_millis(1)).unwrap();
    let settings = Hardware::paper_j().unwrap().settings;
    client.tell(Command::SetSettings(settings)).unwrap();
    client
}

/// What happens to bytes on their way.
#[derive(Clone, Copy)]
pub enum Fault {
    /// One frame in so many to the target has a bit turned.
    DamageRequests(u64),
    /// One read in so many from the target has a bit turned.
    DamageReplies(u64),
    /// One read in so many from the target comes to nothing.
    LoseReplies(u64),
    /// Nothing comes through in either direction between these times.
    Silence(Duration, Duration),
}

/// A bad line in front of a bench.
pub struct Line {
    pub bench: Bench<Replica>,
    pub fault: Option<Fault>,
    sent: u64,
    received: u64,
}

impl Line {
    pub fn new(bench: Bench<Replica>) -> Self {
        Self {
            bench,
            fault: None,
            sent: 0,
            received: 0,
        }
    }

    fn silent(&self) -> bool {
        match self.fault {
            Some(Fault::Silence(from, to)) => (from..to).contains(&self.bench.now()),
            _ => false,
        }
    }
}

impl Port for Line {
    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.silent() {
            return Ok(());
        }
        let mut bytes = bytes.to_vec();
        if bytes.len() > 1 {
            self.sent += 1;
            if let Some(Fault::DamageRequests(every)) = self.fault
                && self.sent.is_multiple_of(every)
            {
                bytes[1] ^= 0x10;
            }
        }
        self.bench.send(&bytes)
    }

    fn receive(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        let len = self.bench.receive(buffer, limit)?;
        if len == 0 {
            return Ok(0);
        }
        self.received += 1;
        let turn = |every: u64| self.received.is_multiple_of(every);
        match self.fault {
            Some(Fault::DamageReplies(every)) if turn(every) => buffer[len / 2] ^= 0x10,
            Some(Fault::LoseReplies(every)) if turn(every) => return Ok(0),
            Some(Fault::Silence(..)) if self.silent() => return Ok(0),
            _ => {}
        }
        Ok(len)
    }

    fn now(&self) -> Duration {
        self.bench.now()
    }
}

/// The message of a refusal: one line.
pub fn message<T: std::fmt::Debug>(result: Result<T, hysteron_host::error::Error>) -> String {
    let message = result.unwrap_err().to_string();
    assert_eq!(message.lines().count(), 1, "{message}");
    message
}
