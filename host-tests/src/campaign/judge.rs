//! What must hold whatever happens, judged from outside: codes as they go to the converter, and the
//! replies as they leave the target. Nothing of the code under test is asked, all is computed anew in
//! double precision from what was acknowledged.

use std::collections::HashMap;

use hysteron::dac;
use hysteron::link::{Answer, Command, Message, Reader, Refusal};
use hysteron::record::ModelRecord;
use hysteron::settings::Settings;

use crate::pil::Ticked;

/// States as a target tells them.
pub const OFF: u8 = 0;
/// As above.
pub const HOLD: u8 = 1;
/// As above.
pub const RUN: u8 = 2;
/// As above.
pub const FAULT: u8 = 3;

/// Samples that acknowledged settings may take to come into force.
const ADOPTION: u8 = 2;
/// A code rounded to nearest, and what single precision adds.
const ROUNDING: f64 = 0.52;

/// A reply to a command of ours: sequence number and answer.
pub type Reply = (u16, Answer);

/// The judge of one target.
#[derive(Debug)]
pub struct Judge {
    settings: Settings,
    /// Acknowledged, in force within so many samples.
    coming: Option<(Settings, u8)>,
    model: Option<ModelRecord>,
    saved: Option<(Settings, Option<ModelRecord>)>,
    stream: Vec<f32>,
    asked: HashMap<u16, Command>,
    last: Option<Ticked>,
    reader: Box<Reader>,
}

/// The code for a drive as a real number, from the definition of the settings.
pub fn exact_code(settings: &Settings, drive_v: f64) -> f64 {
    let gain = f64::from(settings.amplifier_gain);
    let converter_v = (drive_v - f64::from(settings.amplifier_offset_v)) / gain;
    match settings.dac {
        dac::Kind::Internal12 => converter_v / 3.3 * 4096.0,
        dac::Kind::Bipolar16 => (converter_v + 5.0) / 10.0 * 65_536.0,
    }
}

/// Lowest and highest code within the range of the drive.
fn range(settings: &Settings) -> (f64, f64) {
    let a = exact_code(settings, f64::from(settings.drive_min_v));
    let b = exact_code(settings, f64::from(settings.drive_max_v));
    let max = f64::from(settings.dac.max_code());
    // Settings that name a full range miss it by the rounding of theirs.
    let low = (a.min(b) - 2e-3).ceil().max(0.0);
    let high = (a.max(b) + 2e-3).floor().min(max);
    (low, high)
}

/// Largest distance of two neighbouring codes: the slew limit, and one for rounding both.
fn step(settings: &Settings) -> f64 {
    let drive_v = f64::from(settings.slew_v_per_s) / f64::from(settings.sample_rate_hz);
    (exact_code(settings, drive_v) - exact_code(settings, 0.0)).abs() * (1.0 + 1e-6) + 1.0
}

/// Whether `code` is the one nearest to this drive within the range.
pub fn is_code_of(settings: &Settings, drive_v: f64, code: u16) -> bool {
    let (low, high) = range(settings);
    let exact = exact_code(settings, drive_v).clamp(low, high);
    (f64::from(code) - exact).abs() <= ROUNDING
}

impl Default for Judge {
    fn default() -> Self {
        Self::new()
    }
}

impl Judge {
    /// Of a target that has just been powered on for the first time.
    pub fn new() -> Self {
        Self {
            settings: Settings::default(),
            coming: None,
            model: None,
            saved: None,
            stream: Vec::new(),
            asked: HashMap::new(),
            last: None,
            reader: Box::default(),
        }
    }

    /// A command goes out, whether it arrives or not.
    pub fn asks(&mut self, sequence: u16, command: &Command) {
        self.asked.insert(sequence, command.clone());
    }

    /// The target was reset: what was saved is in force, all else is gone.
    pub fn restarted(&mut self) {
        let (settings, model) = self.saved.clone().unwrap_or_default();
        *self = Self {
            settings,
            model,
            saved: self.saved.take(),
            ..Self::new()
        };
    }

    /// Settings that were acknowledged last.
    pub fn settings(&self) -> Settings {
        self.coming.map_or(self.settings, |(settings, _)| settings)
    }

    /// Acknowledged samples of the stream since its last reset.
    pub fn stream(&self) -> &[f32] {
        &self.stream
    }

