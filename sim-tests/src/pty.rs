//! A pseudo-terminal that behaves like the USB port of a Nano.
//!
//! Holds the master's end, the link by which scripts find the port, and the
//! notice that it was opened, which on a Nano pulls the reset pin. Keeps no slave
//! open itself, or it would not see closings. Never blocks, and never passes bytes
//! of one opening on to the next. Does not depend on what the bytes mean.
//! Longer than most files: port, link and notice are opened and closed together.
//!
//! Where the system tells of openings (Linux), none is missed, however short
//! the port was closed; elsewhere one within a millisecond of a closing may be.

#[cfg(test)]
mod tests;

use nix::errno::Errno;
use nix::fcntl::{FcntlArg, FdFlag, OFlag, fcntl, open};
use nix::poll::{PollFd, PollFlags, PollTimeout, poll};
use nix::pty::openpty;
use nix::sys::stat::Mode;
use nix::sys::termios::{ControlFlags, FlushArg, SetArg, cfmakeraw, tcflush, tcgetattr, tcsetattr};
use nix::unistd::{read, ttyname, write};
use std::os::fd::{AsFd as _, OwnedFd};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// What a pseudo-terminal failed at.
#[derive(Debug, Error)]
pub enum PtyError {
    /// The system gave none.
    #[error("cannot {action} a pseudo-terminal")]
    Terminal { action: &'static str, source: Errno },
    /// The path of the link is in use by something else.
    #[error("{path} exists and is not a link to a pseudo-terminal: remove it, or name another with --link")]
    LinkTaken { path: PathBuf },
    /// The link leads to a terminal that is there.
    #[error(
        "{path} leads to {port}, another robot's port: end that robot, remove the link, or name another with --link"
    )]
    LinkInUse {
        path: PathBuf,
        /// Where it leads.
        port: PathBuf,
    },
    /// The link cannot be made.
    #[error("cannot link {path} to the pseudo-terminal: does its folder exist?")]
    Link { path: PathBuf, source: std::io::Error },
}

/// What happened at the port since the last look.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Happened {
    /// Somebody opened it.
    pub opened: bool,
    /// DTR rose with it: on a Nano, a reset. It does not where the host before
    /// asked for DTR to be left alone on closing, with HUPCL off.
    pub dtr_rose: bool,
    /// Bytes for the Nano.
    pub bytes: Vec<u8>,
}

#[derive(Debug)]
pub struct Pty {
    master: OwnedFd,
    path: PathBuf,
    link: Option<PathBuf>,
    is_open: bool,
    /// Whether closing the port now would leave DTR as it is.
    keeps_dtr: bool,
    dropped: u64,
    openings: openings::Openings,
}

