//! The target's side of the conversation: judges commands, prepares setups, sends orders.

use heapless::Vec;
use heapless::spsc::{Consumer, Producer};

use super::{
    Answer, Command, FRAME_LEN, FrameError, Identity, Message, RECORDED_LEN, Reader, Refusal,
    Request, encode,
};
use crate::control::{ORDERS_LEN, Order, Path, RETIRED_LEN, Setup};
use crate::record::{DEAD_ZONES, ModelRecord, PLAYS, WINDOW};
use crate::reference::{Reference, STREAM_LEN, Waveform};
use crate::safety::State;
use crate::settings::{Settings, Valid};
use crate::store::{Boot, Keep, Kept, Saved, Unfit};
use crate::telemetry::{Recorded, Sample, Shared, Statistics};

/// The link's ends of what runs between it and the interrupt.
pub struct Wires<'a> {
    /// The setup that the interrupt does not use.
    pub spare: &'a mut Setup,
    /// Orders to the interrupt.
    pub orders: Producer<'a, Order<'a>, ORDERS_LEN>,
    /// Setups that come back.
    pub retired: Consumer<'a, &'a mut Setup, RETIRED_LEN>,
    /// Reference samples to the interrupt.
    pub stream: Producer<'a, f32, STREAM_LEN>,
    /// Recorded samples from the interrupt.
    pub recorded: Recorded<'a>,
    /// Counters.
    pub shared: &'a Shared,
    /// Where settings and model are saved, if anywhere.
    pub keep: Option<&'a mut (dyn Keep + Send)>,
}

/// The link of one output.
pub struct Server<'a> {
    settings: Settings,
    valid: Valid,
    model: Option<ModelRecord>,
    /// Of the model.
    latency: u16,
    /// Away while the interrupt has both setups in hand.
    spare: Option<&'a mut Setup>,
    orders: Producer<'a, Order<'a>, ORDERS_LEN>,
    retired: Consumer<'a, &'a mut Setup, RETIRED_LEN>,
    stream: Producer<'a, f32, STREAM_LEN>,
    recorded: Recorded<'a>,
    shared: &'a Shared,
    keep: Option<&'a mut (dyn Keep + Send)>,
    /// Why what was saved is not in force.
    unfit: Option<Unfit>,
    /// Ticks when the latest order was sent: until the next tick the state is not up to date.
    ordered_at: Option<u32>,
    stream_next: u32,
    /// Samples from before the latest reset of the stream may be left in it.
    emptying: bool,
    held_back: Option<Sample>,
    reader: Reader,
    bad_frames: u32,
    out: [u8; FRAME_LEN],
}

impl<'a> Server<'a> {
    /// For what is in force after a start, with the latency of its model.
    pub fn new(boot: Boot, latency: u32, wires: Wires<'a>) -> Self {
        Self {
            settings: boot.settings,
            valid: boot.valid,
            model: boot.model,
            latency: latency as u16,
            spare: Some(wires.spare),
            orders: wires.orders,
            retired: wires.retired,
            stream: wires.stream,
            recorded: wires.recorded,
            shared: wires.shared,
            keep: wires.keep,
            unfit: boot.unfit,
            ordered_at: None,
            stream_next: 0,
            emptying: false,
            held_back: None,
            reader: Reader::new(),
            bad_frames: 0,
            out: [0; FRAME_LEN],
        }
    }

    /// Settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Settings in force in the form that the interrupt uses.
    pub fn valid(&self) -> &Valid {
        &self.valid
    }

    /// Takes a byte from the host. The byte that ends a command yields the frame of its reply.
    ///
    /// A damaged frame is counted and has no reply: its sequence number cannot be trusted.
    pub fn receive(&mut self, byte: u8) -> Option<&[u8]> {
        let (sequence, answer) = match self.reader.push::<Request>(byte)? {
            Ok(Request { sequence, command }) => (sequence, self.answer(command)),
            Err(error) => {
                self.bad_frames = self.bad_frames.wrapping_add(1);
                match error {
                    FrameError::Version(_) | FrameError::Body => {
                        (0, Answer::Refused(Refusal::Unknown))
                    }
                    _ => return None,
                }
            }
        };
        self.frame(&Message::Reply { sequence, answer })
    }

