//! What is saved in flash: whole through a power cut at any moment, refused by name where it does not
//! fit, saved only while nothing moves.

#[path = "../firmware_rig/mod.rs"]
mod firmware_rig;
mod link;
mod nor;
mod records;

use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};
use hysteron::store::{FlashError, Keep, RECORD_LEN, Saved, Store};
use nor::Nor;
use rand::rngs::SmallRng;
use rand::{Rng, SeedableRng};
use records::{anything, fullest};

const SEQUENCES: u64 = 1_000;

/// What the power cuts of a series of saves left.
#[derive(Debug, Default)]
struct Found {
    old: usize,
    new: usize,
    /// Neither, or a mixture.
    lost: usize,
    /// Saves after a cut that did not succeed.
    stuck: usize,
}

/// Cuts the power in every operation of one save after another. A save begins with what an earlier
/// one left, whole or cut off.
fn cut_everywhere<const WORD: usize, const ERASE: usize>(
    save: impl Fn(&mut Nor<WORD, ERASE>, &Saved) -> Result<(), FlashError>,
) -> Found {
    let load = |flash: &mut Nor<WORD, ERASE>| Store::new(flash).load();
    let mut found = Found::default();
    let mut random = SmallRng::seed_from_u64(7);
    let mut flash = Nor::new(7);
    let mut old = None;
    for sequence in 0..SEQUENCES {
        let new = Some(anything(&mut random));
        let mut whole = flash.clone();
        whole.operations = 0;
        save(&mut whole, new.as_ref().unwrap()).unwrap();
        assert_eq!(load(&mut whole), Ok(new.clone()));
        let operations = whole.operations;
        // One of the operations, or none, is where the next sequence goes on.
        let goes_on = random.random_range(0..=operations);
        let mut next = (whole, new.clone());
        for operation in 0..operations {
            let mut cut = flash.cut_in(operation, sequence << 32 | operation as u64);
            assert_eq!(save(&mut cut, new.as_ref().unwrap()), Err(FlashError));
            cut.power_on();
            let after = load(&mut cut);
            match &after {
                Ok(saved) if *saved == old => found.old += 1,
                Ok(saved) if *saved == new => found.new += 1,
                _ => found.lost += 1,
            }
            let mut again = cut.clone();
            let saved = save(&mut again, new.as_ref().unwrap());
            if saved.is_err() || load(&mut again) != Ok(new.clone()) {
                found.stuck += 1;
            }
            if operation == goes_on {
                next = (cut, after.unwrap_or(None));
            }
        }
        (flash, old) = next;
    }
    found
}

fn two_slots<const WORD: usize, const ERASE: usize>(
    flash: &mut Nor<WORD, ERASE>,
    saved: &Saved,
) -> Result<(), FlashError> {
    Store::new(flash).save(saved)
}

fn nothing_is_lost<const WORD: usize, const ERASE: usize>() {
    let found = cut_everywhere::<WORD, ERASE>(two_slots);
    println!("words of {WORD} bytes: {SEQUENCES} saves, {found:?}");
    assert_eq!((found.lost, found.stuck), (0, 0));
    assert!(found.old > 0 && found.new > 0);
    // An erase and a word at the least.
    assert!(found.old + found.new > 2 * SEQUENCES as usize);
}

#[test]
fn a_cut_in_any_operation_leaves_the_old_record_or_the_new_one() {
    nothing_is_lost::<4, 2048>();
}

#[test]
fn so_it_does_in_words_of_32_bytes_with_error_correction() {
    nothing_is_lost::<32, 2048>();
}

#[test]
fn a_store_of_a_single_slot_is_found_out() {
    let found = cut_everywhere::<4, 2048>(|flash, saved| {
        // Both slots hold the same record, so that the newer one is always the one to go.
        let mut spare = Nor::<4, 2048>::new(1);
        Store::new(&mut spare).save(saved)?;
        let mut bytes = [0; RECORD_LEN];
        spare.read(0, &mut bytes).map_err(|_| FlashError)?;
        flash.erase(0, 4096).map_err(|_| FlashError)?;
        flash.write(0, &bytes).map_err(|_| FlashError)
    });
    assert!(found.lost > 0, "{found:?}");
}

#[test]
fn the_fullest_record_fits_and_the_slots_of_the_parts_serve() {
    fn serves<const WORD: usize, const ERASE: usize>() {
        let mut store = Store::new(Nor::<WORD, ERASE>::new(3));
        for saved in fullest() {
            store.save(&saved).unwrap();
            assert_eq!(store.load(), Ok(Some(saved)));
        }
    }
    serves::<4, { 16 * 1024 }>();
    serves::<32, { 128 * 1024 }>();
    serves::<4, RECORD_LEN>();
}

#[test]
fn what_is_saved_already_is_not_written_again() {
    let mut flash = Nor::<4, 2048>::new(5);
    let saved = anything(&mut SmallRng::seed_from_u64(5));
    for _ in 0..3 {
        Store::new(&mut flash).save(&saved).unwrap();
    }
    assert_eq!(flash.erases, 1);
}

#[test]
fn flash_that_fails_keeps_what_was_saved_before() {
    let mut random = SmallRng::seed_from_u64(6);
    let [first, second] = [anything(&mut random), anything(&mut random)];
    let mut flash = Nor::<4, 2048>::new(6);
    Store::new(&mut flash).save(&first).unwrap();
    flash.broken = true;
    assert_eq!(Store::new(&mut flash).save(&second), Err(FlashError));
    assert_eq!(Store::new(&mut flash).load(), Ok(Some(first)));
}
