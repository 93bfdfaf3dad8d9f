//! The power cut at every byte of every kind of save.

use crate::torn::{Memory, Torn, first_gait, gait_in, gaits, save_gait, save_record, select};
use firmware::hal::PersistentMemory;
use firmware::store::{Kind, Saved, Store};
use protocol::calibration::{BoardCalibration, CALIBRATION_LEN};
use protocol::gait::MAX_ENCODED_LEN;
use protocol::trial::TRIAL_LEN;
use protocol::{Calibration, GAIT_SLOTS, Joint, Refusal};
use sim_tests::fixtures::{self, Gait, amplitude};
use sim_tests::sim_robot::encoded;

/// More than any save writes.
const MOST_WRITES: usize = 300;

const fn verified(kind: Kind) -> Option<Saved> {
    Some(Saved { kind, verified: true })
}

fn holding(saved: &[(&[u8], f64)]) -> Memory {
    let mut memory = Memory::erased();
    for (encoding, value) in saved {
        assert_eq!(save_gait(&mut memory, encoding, amplitude(*value)), verified(Kind::Gait));
    }
    memory
}

/// Does `act` with the power cut at every byte of it, in every way; hands what
/// is left to `judge`, which tells whether the act had its effect.
fn cut_everywhere(
    before: &Memory,
    act: impl Fn(&mut Memory),
    judge: impl Fn(&mut Memory, usize, Torn) -> bool,
) {
    for torn in Torn::ALL {
        let (mut cuts, mut effects) = (0, 0);
        for writes in 0..MOST_WRITES {
            let mut memory = Memory::cut_after(before.bytes, writes, torn);
            act(&mut memory);
            let is_over = !memory.is_off;
            effects += usize::from(judge(&mut Memory::holding(memory.bytes), writes, torn));
            if is_over {
                break;
            }
            cuts += 1;
        }
        assert!(cuts > 0 && cuts < MOST_WRITES, "{cuts} writes");
        assert!(
            effects > 0 && (effects <= cuts || !matches!(torn, Torn::NotBegun)),
            "{effects} effects of {cuts} cuts, {torn:?}"
        );
    }
}

fn last_trial(memory: &mut impl PersistentMemory) -> Result<Option<[u8; TRIAL_LEN]>, Refusal> {
    let mut record = [0; TRIAL_LEN];
    Ok(Store::new().load_trial(memory, &mut record)?.then_some(record))
}

#[test]
fn a_cut_in_the_save_of_a_gait_leaves_the_others_whole_and_the_next_save_works() {
    let (trot, medley) = (encoded(&fixtures::trot()), encoded(&fixtures::medley()));
    let other = encoded(&Gait { name: "other", ..fixtures::trot() });
    let mut after_erasing = holding(&[(&medley, 2.0), (&trot, 1.0), (&other, 1.5)]);
    Store::new().erase_gait(&mut after_erasing, 0).unwrap();
    assert_eq!(select(&mut after_erasing, 1), verified(Kind::Start));
    for before in [holding(&[(&trot, 1.0)]), holding(&[(&other, 1.5), (&trot, 1.0)]), after_erasing] {
        let kept = gaits(&mut before.clone());
        cut_everywhere(
            &before,
            |memory| _ = save_gait(memory, &medley, amplitude(2.2)),
            |memory, writes, torn| {
                let found = gaits(memory);
                assert!(kept.iter().all(|gait| found.contains(gait)), "{writes} writes, {torn:?}");
                let first = first_gait(memory).unwrap();
                assert!(first == trot || first == medley, "{writes} writes, {torn:?}");
                let is_new = first == medley;
                assert!(!is_new || found.contains(&(medley.clone(), amplitude(2.2))));
                if Store::new().free_slot(memory).is_ok() {
                    assert_eq!(save_gait(memory, &medley, amplitude(3.0)), verified(Kind::Gait));
                    assert_eq!(first_gait(memory), Some(medley.clone()));
                    assert!(gaits(memory).contains(&(medley.clone(), amplitude(3.0))));
                    assert_eq!(gaits(memory).len(), kept.len() + 1, "one of each name");
                }
                is_new
            },
        );
    }
}

