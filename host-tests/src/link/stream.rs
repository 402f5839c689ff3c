//! Flow control: reference samples sent no faster than the target has room for them.

use std::time::Duration;

use hysteron::link::{Answer, CHUNK_LEN, Command};

use super::client::Client;
use crate::error::Error;

/// Samples on their way to the target.
pub(super) struct Feed<'s> {
    samples: &'s [f32],
    next: usize,
    /// Room that the target had at its last reply, and when it will have room for a chunk.
    free: usize,
    room_at: Duration,
    sample_rate_hz: f64,
}

impl<'s> Feed<'s> {
    /// Empties the target's queue and fills it with the first samples.
    pub(super) fn fill(
        client: &mut Client<'_>,
        samples: &'s [f32],
        sample_rate_hz: f64,
    ) -> Result<Self, Error> {
        client.tell(Command::ResetStream)?;
        let mut feed = Self {
            samples,
            next: 0,
            free: CHUNK_LEN,
            room_at: client.now(),
            sample_rate_hz,
        };
        while feed.next < samples.len() && feed.free > 0 {
            feed.send(client)?;
        }
        Ok(feed)
    }

    /// Sends what there is room for.
    pub(super) fn pump(&mut self, client: &mut Client<'_>) -> Result<(), Error> {
        while self.next < self.samples.len() && client.now() >= self.room_at {
            self.send(client)?;
        }
        Ok(())
    }

    fn send(&mut self, client: &mut Client<'_>) -> Result<(), Error> {
        let rest = &self.samples[self.next..];
        let chunk = &rest[..rest.len().min(CHUNK_LEN)];
        let command = Command::Stream {
            first: self.next as u32,
            samples: heapless::Vec::from_slice(chunk).unwrap_or_default(),
        };
        let Answer::Stream { next, free } = client.ask(command)? else {
            return Err(Error::request(
                "the target answers a stream with something else; flash the firmware of this \
                 program's version",
            ));
        };
        if next as usize > self.samples.len() {
            return Err(Error::request(
                "somebody else streams to this target; end the other program",
            ));
        }
        self.next = next as usize;
        self.free = usize::from(free);
        let missing = CHUNK_LEN.saturating_sub(self.free);
        self.room_at = client.now() + Duration::from_secs_f64(missing as f64 / self.sample_rate_hz);
        Ok(())
    }
}