    /// The frame of the next recorded samples, if there are enough of them or `flush` is set.
    pub fn recorded(&mut self, flush: bool) -> Option<&[u8]> {
        let waiting = self.recorded.len() + usize::from(self.held_back.is_some());
        if waiting == 0 || (waiting < RECORDED_LEN && !flush) {
            return None;
        }
        let Sample { index: first, .. } = match self.held_back {
            Some(sample) => sample,
            None => *self.held_back.insert(self.recorded.dequeue()?),
        };
        let mut codes = Vec::new();
        let mut expected = first;
        while let Some(sample) = self.held_back.take().or_else(|| self.recorded.dequeue()) {
            if sample.index != expected || codes.push(sample.codes).is_err() {
                self.held_back = Some(sample);
                break;
            }
            expected = expected.wrapping_add(1);
        }
        self.frame(&Message::Recorded { first, codes })
    }

    fn frame(&mut self, message: &Message) -> Option<&[u8]> {
        let len = encode(message, &mut self.out).ok()?;
        self.out.get(..len)
    }

    fn answer(&mut self, command: Command) -> Answer {
        match self.carry_out(command) {
            Ok(answer) => answer,
            Err(refusal) => Answer::Refused(refusal),
        }
    }

    fn carry_out(&mut self, command: Command) -> Result<Answer, Refusal> {
        match command {
            Command::Identify => Ok(Answer::Identity(identity())),
            Command::GetSettings => Ok(Answer::Settings(self.settings)),
            Command::SetSettings(settings) => self.set_settings(settings),
            Command::GetModel => Ok(Answer::Model(self.model.clone())),
            Command::SetModel(model) => self.set_model(model),
            Command::Start {
                path,
                waveform,
                samples,
            } => self.start(path, &waveform, samples),
            Command::Hold => match self.state()? {
                State::Fault => Err(Refusal::State),
                _ => self.order(Order::Hold),
            },
            // Always allowed, whatever is on its way: the queue has room for it or is full of orders
            // that are about to be obeyed.
            Command::Stop => self.order(Order::Stop),
            Command::Clear => self.order(Order::Clear),
            Command::ResetStream => self.reset_stream(),
            Command::Stream { first, samples } => self.append(first, &samples),
            Command::Record { every } => self.order(Order::Record(every)),
            Command::Statistics => Ok(Answer::Statistics(Statistics {
                latency: self.latency,
                ..self.shared.statistics(self.bad_frames)
            })),
            Command::Save => self.save(),
            Command::GetKept => Ok(Answer::Kept(self.kept())),
        }
    }

    /// The state of the output once all orders are obeyed.
    fn state(&mut self) -> Result<State, Refusal> {
        // The interrupt obeys one order a sample and publishes at its end.
        if let Some(at) = self.ordered_at {
            if self.orders.len() > 0 || self.shared.ticks() == at {
                return Err(Refusal::Busy);
            }
            self.ordered_at = None;
        }
        Ok(self.shared.statistics(0).state)
    }

    fn order(&mut self, order: Order<'a>) -> Result<Answer, Refusal> {
        self.orders.enqueue(order).map_err(|_| Refusal::Busy)?;
        self.ordered_at = Some(self.shared.ticks());
        Ok(Answer::Done)
    }

    /// Prepares the spare setup and sends it off; a refused one stays here as it was.
    fn adopt(&mut self, valid: &Valid, model: Option<&ModelRecord>) -> Result<Answer, Refusal> {
        if !self.orders.ready() {
            return Err(Refusal::Busy);
        }
        if self.spare.is_none() {
            self.spare = self.retired.dequeue();
        }
        let spare = self.spare.as_mut().ok_or(Refusal::Busy)?;
        spare.prepare(valid, model).map_err(Refusal::Model)?;
        self.latency = spare.latency() as u16;
        match self.spare.take() {
            Some(setup) => self.order(Order::Adopt(setup)),
            None => Err(Refusal::Busy),
        }
    }

    fn set_settings(&mut self, settings: Settings) -> Result<Answer, Refusal> {
        let valid = settings.validate().map_err(Refusal::Settings)?;
        self.at_rest()?;
        let model = self.model.take();
        let adopted = self.adopt(&valid, model.as_ref());
        self.model = model;
        let answer = adopted?;
        (self.settings, self.valid) = (settings, valid);
        Ok(answer)
    }

    /// Refuses unless the output is off and at rest, with no order on its way.
    fn at_rest(&mut self) -> Result<(), Refusal> {
        self.state()?;
        let now = self.shared.statistics(0);
        match now.state {
            State::Off if !now.driver_enabled => Ok(()),
            _ => Err(Refusal::State),
        }
    }

