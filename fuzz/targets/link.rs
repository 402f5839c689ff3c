//! Hostile bytes against the link and the state machine behind it, as the firmware connects them.
//!
//! The input is a script: frames whose checksum is right around any body, damaged frames, raw bytes,
//! and samples of the control in between. After every sample the code must lie within the drive's
//! range and within the slew of the code before it, both computed here; what was saved in the end is
//! whole.

use std::mem::ManuallyDrop;
use std::sync::Mutex;

use hysteron::control::{Control, Output};
use hysteron::dac;
use hysteron::link::{Answer, Command, FRAME_LEN, Message, Request, Server, decode, encode};
use hysteron::settings::Settings;
use hysteron::store::{Boot, FlashError, Keep, RamFlash, Saved, Store, Unfit};
use hysteron::wiring::Memory;
use hysteron_host::campaign::framed;

/// Runs a script and gives the number of frames in it.
pub fn run(script: &[u8]) -> u64 {
    let flash = Mutex::new(RamFlash::new());
    let mut kept = Kept(&flash);
    // What it borrows from itself cannot be dropped; it holds nothing on the heap.
    let mut memory = ManuallyDrop::new(Memory::new());
    let settings = bench();
    let connected = Boot::new(settings).and_then(|boot| memory.connect_kept(boot, Some(&mut kept)));
    let Ok((control, server, _)) = connected else {
        panic!("the settings of the bench are good");
    };
    let mut target = Target {
        control,
        server,
        bounds: Bounds::of(&settings),
        settings,
        last: None,
        frames: 0,
    };
    target.ticks(1, 0, false);
    let mut rest = script;
    while let [kind, more @ ..] = rest {
        rest = target.step(*kind, more);
    }
    target.recover();
    let frames = target.frames;
    let boot = Boot::load(&mut Kept(&flash)).unwrap();
    assert_eq!(boot.unfit, None, "what was saved does not fit");
    frames
}

/// A flash that the link saves to and that is looked at afterwards.
struct Kept<'a>(&'a Mutex<RamFlash>);

impl Keep for Kept<'_> {
    fn load(&mut self) -> Result<Option<Saved>, Unfit> {
        Store::new(&mut *self.0.lock().unwrap()).load()
    }

    fn save(&mut self, saved: &Saved) -> Result<(), FlashError> {
        Store::new(&mut *self.0.lock().unwrap()).save(saved)
    }
}

fn bench() -> Settings {
    Settings {
        dac: dac::Kind::Bipolar16,
        drive_min_v: -45.0,
        drive_max_v: 45.0,
        slew_v_per_s: 30_000.0,
        ramp_v_per_s: 2_000.0,
        stale_s: 0.01,
        ..Settings::default()
    }
}

/// What a code may be, and how far it may move in a sample.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: f64,
    high: f64,
    step: f64,
}

impl Bounds {
    /// From the definition of the settings, in double precision; rounding allows a code.
    fn of(settings: &Settings) -> Self {
        let gain = f64::from(settings.amplifier_gain);
        let (codes_per_v, zero) = match settings.dac {
            dac::Kind::Internal12 => (4096.0 / 3.3, 0.0),
            dac::Kind::Bipolar16 => (65_536.0 / 10.0, 32_768.0),
        };
        let code = |drive: f32| {
            (f64::from(drive) - f64::from(settings.amplifier_offset_v)) / gain * codes_per_v + zero
        };
        let (a, b) = (code(settings.drive_min_v), code(settings.drive_max_v));
        let step = f64::from(settings.slew_v_per_s) / f64::from(settings.sample_rate_hz);
        Self {
            low: a.min(b) - 1.0,
            high: a.max(b) + 1.0,
            step: (step / gain * codes_per_v).abs() * (1.0 + 1e-5) + 1.0,
        }
    }
}

struct Target<'a> {
    control: Control<'a>,
    server: Server<'a>,
    settings: Settings,
    bounds: Bounds,
    last: Option<Output>,
    frames: u64,
}

impl Target<'_> {
    /// Obeys one step of the script and gives the rest of it.
    fn step<'s>(&mut self, kind: u8, more: &'s [u8]) -> &'s [u8] {
        let (len, more) = more.split_first().unwrap_or((&0, &[]));
        let len = usize::from(*len);
        match kind % 8 {
            // Mostly frames that get through to the decoder of the body.
            0..=3 => {
                let (body, rest) = more.split_at(len.min(more.len()));
                self.feed(&framed(2, body, 0));
                rest
            }
            4 => {
                let (body, rest) = more.split_at(len.min(more.len()));
                let (version, spoilt) = if kind & 8 == 0 { (kind, 0) } else { (2, 1) };
                self.feed(&framed(version, body, spoilt));
                rest
            }
            5 => {
                let (raw, rest) = more.split_at(len.min(more.len()));
                self.feed(raw);
                self.feed(&[0]);
                rest
            }
            6 => {
                self.ticks(len, u16::from(kind) << 8, false);
                more
            }
            _ => {
                self.ticks(1 + len % 4, u16::from(kind) << 8, kind & 8 != 0);
                let _ = self.server.recorded(kind & 16 != 0);
                more
            }
        }
    }

    fn feed(&mut self, bytes: &[u8]) {
        self.frames += bytes.iter().filter(|&&byte| byte == 0).count() as u64;
        for &byte in bytes {
            if let Some(reply) = self.server.receive(byte) {
                let [frame @ .., 0] = reply else {
                    panic!("a reply without an end");
                };
                let mut frame = frame.to_vec();
                assert!(!frame.contains(&0));
                assert!(decode::<Message>(&mut frame).is_ok(), "a reply of no sense");
            }
        }
    }

    fn ticks(&mut self, count: usize, sensor: u16, late: bool) {
        for _ in 0..count {
            let now = self.control.tick(sensor, late);
            let settings = *self.server.settings();
            let bounds = Bounds::of(&settings);
            // New settings are taken at rest with the output off, from one sample to the next.
            let changed = settings != self.settings;
            let known = if changed {
                [self.bounds, bounds]
            } else {
                [bounds; 2]
            };
            let code = f64::from(now.code);
            assert!(
                known.iter().any(|b| (b.low..=b.high).contains(&code)),
                "code {code} beyond {known:?}"
            );
            if let Some(last) = self.last.filter(|last| !changed && last.dac == now.dac) {
                let moved = (code - f64::from(last.code)).abs();
                assert!(moved <= bounds.step, "moved {moved}, allowed {bounds:?}");
            }
            if !changed || now.dac == settings.dac {
                (self.settings, self.bounds) = (settings, bounds);
            }
            self.last = Some(now);
        }
    }

    /// After anything at all a host finds its way back, and its command is answered.
    fn recover(&mut self) {
        self.feed(&[0]);
        self.ticks(2, 0, false);
        let request = Request {
            sequence: 77,
            command: Command::Statistics,
        };
        let mut frame = [0; FRAME_LEN];
        let len = encode(&request, &mut frame).unwrap_or(0);
        let reply = frame[..len].iter().find_map(|&byte| {
            let reply = self.server.receive(byte)?;
            decode(&mut reply[..reply.len() - 1].to_vec()).ok()
        });
        match reply {
            Some(Message::Reply {
                sequence: 77,
                answer: Answer::Statistics(_),
            }) => {}
            other => panic!("no statistics but {other:?}"),
        }
    }
}
