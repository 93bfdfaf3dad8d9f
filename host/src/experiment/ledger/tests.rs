//! What is resumed, and what is refused.

use super::*;
use crate::experiment::method::Method;
use crate::experiment::plan::Plan;
use crate::experiment::study::Venue;
use crate::experiment::trial::{Mark, Raw};

const PLACE: Place = Place { method: Method::Psto, leg: crate::robot::LegScale::SHORT, amplification: 1.4 };

fn identity() -> Identity {
    let gaits = vec![("psto".to_owned(), crate::robot::LegScale::SHORT, "abc".to_owned())];
    Identity { plan: Plan::paper(3, 0), venue: Venue::Twin, robots: Vec::new(), gaits, reference: None }
}

fn trial(number: u32, dx_m: f64) -> Trial {
    let raw = Raw {
        duration_s: 12.0,
        energy_j: 9.1,
        displacement_m: Some([dx_m, 0.1]),
        mass_kg: 0.85,
        ..Raw::default()
    };
    Trial::of(PLACE, number, &raw, "abc")
}

#[test]
fn a_study_goes_on_where_it_was_left_with_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let mut ledger = Ledger::open(folder.path(), &identity()).unwrap();
    ledger.add(vec![trial(0, 1.0 / 3.0), trial(2, 1.5)]).unwrap();
    drop(ledger);

    let mut again = Ledger::open(folder.path(), &identity()).unwrap();

    assert_eq!(again.missing(PLACE, 3), [1]);
    assert_eq!(again.missing(Place { leg: crate::robot::LegScale::LONG, ..PLACE }, 3), [0, 1, 2]);
    assert_eq!(again.trials, vec![trial(0, 1.0 / 3.0), trial(2, 1.5)]);
    again.add(vec![trial(1, -0.5)]).unwrap();
    let trials = again.close().unwrap();
    assert_eq!(trials[2].mark, Some(Mark::Reversed));
    assert_eq!(read(&folder.path().join(TRIALS)).unwrap(), trials);
}

#[test]
fn trials_that_the_plan_cannot_have_had_are_refused_with_their_line() {
    let folder = tempfile::tempdir().unwrap();
    let refusal = |trials: Vec<Trial>| {
        let mut ledger = Ledger::open(folder.path(), &identity()).unwrap();
        ledger.trials = trials;
        ledger.save().unwrap();
        drop(ledger);
        let error = Ledger::open(folder.path(), &identity()).unwrap_err().to_string();
        std::fs::remove_file(folder.path().join(TRIALS)).unwrap();
        error
    };

    assert!(refusal(vec![trial(77, 1.0)]).ends_with("line 2: trial 77 of a plan of 3, counted from 0"));
    let twice = refusal(vec![trial(1, 1.0), trial(0, 1.0), trial(1, 1.2)]);
    assert!(twice.ends_with("line 4: psto 0.6 L 1.4x has a trial 1 already"), "{twice}");
    let of_another = Trial { gait_sha256: "abd".into(), ..trial(0, 1.0) };
    assert!(refusal(vec![of_another]).contains("no gait of this study is psto 0.6 L"));
    let no_number = Trial { cost_of_transport: Some(f64::NAN), ..trial(0, 1.0) };
    assert!(refusal(vec![no_number]).contains("a number that is NaN or infinite"));
    let no_speed = Trial { speed_m_s: None, ..trial(0, 1.0) };
    assert!(refusal(vec![no_speed]).contains("no speed"));
}

#[test]
fn trials_without_their_plan_and_a_study_that_is_in_use_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut ledger = Ledger::open(folder.path(), &identity()).unwrap();
    ledger.add(vec![trial(0, 1.0)]).unwrap();

    assert!(matches!(Ledger::open(folder.path(), &identity()), Err(LedgerError::Busy { .. })));
    drop(ledger);
    std::fs::remove_file(folder.path().join(PLAN)).unwrap();
    assert!(matches!(Ledger::open(folder.path(), &identity()), Err(LedgerError::NoPlan { .. })));
}

#[test]
fn a_table_under_its_old_name_is_refused_and_goes_on_once_it_is_renamed() {
    let folder = tempfile::tempdir().unwrap();
    let mut ledger = Ledger::open(folder.path(), &identity()).unwrap();
    ledger.add(vec![trial(0, 1.0)]).unwrap();
    drop(ledger);
    let (new, old) = (folder.path().join(TRIALS), folder.path().join(OLD_TRIALS));
    std::fs::rename(&new, &old).unwrap();

    let error = Ledger::open(folder.path(), &identity()).unwrap_err();

    assert!(matches!(error, LedgerError::OldName { .. }), "{error}");
    assert!(error.to_string().contains("it is study-trials.csv now"), "{error}");
    std::fs::rename(&old, &new).unwrap();
    assert_eq!(Ledger::open(folder.path(), &identity()).unwrap().missing(PLACE, 2), [1]);
    // A table of `host measure` in the same folder does not concern the study.
    std::fs::remove_file(&new).unwrap();
    std::fs::write(&old, "time_unix_s,gait\n").unwrap();
    assert_eq!(Ledger::open(folder.path(), &identity()).unwrap().missing(PLACE, 1), [0]);
}

#[test]
fn another_plan_is_refused_by_what_differs() {
    let folder = tempfile::tempdir().unwrap();
    Ledger::open(folder.path(), &identity()).unwrap();
    let refusal = |identity: &Identity| match Ledger::open(folder.path(), identity) {
        Err(LedgerError::Other { what, .. }) => what,
        other => panic!("{other:?}"),
    };

    assert_eq!(refusal(&Identity { plan: Plan::paper(4, 0), ..identity() }), "numbers of trials");
    assert_eq!(refusal(&Identity { plan: Plan::paper(3, 1), ..identity() }), "seeds");
    assert_eq!(refusal(&Identity { venue: Venue::Robot, ..identity() }), "places of walking");
    assert_eq!(refusal(&Identity { gaits: Vec::new(), ..identity() }), "gaits");
    std::fs::write(folder.path().join(PLAN), "{").unwrap();
    assert!(matches!(Ledger::open(folder.path(), &identity()), Err(LedgerError::Plan { .. })));
}
