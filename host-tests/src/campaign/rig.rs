//! A target between a line that can be spoilt and a judge that sees all.

use hysteron::control::Path;
use hysteron::link::{Answer, Command, FRAME_LEN, Refusal, Request, encode};
use hysteron::reference::{Tone, Waveform};
use hysteron::safety::State;
use hysteron::telemetry::Statistics;

use super::dice::Dice;
use super::judge::{Judge, OFF, RUN, Reply};
use crate::error::Error;
use crate::pil::{Pair, Replica, Target, Ticked};

/// How often a command is repeated while the target is busy.
const PATIENCE: usize = 400;

/// A target that can be reset.
pub trait Subject: Target {
    /// As a watchdog does: what was saved is in force, all else is gone.
    ///
    /// # Errors
    /// A target that failed or is gone.
    fn reset(&mut self) -> Result<(), Error>;

    /// In what it differs from another one that was given the same.
    fn difference(&self) -> Option<&str> {
        None
    }
}

impl Subject for Replica {
    fn reset(&mut self) -> Result<(), Error> {
        self.restart()
    }
}

impl Subject for Pair {
    fn reset(&mut self) -> Result<(), Error> {
        Self::reset(self)
    }

    fn difference(&self) -> Option<&str> {
        self.first_difference()
    }
}

/// Why a trial ended early.
#[derive(Debug)]
pub enum Stop {
    /// Something that must hold did not, in words.
    Broken(String),
    /// The target is gone.
    Failed(Error),
}

impl From<String> for Stop {
    fn from(what: String) -> Self {
        Self::Broken(what)
    }
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Failed(error)
    }
}

/// Stops a trial.
pub fn broken<T>(what: impl Into<String>) -> Result<T, Stop> {
    Err(Stop::Broken(what.into()))
}

/// Target, judge, dice.
pub struct Rig<S> {
    subject: S,
    /// What was acknowledged, and whether it holds.
    pub judge: Judge,
    /// For the faults.
    pub dice: Dice,
    /// What the sensor's converter gives.
    pub sensor: u16,
    sequence: u16,
    samples: u64,
}

impl<S: Subject> Rig<S> {
    /// Around a target that was just powered on for the first time.
    ///
    /// # Errors
    /// A target that is not at rest.
    pub fn new(subject: S, seed: u64) -> Result<Self, Stop> {
        let mut rig = Self {
            subject,
            judge: Judge::new(),
            dice: Dice::new(seed),
            sensor: 2048,
            sequence: 0,
            samples: 0,
        };
        rig.wakes()?;
        Ok(rig)
    }

    /// Samples so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The target alone.
    pub fn into_subject(self) -> S {
        self.subject
    }

    /// A sample, on time or late.
    ///
    /// # Errors
    /// What the judge says.
    pub fn tick(&mut self, late: bool) -> Result<Ticked, Stop> {
        let ticked = self.subject.tick(self.sensor, late)?;
        self.samples += 1;
        self.judge.saw(ticked)?;
        match self.subject.difference() {
            Some(difference) => broken(difference),
            None => Ok(ticked),
        }
    }

    /// Samples on time, and what the last one did.
    ///
    /// # Errors
    /// What the judge says.
    pub fn ticks(&mut self, count: usize) -> Result<Ticked, Stop> {
        for _ in 1..count {
            self.tick(false)?;
        }
        self.tick(false)
    }

    /// Resets the target.
    ///
    /// # Errors
    /// What the judge says.
    pub fn reset(&mut self) -> Result<(), Stop> {
        self.subject.reset()?;
        self.judge.restarted();
        self.wakes()
    }

    /// The first sample after a start: off, at rest.
    fn wakes(&mut self) -> Result<(), Stop> {
        let ticked = self.tick(false)?;
        if ticked.state != OFF || ticked.driver_enabled {
            return broken(format!("starts in state {}", ticked.state));
        }
        Ok(())
    }

    /// The frame of a command that is going to be sent, and its sequence number.
    ///
    /// # Errors
    /// A command that does not fit.
    pub fn frame(&mut self, command: &Command) -> Result<(u16, Vec<u8>), Stop> {
        self.sequence = self.sequence.checked_add(1).unwrap_or(1);
        self.judge.asks(self.sequence, command);
        let request = Request {
            sequence: self.sequence,
            command: command.clone(),
        };
        let mut frame = [0; FRAME_LEN];
        match encode(&request, &mut frame) {
            Ok(len) => Ok((self.sequence, frame[..len].to_vec())),
            Err(error) => broken(format!("a command cannot be sent: {error:?}")),
        }
    }

