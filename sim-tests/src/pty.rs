//! A pseudo-terminal that behaves like the USB port of a Nano.
//!
//! Owns the master's end, the link that scripts find the port by, and the
//! notice of somebody opening it, which on a Nano pulls the reset pin. Keeps
//! no slave open itself: that is how it sees openings at all. Refuses to
//! block, and to hand bytes of one opening to the next.

use nix::errno::Errno;
use nix::fcntl::{FcntlArg, FdFlag, OFlag, fcntl, open};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::pty::openpty;
use nix::sys::stat::Mode;
use nix::sys::termios::{FlushArg, SetArg, cfmakeraw, tcflush, tcgetattr, tcsetattr};
use nix::unistd::{read, ttyname, write};
use std::os::fd::{AsFd as _, OwnedFd};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What a pseudo-terminal failed at.
#[derive(Debug, Error)]
pub enum PtyError {
    /// The system gave none.
    #[error("cannot {action} a pseudo-terminal")]
    Terminal {
        /// What was tried.
        action: &'static str,
        /// Why not.
        source: Errno,
    },
    /// Something that is no link of ours is where the link should be.
    #[error("{path} exists and is no symbolic link: remove it, or name another with --link")]
    LinkTaken {
        /// Where.
        path: PathBuf,
    },
    /// The link cannot be made.
    #[error("cannot link {path} to the pseudo-terminal")]
    Link {
        /// Where.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
}

/// What happened at the port since the last look.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Happened {
    /// Somebody opened it: on a Nano, a reset.
    pub opened: bool,
    /// Bytes for the Nano.
    pub bytes: Vec<u8>,
}

/// The port.
#[derive(Debug)]
pub struct Pty {
    master: OwnedFd,
    path: PathBuf,
    link: Option<PathBuf>,
    is_open: bool,
    dropped: u64,
}

impl Pty {
    /// A new port that nobody has opened yet.
    ///
    /// # Errors
    /// [`PtyError`] if the system gives no pseudo-terminal.
    pub fn new() -> Result<Self, PtyError> {
        let failed = |action| move |source| PtyError::Terminal { action, source };
        let pair = openpty(None, None).map_err(failed("open"))?;
        let path = ttyname(&pair.slave).map_err(failed("name"))?;
        // Raw from the start: a program that opens the port without setting it
        // up must not get its own bytes echoed.
        let mut settings = tcgetattr(&pair.slave).map_err(failed("read the settings of"))?;
        cfmakeraw(&mut settings);
        tcsetattr(&pair.slave, SetArg::TCSANOW, &settings).map_err(failed("set up"))?;
        fcntl(&pair.master, FcntlArg::F_SETFL(OFlag::O_NONBLOCK)).map_err(failed("set up"))?;
        fcntl(&pair.master, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)).map_err(failed("set up"))?;
        drop(pair.slave);
        Ok(Self { master: pair.master, path, link: None, is_open: false, dropped: 0 })
    }

    /// Where a host opens it.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes a symbolic link to the port; it goes with it.
    ///
    /// # Errors
    /// [`PtyError`] if there is something else, or the link cannot be made.
    pub fn link(&mut self, link: &Path) -> Result<(), PtyError> {
        let failed = |source| PtyError::Link { path: link.to_owned(), source };
        match std::fs::symlink_metadata(link) {
            Ok(existing) if !existing.is_symlink() => {
                return Err(PtyError::LinkTaken { path: link.to_owned() });
            }
            Ok(_) => std::fs::remove_file(link).map_err(failed)?,
            Err(_) => {}
        }
        std::os::unix::fs::symlink(&self.path, link).map_err(failed)?;
        self.link = Some(link.to_owned());
        Ok(())
    }

    /// Whether a host has the port open.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// Bytes of the robot's that an open port did not take: the host was too slow.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped
    }

    /// What happened, waiting for at most a millisecond; takes up to `room` bytes.
    ///
    /// # Errors
    /// [`PtyError`] if the terminal fails.
    pub fn look(&mut self, room: usize) -> Result<Happened, PtyError> {
        let mut happened = Happened::default();
        let flags = self.poll(1_u16.into())?;
        if flags.contains(PollFlags::POLLHUP) {
            if self.is_open {
                self.is_open = false;
                happened.bytes = self.read(room)?;
                // A closed serial port forgets what nobody read.
                happened.opened = self.flush()?;
                self.is_open = happened.opened;
                return Ok(happened);
            }
            // Poll returns at once while nobody has the port open.
            std::thread::sleep(std::time::Duration::from_millis(1));
            return Ok(happened);
        }
        happened.opened = !self.is_open;
        self.is_open = true;
        if flags.contains(PollFlags::POLLIN) {
            happened.bytes = self.read(room)?;
        }
        Ok(happened)
    }

    /// Sends the robot's bytes to the host, if one is there.
    ///
    /// # Errors
    /// [`PtyError`] if the terminal fails.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), PtyError> {
        let mut rest = bytes;
        while self.is_open && !rest.is_empty() {
            match write(&self.master, rest) {
                Ok(written) => rest = &rest[written..],
                Err(Errno::EAGAIN | Errno::EIO) => {
                    self.dropped += rest.len() as u64;
                    return Ok(());
                }
                Err(Errno::EINTR) => {}
                Err(source) => return Err(PtyError::Terminal { action: "write to", source }),
            }
        }
        Ok(())
    }

    fn poll(&self, timeout: PollTimeout) -> Result<PollFlags, PtyError> {
        let mut waiting = [PollFd::new(self.master.as_fd(), PollFlags::POLLIN)];
        match poll(&mut waiting, timeout) {
            Ok(_) | Err(Errno::EINTR) => Ok(waiting[0].revents().unwrap_or(PollFlags::empty())),
            Err(source) => Err(PtyError::Terminal { action: "wait for", source }),
        }
    }

    fn read(&self, room: usize) -> Result<Vec<u8>, PtyError> {
        let mut bytes = vec![0; room];
        match read(&self.master, &mut bytes) {
            Ok(len) => {
                bytes.truncate(len);
                Ok(bytes)
            }
            // EIO: closed, and nothing left.
            Err(Errno::EAGAIN | Errno::EINTR | Errno::EIO) => Ok(Vec::new()),
            Err(source) => Err(PtyError::Terminal { action: "read from", source }),
        }
    }

    /// Empties the slave's buffer; true if a host opened the port meanwhile.
    fn flush(&self) -> Result<bool, PtyError> {
        let flags = OFlag::O_RDWR | OFlag::O_NOCTTY | OFlag::O_NONBLOCK | OFlag::O_CLOEXEC;
        // Fails where a killed host left its exclusive claim; then so be it.
        if let Ok(slave) = open(&self.path, flags, Mode::empty()) {
            // A host that opened it just now loses nothing: it is being reset.
            let _ = tcflush(&slave, FlushArg::TCIOFLUSH);
        }
        Ok(!self.poll(PollTimeout::ZERO)?.contains(PollFlags::POLLHUP))
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        if let Some(link) = &self.link {
            // Another robot may have taken the name over.
            if std::fs::read_link(link).is_ok_and(|target| target == self.path) {
                let _ = std::fs::remove_file(link);
            }
        }
    }
}

#[cfg(test)]
mod tests {
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

        std::fs::write(&link, "mine").unwrap();
        let refused = Pty::new().unwrap().link(&link);
        assert!(matches!(refused, Err(PtyError::LinkTaken { .. })));
        assert_eq!(std::fs::read_to_string(&link).unwrap(), "mine");
    }
}
