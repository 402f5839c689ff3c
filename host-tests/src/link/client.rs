//! The conversation: a command, its reply, and another try where none comes.

use std::time::Duration;

use hysteron::link::{
    Answer, Command, FRAME_LEN, FrameError, Identity, Message, Reader, Refusal, Request, encode,
};
use hysteron::record::ModelRecord;
use hysteron::safety::State;
use hysteron::settings::Settings;
use hysteron::store::Kept;
use hysteron::telemetry::{Codes, Statistics};

use super::port::Port;
use super::refusal;
use crate::error::Error;
use crate::interrupt;

/// How often a command is sent before the target counts as silent.
const TRIES: u32 = 4;
/// How many times as often the command to stop is sent: the line may come back.
const STOP_ROUNDS: u32 = 3;
/// How long a reply is waited for. The longest frame takes 7 ms on the board's serial port.
const REPLY_LIMIT: Duration = Duration::from_millis(300);
/// The same for saving: flash is erased first, at worst for 4 s.
const SAVE_LIMIT: Duration = Duration::from_secs(5);
/// How long a busy target is asked again: emptying a full stream takes it 1.3 s at 100 samples a
/// second.
const BUSY_LIMIT: Duration = Duration::from_secs(3);
const BUSY_PAUSE: Duration = Duration::from_millis(2);
/// How long nothing is done before Ctrl-C is looked for.
const PATIENCE: Duration = Duration::from_millis(50);

/// Recorded samples as they came: number of the first one, codes.
pub(super) type Block = (u32, Vec<Codes>);

/// A host in conversation with a target.
pub struct Client<'p> {
    port: &'p mut dyn Port,
    sequence: u16,
    reader: Box<Reader>,
    replies: Vec<(u16, Answer)>,
    blocks: Vec<Block>,
    /// A frame in another version of the protocol came.
    foreign: bool,
    /// Ctrl-C no longer ends a wait: the target is being told to stop.
    stopping: bool,
}

impl<'p> Client<'p> {
    /// Finds out who is at the other end of a port.
    ///
    /// # Errors
    /// Nobody who answers, or who is no target of this program's version.
    pub fn connect(port: &'p mut dyn Port) -> Result<(Self, Identity), Error> {
        let mut client = Self {
            port,
            sequence: 0,
            reader: Box::default(),
            replies: Vec::new(),
            blocks: Vec::new(),
            foreign: false,
            stopping: false,
        };
        match client.ask(Command::Identify)? {
            Answer::Identity(identity) if identity.name == *b"hysteron" => Ok((client, identity)),
            _ => Err(unexpected()),
        }
    }

    /// The answer to a command, which is sent again while none comes or the target is busy.
    ///
    /// # Errors
    /// A refusal, told in the user's terms; a target that is silent; a broken connection;
    /// [`Error::Interrupted`].
    pub fn ask(&mut self, command: Command) -> Result<Answer, Error> {
        let limit = self.now() + BUSY_LIMIT;
        loop {
            match self.exchange(&command)? {
                Answer::Refused(Refusal::Busy) if self.now() < limit => self.wait(BUSY_PAUSE)?,
                Answer::Refused(refused) => {
                    return Err(Error::request(refusal::describe(&refused)));
                }
                answer => return Ok(answer),
            }
        }
    }