    /// Bytes to the target; gives all that it answers, as bytes and as replies.
    ///
    /// # Errors
    /// What the judge says.
    pub fn send(&mut self, bytes: &[u8]) -> Result<Vec<Reply>, Stop> {
        let heard = self.subject.link(bytes)?;
        Ok(self.judge.heard(&heard)?)
    }

    /// The one answer to a command over a line in order.
    ///
    /// # Errors
    /// No answer or more than one, and what the judge says.
    pub fn ask(&mut self, command: &Command) -> Result<Answer, Stop> {
        let (sent, mut bytes) = self.frame(command)?;
        // A zero first: whatever the target has received so far ends here.
        bytes.insert(0, 0);
        let mut replies = self.send(&bytes)?;
        match (replies.pop(), replies.len()) {
            (Some((sequence, answer)), 0) if sequence == sent => Ok(answer),
            // What the zero ended was whole but for its end, or a foreign body.
            (Some((sequence, answer)), 1) if sequence == sent => Ok(answer),
            (last, before) => broken(format!("{last:?} after {before} others, to {command:?}")),
        }
    }

    /// As [`Rig::ask`], again while the target is busy.
    ///
    /// # Errors
    /// A target that stays busy, and what the judge says.
    pub fn insist(&mut self, command: &Command) -> Result<Answer, Stop> {
        for _ in 0..PATIENCE {
            match self.ask(command)? {
                Answer::Refused(Refusal::Busy) => self.tick(false)?,
                answer => return Ok(answer),
            };
        }
        broken(format!("busy for {PATIENCE} samples, with {command:?}"))
    }

    /// A command that must be carried out.
    ///
    /// # Errors
    /// A refusal, and what the judge says.
    pub fn tell(&mut self, command: &Command) -> Result<(), Stop> {
        match self.insist(command)? {
            Answer::Done => Ok(()),
            answer => broken(format!("{answer:?} to {command:?}")),
        }
    }

    /// The counters.
    ///
    /// # Errors
    /// Another answer, and what the judge says.
    pub fn statistics(&mut self) -> Result<Statistics, Stop> {
        match self.ask(&Command::Statistics)? {
            Answer::Statistics(statistics) => Ok(statistics),
            answer => broken(format!("{answer:?} instead of the counters")),
        }
    }

    /// Plays without end, through the model or past it.
    ///
    /// # Errors
    /// What the judge says.
    pub fn start(&mut self, path: Path, waveform: Waveform) -> Result<(), Stop> {
        let samples = 0;
        self.tell(&Command::Start {
            path,
            waveform,
            samples,
        })
    }

    /// A sine around rest that fits into range and slew.
    pub fn sine(&self, frequency_hz: f32) -> Waveform {
        let settings = self.judge.settings();
        let rest = settings.drive_rest_v;
        let room = (settings.drive_max_v - rest).max(rest - settings.drive_min_v);
        let tone = |amplitude| Tone {
            amplitude,
            frequency_hz,
        };
        Waveform::Tones {
            offset: rest,
            tones: [tone(0.5 * room), tone(0.0)],
        }
    }

    /// Samples in which the output ramps from anywhere to rest.
    pub fn way_to_rest(&self) -> usize {
        let settings = self.judge.settings();
        let range = settings.drive_max_v - settings.drive_min_v;
        (range / settings.ramp_v_per_s * settings.sample_rate_hz) as usize + 4
    }

    /// To rest by command, from any state; acknowledged settings and model are still there, and the
    /// output follows a reference again.
    ///
    /// # Errors
    /// What the judge says.
    pub fn recovers(&mut self) -> Result<(), Stop> {
        self.sensor = 2048;
        // What was ordered before takes a sample each.
        self.ticks(5)?;
        if self.statistics()?.state == State::Fault {
            self.tell(&Command::Clear)?;
        }
        self.rests()?;
        self.ask(&Command::GetSettings)?;
        self.ask(&Command::GetModel)?;
        self.start(Path::Direct, self.sine(20.0))?;
        let before = self.tick(false)?.code;
        let ticked = self.ticks(20)?;
        if ticked.state != RUN || ticked.code == before {
            return broken(format!("does not follow: state {}", ticked.state));
        }
        self.rests()
    }

    /// Ramps to rest and waits for it.
    ///
    /// # Errors
    /// What the judge says.
    pub fn rests(&mut self) -> Result<(), Stop> {
        self.tell(&Command::Stop)?;
        let mut last = self.tick(false)?;
        for _ in 0..self.way_to_rest() {
            if !last.driver_enabled {
                return Ok(());
            }
            last = self.tick(false)?;
        }
        let settings = self.judge.settings();
        broken(format!("does not come to rest: {last:?} with {settings:?}"))
    }
}
