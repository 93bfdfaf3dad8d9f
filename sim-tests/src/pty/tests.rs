//! The port as a host sees it.

use super::*;
use std::fs::{File, OpenOptions};
use std::io::{Read as _, Write as _};

fn host(pty: &Pty) -> File {
    OpenOptions::new().read(true).write(true).open(pty.path()).unwrap()
}

#[test]
fn every_opening_is_noticed_once() {
    let mut pty = Pty::new().unwrap();
    assert_eq!(pty.look(64).unwrap(), Happened::default());

    for _ in 0..3 {
        let port = host(&pty);
        assert!(pty.look(64).unwrap().opened);
        assert!(!pty.look(64).unwrap().opened);
        drop(port);
        assert!(!pty.look(64).unwrap().opened);
        assert!(!pty.is_open());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn an_opening_right_after_a_closing_is_not_missed() {
    let mut pty = Pty::new().unwrap();
    let port = host(&pty);
    assert!(pty.look(64).unwrap().opened);

    drop(port);
    let _port = host(&pty);

    assert!(pty.look(64).unwrap().opened);
    assert!(!pty.look(64).unwrap().opened);
}

/// What a host does that wants to find the robot as it left it.
#[test]
fn dtr_rises_unless_the_host_before_left_it_alone() {
    let mut pty = Pty::new().unwrap();
    let port = host(&pty);
    assert!(pty.look(64).unwrap().dtr_rose, "the first opening");
    drop(port);
    pty.look(64).unwrap();

    let port = host(&pty);
    assert!(pty.look(64).unwrap().dtr_rose, "after a host that set nothing up");
    let mut settings = tcgetattr(&port).unwrap();
    settings.control_flags.remove(ControlFlags::HUPCL);
    tcsetattr(&port, SetArg::TCSANOW, &settings).unwrap();
    pty.look(64).unwrap();
    drop(port);
    pty.look(64).unwrap();

    let _port = host(&pty);
    let happened = pty.look(64).unwrap();
    assert!(happened.opened && !happened.dtr_rose);
}

#[test]
fn bytes_pass_unchanged_and_nothing_is_echoed() {
    let mut pty = Pty::new().unwrap();
    let mut port = host(&pty);
    pty.look(64).unwrap();
    let all: Vec<u8> = (0..=255).collect();

    port.write_all(&all).unwrap();
    assert_eq!(pty.look(1024).unwrap().bytes, all);
    pty.send(&all).unwrap();
    let mut heard = [0; 256];
    port.read_exact(&mut heard).unwrap();

    assert_eq!(heard.to_vec(), all);
    assert!(pty.look(1024).unwrap().bytes.is_empty());
}

#[test]
fn what_one_host_left_unread_the_next_one_does_not_get() {
    let mut pty = Pty::new().unwrap();
    let port = host(&pty);
    pty.look(64).unwrap();
    pty.send(b"old").unwrap();
    drop(port);
    pty.look(64).unwrap();

    let mut port = host(&pty);
    pty.look(64).unwrap();
    pty.send(b"new").unwrap();
    let mut heard = [0; 3];
    port.read_exact(&mut heard).unwrap();

    assert_eq!(&heard, b"new");
}

#[test]
fn the_last_words_of_a_host_that_closes_still_arrive() {
    let mut pty = Pty::new().unwrap();
    let mut port = host(&pty);
    pty.look(64).unwrap();

    port.write_all(b"bye").unwrap();
    drop(port);

    assert_eq!(pty.look(64).unwrap().bytes, b"bye");
}

#[test]
fn a_link_replaces_a_stale_link_and_nothing_else_and_goes_with_the_port() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("robot");
    std::os::unix::fs::symlink("/nowhere", &link).unwrap();
    let mut pty = Pty::new().unwrap();

    pty.link(&link).unwrap();
    assert_eq!(std::fs::read_link(&link).unwrap(), pty.path());
    drop(pty);
    assert!(std::fs::symlink_metadata(&link).is_err());

    let mine = folder.path().join("mine");
    std::fs::write(&mine, "mine").unwrap();
    std::os::unix::fs::symlink(&mine, &link).unwrap();
    for taken in [&mine, &link] {
        let refused = Pty::new().unwrap().link(taken);
        assert!(matches!(refused, Err(PtyError::LinkTaken { .. })));
        assert_eq!(std::fs::read_to_string(taken).unwrap(), "mine");
    }
    assert_eq!(std::fs::read_link(&link).unwrap(), mine);
}

#[test]
fn a_link_in_use_is_refused_and_left_to_its_robot() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("robot");
    let (mut first, mut second) = (Pty::new().unwrap(), Pty::new().unwrap());
    first.link(&link).unwrap();

    let refused = second.link(&link);

    assert!(matches!(refused, Err(PtyError::LinkInUse { .. })), "{refused:?}");
    drop(second);
    assert_eq!(std::fs::read_link(&link).unwrap(), first.path());
}
