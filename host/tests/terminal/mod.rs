//! The `host` program at a terminal, and somebody who reads and types.

use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

/// Longest that anything is waited for.
const PATIENCE: Duration = Duration::from_secs(30);

/// A program that believes that somebody is there.
pub struct Terminal {
    host: Child,
    keys: File,
    said: Receiver<String>,
    /// What was said and not yet waited for.
    text: String,
}

impl Terminal {
    /// Starts the program; the terminal is its own, so that Ctrl-C reaches it.
    pub fn host(folder: &Path, args: &[&str]) -> Self {
        let pty = nix::pty::openpty(None, None).unwrap();
        let slave = File::from(pty.slave);
        let host = Command::new("setsid")
            .arg("--ctty")
            .arg(assert_cmd::cargo::cargo_bin("host"))
            .current_dir(folder)
            .env("NO_COLOR", "1")
            .args(args)
            .stdin(slave.try_clone().unwrap())
            .stdout(slave.try_clone().unwrap())
            .stderr(slave)
            .spawn()
            .unwrap();
        let keys = File::from(pty.master);
        let mut screen = keys.try_clone().unwrap();
        let (sender, said) = mpsc::channel();
        std::thread::spawn(move || {
            let mut bytes = [0; 1024];
            while let Ok(count) = screen.read(&mut bytes) {
                if count == 0 || sender.send(String::from_utf8_lossy(&bytes[..count]).into_owned()).is_err() {
                    return;
                }
            }
        });
        Self { host, keys, said, text: String::new() }
    }

    /// Types once something was said.
    #[track_caller]
    pub fn after(&mut self, expected: &str, keys: &str) {
        let deadline = Instant::now() + PATIENCE;
        let end = loop {
            if let Some(start) = self.text.find(expected) {
                break start + expected.len();
            }
            match self.said.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
                Ok(more) => self.text.push_str(&more),
                Err(_) => panic!("{expected:?} never came: {}", self.text),
            }
        };
        self.text.drain(..end);
        self.keys.write_all(keys.as_bytes()).unwrap();
    }

    /// How it ended, and what it said last.
    #[track_caller]
    pub fn end(mut self) -> (ExitStatus, String) {
        let deadline = Instant::now() + PATIENCE;
        let status = loop {
            self.text.extend(self.said.try_iter());
            if let Some(status) = self.host.try_wait().unwrap() {
                break status;
            }
            assert!(Instant::now() < deadline, "it does not end: {}", self.text);
            std::thread::sleep(Duration::from_millis(10));
        };
        // The screen ends with the last program that has it.
        self.text.extend(self.said.iter());
        (status, std::mem::take(&mut self.text))
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.host.kill();
        let _ = self.host.wait();
    }
}