    /// Writing flash makes the interrupt wait; with the driver disabled nothing moves meanwhile.
    #[inline(never)]
    fn save(&mut self) -> Result<Answer, Refusal> {
        self.at_rest()?;
        let keep = self.keep.as_mut().ok_or(Refusal::Flash)?;
        // There and back: a copy of a model would double its room on the stack.
        let saved = Saved {
            settings: self.settings,
            model: self.model.take(),
        };
        let result = keep.save(&saved);
        self.model = saved.model;
        result.map_err(|_| Refusal::Flash)?;
        self.unfit = None;
        Ok(Answer::Done)
    }

    #[inline(never)]
    fn kept(&mut self) -> Kept {
        if let Some(unfit) = self.unfit {
            return Kept::Unfit(unfit);
        }
        match self.keep.as_mut().map(|keep| keep.load()) {
            None | Some(Ok(None)) => Kept::Nothing,
            Some(Ok(Some(saved))) => {
                if saved.settings == self.settings && saved.model == self.model {
                    Kept::InForce
                } else {
                    Kept::Other
                }
            }
            Some(Err(unfit)) => Kept::Unfit(unfit),
        }
    }

    fn set_model(&mut self, model: Option<ModelRecord>) -> Result<Answer, Refusal> {
        let valid = self.valid;
        let answer = self.adopt(&valid, model.as_ref())?;
        self.model = model;
        Ok(answer)
    }

    fn start(&mut self, path: Path, waveform: &Waveform, samples: u32) -> Result<Answer, Refusal> {
        if path == Path::Compensated && self.model.is_none() {
            return Err(Refusal::NoModel);
        }
        let reference =
            Reference::new(waveform, self.settings.sample_rate_hz).map_err(Refusal::Waveform)?;
        match self.state()? {
            State::Off | State::Hold if self.dropping() => Err(Refusal::Busy),
            State::Off | State::Hold => self.order(Order::Start {
                reference,
                path,
                left: (samples > 0).then_some(samples),
            }),
            State::Run | State::Fault => Err(Refusal::State),
        }
    }

    fn reset_stream(&mut self) -> Result<Answer, Refusal> {
        if self.state()? == State::Run {
            return Err(Refusal::State);
        }
        // What is to be dropped is told by its number: it must not become less before the order is
        // obeyed, or the samples that come next would make it up.
        if self.dropping() {
            return Err(Refusal::Busy);
        }
        let stale = self.stream.len() as u32;
        let answer = self.order(Order::DropStream(stale))?;
        (self.stream_next, self.emptying) = (0, stale > 0);
        Ok(answer)
    }

    /// Whether samples from before the latest reset are still in the stream; none is played meanwhile.
    fn dropping(&mut self) -> bool {
        self.emptying = self.emptying && self.stream.len() as u32 > self.stream_next;
        self.emptying
    }

    fn append(&mut self, first: u32, samples: &[f32]) -> Result<Answer, Refusal> {
        if samples.iter().any(|sample| !sample.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        let Some(skip) = self.stream_next.checked_sub(first) else {
            return Err(Refusal::Gap);
        };
        for &sample in samples.iter().skip(skip as usize) {
            if self.stream.enqueue(sample).is_err() {
                break;
            }
            self.stream_next = self.stream_next.wrapping_add(1);
        }
        let free = self.stream.capacity() - self.stream.len();
        Ok(Answer::Stream {
            next: self.stream_next,
            free: u16::try_from(free).unwrap_or(u16::MAX),
        })
    }
}

fn identity() -> Identity {
    const fn number(text: &str) -> u8 {
        match u8::from_str_radix(text, 10) {
            Ok(number) => number,
            Err(_) => panic!("the version of the package has a part above 255"),
        }
    }
    const FIRMWARE: [u8; 3] = [
        number(env!("CARGO_PKG_VERSION_MAJOR")),
        number(env!("CARGO_PKG_VERSION_MINOR")),
        number(env!("CARGO_PKG_VERSION_PATCH")),
    ];
    Identity {
        name: *b"hysteron",
        firmware: FIRMWARE,
        plays: PLAYS as u8,
        dead_zones: DEAD_ZONES as u8,
        stream: (STREAM_LEN - 1) as u16,
        window: WINDOW as u8,
    }
}
