//! Saving over the link, starting with what was saved, and records that do not fit.

use std::sync::{Arc, Mutex};

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use hysteron::control::Path;
use hysteron::link::{Answer, Command, Refusal};
use hysteron::record::RecordError;
use hysteron::settings::{Settings, SettingsError};
use hysteron::store::{Boot, FlashError, Keep, Kept, RECORD_LEN, Saved, Store, Unfit};

use crate::firmware_rig::{Rig, bipolar, model, published, sine};
use crate::nor::Nor;

/// Flash that stays when a target is started anew.
#[derive(Clone)]
struct Flash(Arc<Mutex<Nor<4, 2048>>>);

impl Flash {
    fn new() -> Self {
        Self(Arc::new(Mutex::new(Nor::new(11))))
    }

    /// A target that starts with this flash.
    fn start(&self) -> Rig {
        Rig::kept(Box::leak(Box::new(self.clone())))
    }

    /// Writes a record by hand: the first bytes as the table in `store` has them.
    fn put(&self, version: u16, body: &[u8]) {
        let mut covered = version.to_le_bytes().to_vec();
        covered.extend((body.len() as u16).to_le_bytes());
        covered.extend(1u32.to_le_bytes());
        let mut record = b"HYST".to_vec();
        record.extend(&covered);
        covered.extend(body);
        record.extend(crc32(&covered).to_le_bytes());
        record.extend(body);
        record.resize(record.len().next_multiple_of(4), 0);
        let mut flash = self.0.lock().unwrap();
        flash.erase(0, 2048).unwrap();
        flash.write(0, &record).unwrap();
    }
}

/// CRC-32 bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let mut sum = u32::MAX;
    for &byte in bytes {
        sum ^= u32::from(byte);
        for _ in 0..8 {
            sum = (sum >> 1) ^ (0xedb8_8320 * (sum & 1));
        }
    }
    !sum
}

impl Keep for Flash {
    fn load(&mut self) -> Result<Option<Saved>, Unfit> {
        Store::new(&mut *self.0.lock().unwrap()).load()
    }

    fn save(&mut self, saved: &Saved) -> Result<(), FlashError> {
        Store::new(&mut *self.0.lock().unwrap()).save(saved)
    }
}

/// Changes the bench from the default settings.
fn set_up(rig: &mut Rig) {
    assert_eq!(rig.ask(Command::SetSettings(bipolar())), Answer::Done);
    rig.watch(bipolar());
    rig.step = f64::INFINITY;
    rig.tick();
}