#[test]
fn a_cut_in_the_replacement_of_a_gait_leaves_the_old_or_the_new_one_of_that_name() {
    let trot = encoded(&fixtures::trot());
    let newer = encoded(&Gait { name: "trot", ..fixtures::medley() });
    let other = encoded(&fixtures::medley());
    for before in [holding(&[(&trot, 1.0)]), holding(&[(&other, 1.5), (&trot, 1.0)])] {
        cut_everywhere(
            &before,
            |memory| _ = save_gait(memory, &newer, amplitude(2.2)),
            |memory, writes, torn| {
                let first = first_gait(memory).unwrap();
                assert!(first == trot || first == newer, "{writes} writes, {torn:?}");
                let found = gaits(memory);
                let has_other = found.contains(&(other.clone(), amplitude(1.5)));
                assert_eq!(has_other, before.bytes[MAX_ENCODED_LEN + 7] == 0xA5, "{writes} writes, {torn:?}");
                first == newer
            },
        );
    }
}

#[test]
fn a_cut_in_a_selection_leaves_the_gait_before_or_the_one_selected_also_twice_in_a_row() {
    let names = ["a", "b", "c"].map(|name| encoded(&Gait { name, ..fixtures::trot() }));
    let all = names.each_ref().map(|encoding| (encoding.as_slice(), 1.0));
    for from in 0..GAIT_SLOTS {
        for to in (0..GAIT_SLOTS).filter(|to| *to != from) {
            let mut before = holding(&all);
            assert_eq!(select(&mut before, from), verified(Kind::Start));
            let is_either = |memory: &mut Memory| {
                let first = first_gait(memory).unwrap();
                assert!(
                    first == names[usize::from(from)] || first == names[usize::from(to)],
                    "{from} to {to}"
                );
                first == names[usize::from(to)]
            };
            cut_everywhere(
                &before,
                |memory| _ = select(memory, to),
                |memory, writes, torn| {
                    for again in Torn::ALL {
                        for later in 0..3 {
                            let mut twice = Memory::cut_after(memory.bytes, later, again);
                            select(&mut twice, to);
                            is_either(&mut Memory::holding(twice.bytes));
                        }
                    }
                    let is_new = is_either(memory);
                    let third = 3 - from - to;
                    assert_eq!(select(memory, third), verified(Kind::Start), "{writes} writes, {torn:?}");
                    assert_eq!(first_gait(memory), Some(names[usize::from(third)].clone()));
                    is_new
                },
            );
        }
    }
}

#[test]
fn a_cut_in_an_erasure_leaves_the_gait_whole_or_gone() {
    let (trot, medley) = (encoded(&fixtures::trot()), encoded(&fixtures::medley()));
    let before = holding(&[(&trot, 1.0), (&medley, 2.0)]);

    cut_everywhere(
        &before,
        |memory| _ = Store::new().erase_gait(memory, 0).unwrap(),
        |memory, _, _| {
            assert_eq!(gait_in(memory, 1), Some((medley.clone(), amplitude(2.0))));
            match gait_in(memory, 0) {
                Some(kept) => assert_eq!(kept, (trot.clone(), amplitude(1.0))),
                None => assert_eq!(Store::new().free_slot(memory), Ok(0)),
            }
            gait_in(memory, 0).is_none()
        },
    );
}

fn calibration(autostart_s: u8) -> Calibration {
    let authors = Calibration::authors();
    let joints = Joint::ALL.map(|joint| authors.joint(joint));
    // Every field of the board differs, so that no byte is right already.
    let step = u16::from(autostart_s);
    let board = BoardCalibration {
        autostart_s,
        oscillator_khz: 24_000 + 30 * step,
        undervoltage_mv: 4_000 + 2 * step,
        ..authors.board()
    };
    Calibration::new(&joints, &board)
}