    /// A command that needs no answer but that it is done.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn tell(&mut self, command: Command) -> Result<(), Error> {
        match self.ask(command)? {
            Answer::Done => Ok(()),
            _ => Err(unexpected()),
        }
    }

    /// Settings in force.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn settings(&mut self) -> Result<Settings, Error> {
        match self.ask(Command::GetSettings)? {
            Answer::Settings(settings) => Ok(settings),
            _ => Err(unexpected()),
        }
    }

    /// Model in force.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn model(&mut self) -> Result<Option<ModelRecord>, Error> {
        match self.ask(Command::GetModel)? {
            Answer::Model(model) => Ok(model),
            _ => Err(unexpected()),
        }
    }

    /// Counters.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn statistics(&mut self) -> Result<Statistics, Error> {
        match self.ask(Command::Statistics)? {
            Answer::Statistics(statistics) => Ok(statistics),
            _ => Err(unexpected()),
        }
    }

    /// What the target's flash holds.
    ///
    /// # Errors
    /// As [`Client::ask`].
    pub fn kept(&mut self) -> Result<Kept, Error> {
        match self.ask(Command::GetKept)? {
            Answer::Kept(kept) => Ok(kept),
            _ => Err(unexpected()),
        }
    }

    /// Ramps the output to rest and ends a recording, whatever happened before and in spite of
    /// Ctrl-C.
    ///
    /// # Errors
    /// A target that can no longer be reached.
    pub fn stop(&mut self) -> Result<(), Error> {
        self.stopping = true;
        let mut stopped = self.tell(Command::Stop);
        for _ in 1..STOP_ROUNDS {
            if stopped.is_err() {
                stopped = self.tell(Command::Stop);
            }
        }
        let ended = stopped.and_then(|()| self.tell(Command::Record { every: 0 }));
        self.stopping = false;
        ended
    }

    /// Waits until something comes from the target, at most `limit`.
    ///
    /// # Errors
    /// A broken connection; [`Error::Interrupted`].
    pub fn wait(&mut self, limit: Duration) -> Result<(), Error> {
        if !self.stopping && interrupt::requested() {
            return Err(Error::Interrupted);
        }
        let mut buffer = [0; 4096];
        let len = self
            .port
            .receive(&mut buffer, limit.min(PATIENCE))
            .map_err(|error| broken(&error))?;
        for &byte in &buffer[..len] {
            match self.reader.push::<Message>(byte) {
                Some(Ok(Message::Reply { sequence, answer })) => {
                    self.replies.push((sequence, answer));
                }
                Some(Ok(Message::Recorded { first, codes })) => {
                    self.blocks.push((first, codes.to_vec()));
                }
                Some(Err(FrameError::Version(_) | FrameError::Body)) => self.foreign = true,
                // A damaged frame: its command is sent again, its samples are missed.
                Some(Err(_)) | None => {}
            }
        }
        Ok(())
    }

    /// Time by the clock of the port.
    pub fn now(&self) -> Duration {
        self.port.now()
    }

    /// Recorded samples that came since the last call.
    pub(super) fn take_blocks(&mut self) -> Vec<Block> {
        std::mem::take(&mut self.blocks)
    }

    fn exchange(&mut self, command: &Command) -> Result<Answer, Error> {
        // Zero marks replies to what could not be read.
        self.sequence = self.sequence.checked_add(1).unwrap_or(1);
        let request = Request {
            sequence: self.sequence,
            command: command.clone(),
        };
        let mut frame = [0; FRAME_LEN];
        let len = encode(&request, &mut frame).map_err(|_| {
            Error::request("the command is too long for a frame; send less at once")
        })?;
        self.replies.clear();
        let patience = match command {
            Command::Save => SAVE_LIMIT,
            _ => REPLY_LIMIT,
        };
        for attempt in 0..TRIES {
            // A zero first: whatever the target has received so far ends here.
            let sent = self.port.send(&[0]);
            sent.and_then(|()| self.port.send(&frame[..len]))
                .map_err(|error| broken(&error))?;
            let limit = self.now() + patience;
            while self.now() < limit {
                self.wait(limit.saturating_sub(self.now()))?;
                let own = |(sequence, _): &(u16, Answer)| *sequence == request.sequence;
                if let Some(at) = self.replies.iter().position(own) {
                    let (_, answer) = self.replies.swap_remove(at);
                    return if attempt > 0 {
                        self.repeated(command, answer)
                    } else {
                        Ok(answer)
                    };
                }
            }
            let unknown = (0, Answer::Refused(Refusal::Unknown));
            self.foreign |= self.replies.contains(&unknown);
        }
        Err(Error::request(if self.foreign {
            "the target speaks another version of the link; flash the firmware of this program's \
             version"
        } else {
            "the target does not answer; check port, power and that the firmware runs"
        }))
    }

    /// The answer to a command that may have been carried out at an earlier try, whose reply was lost.
    fn repeated(&mut self, command: &Command, answer: Answer) -> Result<Answer, Error> {
        let start = matches!(command, Command::Start { .. });
        if start && answer == Answer::Refused(Refusal::State) {
            let Answer::Statistics(statistics) = self.exchange(&Command::Statistics)? else {
                return Err(unexpected());
            };
            if statistics.state == State::Run {
                return Ok(Answer::Done);
            }
        }
        Ok(answer)
    }
}

fn unexpected() -> Error {
    Error::request(
        "the other end answers, but not as hysteron's firmware does; check the port and flash the \
         firmware of this program's version",
    )
}

fn broken(error: &std::io::Error) -> Error {
    Error::request(format!(
        "the connection to the target broke: {error}; connect again"
    ))
}