    /// A sample.
    ///
    /// # Errors
    /// What must not be, in words.
    pub fn saw(&mut self, now: Ticked) -> Result<(), String> {
        let last = self.last.replace(now);
        if let Some((coming, left)) = self.coming {
            return self.adopts(coming, left, now);
        }
        let settings = &self.settings;
        let code = f64::from(now.code);
        let (low, high) = range(settings);
        if !(low..=high).contains(&code) {
            return Err(format!("code {code} outside {low} to {high}"));
        }
        if let Some(last) = last {
            let moved = (code - f64::from(last.code)).abs();
            let allowed = step(settings);
            if moved > allowed {
                return Err(format!(
                    "moved by {moved} codes in a sample, {allowed:.1} allowed"
                ));
            }
            if now.state == HOLD && last.state == HOLD && moved > 0.0 {
                return Err(format!("moved by {moved} codes while it holds"));
            }
        }
        if !now.driver_enabled {
            at_rest(settings, now)?;
            if matches!(now.state, HOLD | RUN) {
                return Err(format!("the driver is off in state {}", now.state));
            }
        }
        Ok(())
    }

    /// Acknowledged settings come into force: at rest and with the driver off, from one sample to the
    /// next.
    fn adopts(&mut self, coming: Settings, left: u8, now: Ticked) -> Result<(), String> {
        if now.driver_enabled {
            return Err("the driver is on while settings change".to_owned());
        }
        if at_rest(&coming, now).is_ok() {
            (self.settings, self.coming) = (coming, None);
            return Ok(());
        }
        match left.checked_sub(1) {
            Some(left) if left > 0 => self.coming = Some((coming, left)),
            _ => return Err("acknowledged settings do not come into force".to_owned()),
        }
        at_rest(&self.settings, now)
    }

    /// Bytes as they leave the target; gives the replies among them.
    ///
    /// # Errors
    /// What must not be, in words.
    pub fn heard(&mut self, bytes: &[u8]) -> Result<Vec<Reply>, String> {
        let mut replies = Vec::new();
        for &byte in bytes {
            match self.reader.push::<Message>(byte) {
                None | Some(Ok(Message::Recorded { .. })) => {}
                Some(Err(error)) => return Err(format!("the target sent a bad frame: {error:?}")),
                Some(Ok(Message::Reply { sequence, answer })) => {
                    self.note(sequence, &answer)?;
                    replies.push((sequence, answer));
                }
            }
        }
        Ok(replies)
    }

    /// Keeps what a reply acknowledges, and holds what it tells against what was.
    fn note(&mut self, sequence: u16, answer: &Answer) -> Result<(), String> {
        if sequence == 0 && *answer == Answer::Refused(Refusal::Unknown) {
            return Ok(());
        }
        let Some(command) = self.asked.get(&sequence) else {
            return Err(format!("a reply to {sequence}, which nobody sent"));
        };
        match (command, answer) {
            (_, Answer::Refused(_)) => {}
            (Command::SetSettings(settings), Answer::Done) => {
                self.coming = Some((*settings, ADOPTION));
            }
            (Command::SetModel(model), Answer::Done) => self.model.clone_from(model),
            (Command::Save, Answer::Done) => {
                self.saved = Some((self.settings(), self.model.clone()));
            }
            (Command::ResetStream, Answer::Done) => self.stream.clear(),
            (Command::Stream { first, samples }, Answer::Stream { next, .. }) => {
                let (first, next) = (*first as usize, *next as usize);
                let known = self.stream.len();
                if next < known || next > known.max(first + samples.len()) {
                    return Err(format!(
                        "{known} samples of the stream were acknowledged, now it is at {next}"
                    ));
                }
                let new = samples.iter().take(next.saturating_sub(first));
                self.stream.extend(new.skip(known.saturating_sub(first)));
            }
            (Command::GetSettings, Answer::Settings(settings)) if *settings != self.settings() => {
                return Err("acknowledged settings are lost".to_owned());
            }
            (Command::GetModel, Answer::Model(model)) if *model != self.model => {
                return Err("the acknowledged model is lost".to_owned());
            }
            _ => {}
        }
        Ok(())
    }
}

/// Refuses a code other than that at rest.
fn at_rest(settings: &Settings, now: Ticked) -> Result<(), String> {
    if is_code_of(settings, f64::from(settings.drive_rest_v), now.code) {
        return Ok(());
    }
    Err(format!(
        "the driver is off at code {}, not at rest",
        now.code
    ))
}

/// Refuses samples that are not those of the acknowledged stream in their order.
///
/// # Errors
/// The first that differs, in words.
pub fn played(settings: &Settings, stream: &[f32], codes: &[u16]) -> Result<(), String> {
    if codes.len() != stream.len() {
        return Err(format!(
            "{} samples were played of {} acknowledged",
            codes.len(),
            stream.len()
        ));
    }
    let wrong = stream
        .iter()
        .zip(codes)
        .position(|(&drive_v, &code)| !is_code_of(settings, f64::from(drive_v), code));
    match wrong {
        None => Ok(()),
        Some(at) => Err(format!(
            "sample {at} of the acknowledged stream was played as code {}, not {:.1}",
            codes[at],
            exact_code(settings, f64::from(stream[at]))
        )),
    }
}