fn load_calibration(memory: &mut Memory) -> Option<Calibration> {
    let (mut calibration, mut buffer) = (Calibration::NONE, [0; MAX_ENCODED_LEN]);
    Store::new().load_calibration(memory, &mut buffer, &mut calibration).then_some(calibration)
}

#[test]
fn a_cut_in_the_save_of_a_calibration_leaves_the_old_or_the_new_one() {
    for saves_before in 1..=3 {
        let mut before = Memory::erased();
        for number in 1..=saves_before {
            let saved = save_record(&mut before, Kind::Calibration, calibration(number).bytes());
            assert_eq!(saved, verified(Kind::Calibration));
            assert_eq!(load_calibration(&mut before), Some(calibration(number)));
        }
        let (old, new) = (calibration(saves_before), calibration(100));

        cut_everywhere(
            &before,
            |memory| _ = save_record(memory, Kind::Calibration, new.bytes()),
            |memory, writes, torn| {
                let found = load_calibration(memory).expect("a calibration after every cut");
                assert!(found == old || found == new, "{writes} writes, {torn:?}");
                let next = calibration(200);
                save_record(memory, Kind::Calibration, next.bytes());
                assert_eq!(load_calibration(memory), Some(next), "{writes} writes, {torn:?}");
                found == new
            },
        );
    }
}

#[test]
fn a_cut_in_the_save_of_a_trial_leaves_the_old_one_none_or_the_new_one() {
    let (old, new) = ([0x11; TRIAL_LEN], [0xEE; TRIAL_LEN]);
    let mut before = Memory::erased();
    assert_eq!(last_trial(&mut before), Ok(None));
    assert_eq!(save_record(&mut before, Kind::Trial, &old), verified(Kind::Trial));

    cut_everywhere(
        &before,
        |memory| _ = save_record(memory, Kind::Trial, &new),
        |memory, writes, torn| {
            let found = last_trial(memory).unwrap();
            assert!(found.is_none_or(|found| found == old || found == new), "{writes} writes, {torn:?}");
            found == Some(new)
        },
    );
}

#[test]
fn no_record_reaches_into_another() {
    let trot = encoded(&fixtures::trot());
    let names = ["a", "b", "c"].map(|name| encoded(&Gait { name, ..fixtures::trot() }));
    let mut memory = holding(&names.each_ref().map(|encoding| (encoding.as_slice(), 1.0)));
    for number in [1, 2] {
        save_record(&mut memory, Kind::Calibration, calibration(number).bytes());
    }
    save_record(&mut memory, Kind::Trial, &[0x77; TRIAL_LEN]);

    assert_eq!(gaits(&mut memory), names.map(|encoding| (encoding, amplitude(1.0))));
    assert_eq!(load_calibration(&mut memory), Some(calibration(2)));
    assert_eq!(last_trial(&mut memory), Ok(Some([0x77; TRIAL_LEN])));
    assert_eq!(first_gait(&mut memory).map(|first| first.len()), Some(trot.len()));
    assert_eq!(CALIBRATION_LEN, 84);
}

/// Each write wears a cell, and takes 3.4 ms.
#[test]
fn no_byte_is_written_that_is_right_already() {
    let (trot, medley) = (encoded(&fixtures::trot()), encoded(&fixtures::medley()));
    let mut memory = holding(&[(&trot, 1.0)]);
    for value in [1.0, 1.5, 2.0, 2.5] {
        save_gait(&mut memory, &trot, amplitude(value));
    }
    save_gait(&mut memory, &medley, amplitude(1.0));
    for slot in [0, 0, 1, 1] {
        select(&mut memory, slot);
    }
    for number in [1, 1, 2, 2] {
        save_record(&mut memory, Kind::Calibration, calibration(number).bytes());
        save_record(&mut memory, Kind::Trial, &[number; TRIAL_LEN]);
    }

    assert_eq!(memory.needless, 0);
    assert!(!memory.is_busy());
}