fn kept(rig: &mut Rig) -> Kept {
    match rig.ask(Command::GetKept) {
        Answer::Kept(kept) => kept,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_was_saved_is_in_force_after_a_reset() {
    let flash = Flash::new();
    let mut rig = flash.start();
    assert_eq!(kept(&mut rig), Kept::Nothing);
    set_up(&mut rig);
    rig.tell(Command::SetModel(Some(published())));
    rig.tick();
    assert_eq!(flash.start().ask(Command::GetModel), Answer::Model(None));
    rig.tell(Command::Save);
    assert_eq!(kept(&mut rig), Kept::InForce);
    // Another model, not saved.
    rig.tell(Command::SetModel(None));
    assert_eq!(kept(&mut rig), Kept::Other);

    let mut rig = flash.start();
    assert_eq!(rig.ask(Command::GetSettings), Answer::Settings(bipolar()));
    let model = Answer::Model(Some(published()));
    assert_eq!(rig.ask(Command::GetModel), model);
    assert_eq!(kept(&mut rig), Kept::InForce);
    // It compensates as one that was set over the link does.
    let mut other = Rig::new(bipolar());
    other.tell(Command::SetModel(Some(published())));
    other.tick();
    let mut outputs = [&mut rig, &mut other].map(|rig| {
        rig.start(Path::Compensated, sine(20.0, 50.0));
        rig.ticks(2_000)
    });
    let [kept, set] = outputs.each_mut().map(std::mem::take);
    assert!(kept == set);
    assert!(kept.iter().any(|output| output.code > 40_000));
}

#[test]
fn nothing_is_saved_while_something_may_move() {
    let flash = Flash::new();
    let mut rig = flash.start();
    set_up(&mut rig);
    let refused = Answer::Refused(Refusal::State);
    rig.start(Path::Direct, sine(5.0, 50.0));
    rig.ticks(100);
    assert_eq!(rig.ask(Command::Save), refused);
    rig.tell(Command::Hold);
    assert_eq!(rig.ask(Command::Save), refused);
    assert_eq!(rig.ask(Command::Stop), Answer::Done);
    assert_eq!(rig.ask(Command::Save), Answer::Refused(Refusal::Busy));
    rig.tick();
    // On its way to rest.
    assert_eq!(rig.ask(Command::Save), refused);
    rig.ticks(2_000);
    assert_eq!(flash.0.lock().unwrap().erases, 0);
    rig.tell(Command::Save);
    assert_eq!(flash.0.lock().unwrap().erases, 1);
}

#[test]
fn flash_that_fails_is_told_and_changes_nothing() {
    let flash = Flash::new();
    let mut rig = flash.start();
    rig.tell(Command::SetModel(Some(published())));
    rig.tell(Command::Save);
    rig.tell(Command::SetModel(None));
    flash.0.lock().unwrap().broken = true;
    assert_eq!(rig.ask(Command::Save), Answer::Refused(Refusal::Flash));
    assert_eq!(kept(&mut rig), Kept::Other);
    let model = Answer::Model(Some(published()));
    assert_eq!(flash.start().ask(Command::GetModel), model);
    // So is a target without any.
    let mut rig = Rig::new(Settings::default());
    assert_eq!(rig.ask(Command::Save), Answer::Refused(Refusal::Flash));
    assert_eq!(kept(&mut rig), Kept::Nothing);
}

#[test]
fn a_record_that_does_not_fit_is_refused_by_name_until_the_next_save() {
    let body = |settings, model| {
        let saved = Saved { settings, model };
        postcard::to_slice(&saved, &mut [0; RECORD_LEN])
            .unwrap()
            .to_vec()
    };
    let loud = Settings {
        drive_rest_v: 1e3,
        ..bipolar()
    };
    let steep = model(&[2.0, 1.0], &[1.0, 1.0, 1.0], 0.0, 1.0);
    let Err(why) = steep.compensator(1e-4) else {
        panic!("thresholds must increase");
    };
    let good = body(bipolar(), None);
    for (version, body, unfit, settings) in [
        (2, good.clone(), Unfit::Version(2), Settings::default()),
        (0, good.clone(), Unfit::Version(0), Settings::default()),
        (1, good[1..].to_vec(), Unfit::Body, Settings::default()),
        (
            1,
            [&good[..], &[0]].concat(),
            Unfit::Body,
            Settings::default(),
        ),
        (1, Vec::new(), Unfit::Body, Settings::default()),
        (
            1,
            body(loud, None),
            Unfit::Settings(SettingsError::Rest),
            Settings::default(),
        ),
        // The bench is still the bench.
        (
            1,
            body(bipolar(), Some(steep)),
            Unfit::Model(why),
            bipolar(),
        ),
    ] {
        let flash = Flash::new();
        flash.put(version, &body);
        let mut rig = flash.start();
        assert_eq!(kept(&mut rig), Kept::Unfit(unfit));
        assert_eq!(rig.ask(Command::GetSettings), Answer::Settings(settings));
        assert_eq!(rig.ask(Command::GetModel), Answer::Model(None));
        rig.tick();
        rig.tell(Command::Save);
        assert_eq!(kept(&mut rig), Kept::InForce);
        assert_eq!(kept(&mut flash.start()), Kept::InForce);
    }
    assert!(matches!(why, RecordError::Parameter(_)));
    // The same by hand, and good.
    let flash = Flash::new();
    flash.put(1, &good);
    assert_eq!(kept(&mut flash.start()), Kept::InForce);
}

#[test]
fn every_damaged_byte_of_a_record_is_noticed() {
    let flash = Flash::new();
    let saved = Saved {
        settings: bipolar(),
        model: Some(published()),
    };
    flash.clone().save(&saved).unwrap();
    let mut record = [0; RECORD_LEN];
    flash.0.lock().unwrap().read(0, &mut record).unwrap();
    let end = record.iter().rposition(|&byte| byte != 0xff).unwrap() + 1;
    let body_len = usize::from(u16::from_le_bytes([record[6], record[7]]));
    assert_eq!(end, (16 + body_len).next_multiple_of(4));
    for at in 0..16 + body_len {
        for bit in 0..8 {
            let mut damaged = record;
            damaged[at] ^= 1 << bit;
            let mut flash = Flash::new();
            {
                let mut flash = flash.0.lock().unwrap();
                flash.erase(0, 4096).unwrap();
                flash.write(0, &damaged).unwrap();
            }
            let boot = Boot::load(&mut flash).unwrap();
            assert_eq!(boot, Boot::new(Settings::default()).unwrap());
        }
    }
}