impl Pty {
    /// A new port that nobody has opened yet.
    ///
    /// # Errors
    /// [`PtyError`] if the system gives no pseudo-terminal.
    pub fn new() -> Result<Self, PtyError> {
        let (master, path) = open_raw()?;
        let openings = openings::Openings::of(&path);
        Ok(Self { master, path, link: None, is_open: false, keeps_dtr: false, dropped: 0, openings })
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
        match std::fs::read_link(link) {
            // What an ended robot left.
            Ok(_) if !link.exists() => std::fs::remove_file(link).map_err(failed)?,
            Ok(port) if port.parent() == self.path.parent() => {
                return Err(PtyError::LinkInUse { path: link.to_owned(), port });
            }
            _ if link.symlink_metadata().is_ok() => {
                return Err(PtyError::LinkTaken { path: link.to_owned() });
            }
            _ => {}
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
        let told = self.openings.take();
        let flags = self.poll(1_u16.into())?;
        if flags.contains(PollFlags::POLLHUP) {
            if told || self.is_open {
                let bytes = self.read(room)?;
                let kept = self.keeps_dtr;
                // A session that was seen was noted then: by now the next host may
                // have set the port up.
                if !self.is_open {
                    self.note_hang_up();
                }
                // A closed serial port forgets what nobody read.
                self.is_open = self.flush()?;
                let opened = told || self.is_open;
                // Opened since the closing that this is about, or before it.
                let kept = if told { kept } else { self.keeps_dtr };
                return Ok(Happened { opened, dtr_rose: opened && !kept, bytes });
            }
            // Poll returns at once while nobody has the port open.
            std::thread::sleep(std::time::Duration::from_millis(1));
            return Ok(Happened::default());
        }
        let opened = told || !self.is_open;
        let dtr_rose = opened && !self.keeps_dtr;
        self.is_open = true;
        self.note_hang_up();
        let bytes = if flags.contains(PollFlags::POLLIN) { self.read(room)? } else { Vec::new() };
        Ok(Happened { opened, dtr_rose, bytes })
    }

    /// Notes what a closing would do to DTR.
    fn note_hang_up(&mut self) {
        if let Ok(settings) = tcgetattr(&self.master) {
            self.keeps_dtr = !settings.control_flags.contains(ControlFlags::HUPCL);
        }
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
    fn flush(&mut self) -> Result<bool, PtyError> {
        let flags = OFlag::O_RDWR | OFlag::O_NOCTTY | OFlag::O_NONBLOCK | OFlag::O_CLOEXEC;
        match open(&self.path, flags, Mode::empty()) {
            Ok(slave) => {
                // A host that opened it just now loses nothing: it is being reset.
                let _ = tcflush(&slave, FlushArg::TCIOFLUSH);
            }
            // A killed host left its exclusive claim, which a serial port would
            // have forgotten: nobody could ever open this one again.
            Err(Errno::EBUSY) => return self.renew().map(|()| false),
            Err(_) => {}
        }
        self.openings.take();
        Ok(!self.poll(PollTimeout::ZERO)?.contains(PollFlags::POLLHUP))
    }

    /// Goes on with another pseudo-terminal under the same link.
    fn renew(&mut self) -> Result<(), PtyError> {
        (self.master, self.path) = open_raw()?;
        self.openings = openings::Openings::of(&self.path);
        self.keeps_dtr = false;
        eprintln!("a host ended without releasing the port; it is now {}", self.path.display());
        match self.link.take() {
            Some(link) => {
                let _ = std::fs::remove_file(&link);
                self.link(&link)
            }
            None => Ok(()),
        }
    }
}

/// A master's end, and the path of its raw slave, closed.
fn open_raw() -> Result<(OwnedFd, PathBuf), PtyError> {
    let failed = |action| move |source| PtyError::Terminal { action, source };
    let pair = openpty(None, None).map_err(failed("open"))?;
    let path = ttyname(&pair.slave).map_err(failed("name"))?;
    // Raw from the start: a program that opens the port without setting it
    // up must not get its own bytes echoed.
    let mut settings = tcgetattr(&pair.slave).map_err(failed("read the settings of"))?;
    cfmakeraw(&mut settings);
    // As on a serial port that nobody set up: a closing lowers DTR.
    settings.control_flags.insert(ControlFlags::HUPCL);
    tcsetattr(&pair.slave, SetArg::TCSANOW, &settings).map_err(failed("set up"))?;
    fcntl(&pair.master, FcntlArg::F_SETFL(OFlag::O_NONBLOCK)).map_err(failed("set up"))?;
    fcntl(&pair.master, FcntlArg::F_SETFD(FdFlag::FD_CLOEXEC)).map_err(failed("set up"))?;
    Ok((pair.master, path))
}

#[cfg(target_os = "linux")]
mod openings {
    use nix::sys::inotify::{AddWatchFlags, InitFlags, Inotify};
    use std::path::Path;

    /// What the system tells of openings; nothing where it has no more watches to give.
    #[derive(Debug)]
    pub struct Openings(Option<Inotify>);

    impl Openings {
        pub fn of(path: &Path) -> Self {
            let watch = || {
                let watch = Inotify::init(InitFlags::IN_NONBLOCK | InitFlags::IN_CLOEXEC)?;
                watch.add_watch(path, AddWatchFlags::IN_OPEN)?;
                Ok::<_, nix::errno::Errno>(watch)
            };
            Self(watch().ok())
        }

        /// Whether there was one since the last call.
        pub fn take(&self) -> bool {
            self.0.as_ref().is_some_and(|watch| watch.read_events().is_ok_and(|events| !events.is_empty()))
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod openings {
    use std::path::Path;

    /// Nothing: here an opening is seen only by the port being open.
    #[derive(Debug)]
    pub struct Openings;

    impl Openings {
        pub fn of(_path: &Path) -> Self {
            Self
        }

        pub fn take(&self) -> bool {
            false
        }
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
