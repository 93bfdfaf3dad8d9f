//! Questions to the person at the robot, before and after each walk.
//!
//! Holds the questions and their answers. A thread reads the line, so that
//! Ctrl-C works while a question is open. Does not depend on how a trial is walked.

use crate::experiment::trial::{Place, Raw, Trial};
use crate::robot::LegScale;
use crate::run_folder::FileError;
use std::io::IsTerminal as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// How often Ctrl-C is checked for.
const TICK: Duration = Duration::from_millis(50);

/// What to do with a trial that comes next.
pub enum Before {
    Walk,
    /// Leave it out; the next call offers it again.
    Skip,
    /// End the session.
    Quit,
}

/// What to do with a trial that was walked.
pub enum After {
    /// Record it.
    Note(Raw),
    /// Discard it, and walk it again.
    Again,
    /// Leave it out; the next call offers it again.
    Skip,
    /// End the session.
    Quit,
}

/// The person at standard input, if there is one.
pub struct Person<'a> {
    /// Legs that the person was last asked to mount.
    legs_on: Option<LegScale>,
    is_there: bool,
    /// Set by Ctrl-C.
    stop: &'a AtomicBool,
}

impl<'a> Person<'a> {
    /// Nobody is there if standard input is not a terminal.
    pub fn at_standard_input(stop: &'a AtomicBool) -> Self {
        Self { legs_on: None, is_there: std::io::stdin().is_terminal(), stop }
    }

    /// Whether anybody can be asked.
    pub const fn is_there(&self) -> bool {
        self.is_there
    }

    /// Whether Ctrl-C was pressed.
    pub fn has_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Before a walk: whether it may begin.
    pub fn before(&mut self, place: Place, number: u32, left: usize) -> Result<Before, FileError> {
        let trial = title(place, number, left);
        if !self.is_there {
            eprintln!("{trial}");
            return Ok(Before::Walk);
        }
        if self.legs_on != Some(place.leg) {
            eprintln!("\nMount legs of {} for the next trials, and check that the robot stands.", place.leg);
            self.legs_on = Some(place.leg);
        }
        eprintln!("\n{trial}");
        let question = "Put the robot on its mark. Enter starts the walk, s skips this trial, q quits: ";
        Ok(match self.ask(question, &["", "s", "q"])?.as_deref() {
            Some("") => Before::Walk,
            Some("s") => Before::Skip,
            _ => Before::Quit,
        })
    }

    /// After a walk: asks what neither robot nor tracker can see, and what to do with a walk that the
    /// robot ended early. `asks_way`: only the person knows whether it went backwards.
    pub fn after(&self, raw: Raw, asks_way: bool) -> Result<After, FileError> {
        if !self.is_there || (!raw.stopped && !raw.fall_unseen && !asks_way) {
            return Ok(After::Note(raw));
        }
        if raw.stopped {
            let question = "The robot refused the walk or ended it early; see the reason above. Enter clears the fault and \
                            walks again, n records it as stopped, s skips this trial, q quits: ";
            return Ok(match self.ask(question, &["", "n", "s", "q"])?.as_deref() {
                Some("") => After::Again,
                Some("n") => After::Note(raw),
                Some("s") => After::Skip,
                _ => After::Quit,
            });
        }
        let raw = Raw { fall_unseen: false, ..raw };
        let (question, answers): (_, &[&str]) = if asks_way {
            (
                "Enter if it walked well, f if it fell, b if it went backwards, r to repeat it: ",
                &["", "f", "b", "r"],
            )
        } else {
            ("Enter if it walked well, f if it fell, r to repeat it: ", &["", "f", "r"])
        };
        Ok(match self.ask(question, answers)?.as_deref() {
            Some("") => After::Note(raw),
            Some("f") => After::Note(Raw { fell: true, ..raw }),
            Some("b") => After::Note(Raw { backwards: true, ..raw }),
            Some(_) => After::Again,
            None => After::Quit,
        })
    }

    /// Prints what was recorded.
    pub fn show(&self, trial: &Trial) {
        match (trial.mark, trial.speed_m_s, trial.cost_of_transport) {
            (Some(mark), ..) => eprintln!("Recorded as: {}. It is left out of the means.", mark.text()),
            (None, Some(speed_m_s), Some(cost)) => {
                eprintln!("Recorded: {speed_m_s:.3} m/s, cost of transport {cost:.3}.");
            }
            _ => {}
        }
    }

    /// One of the answers; `None` at the end of input, and after Ctrl-C.
    fn ask(&self, question: &str, answers: &[&str]) -> Result<Option<String>, FileError> {
        loop {
            discard_typed_ahead();
            eprint!("{question}");
            let Some(said) = self.line()? else {
                eprintln!("");
                return Ok(None);
            };
            if answers.contains(&said.as_str()) {
                return Ok(Some(said));
            }
            let letters: Vec<&str> = answers.iter().copied().filter(|answer| !answer.is_empty()).collect();
            eprintln!("{said:?} is not an answer: press Enter, or type one of {}", letters.join(", "));
        }
    }

    /// What was typed; `None` at the end of input, and after Ctrl-C.
    fn line(&self) -> Result<Option<String>, FileError> {
        let (sender, receiver) = mpsc::channel();
        std::thread::spawn(move || {
            let mut line = String::new();
            let read = std::io::stdin().read_line(&mut line);
            // After Ctrl-C nobody waits for the answer.
            let _ = sender.send(read.map(|bytes| (bytes > 0).then_some(line)));
        });
        loop {
            let answer = receiver.recv_timeout(TICK);
            if self.has_stopped() {
                return Ok(None);
            }
            match answer {
                Ok(read) => {
                    return read
                        .map(|line| line.map(|line| line.trim().to_ascii_lowercase()))
                        .map_err(FileError::on("read", Path::new("standard input")));
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
            }
        }
    }
}

/// Discards keys that were pressed before the question: an Enter among them would start a walk.
fn discard_typed_ahead() {
    #[cfg(unix)]
    {
        use nix::sys::termios::{FlushArg, tcflush};
        // Input that cannot be flushed is not a keyboard.
        let _ = tcflush(std::io::stdin(), FlushArg::TCIFLUSH);
    }
}

/// The trial that comes next, in words.
pub fn title(place: Place, number: u32, left: usize) -> String {
    let Place { method, leg, amplification } = place;
    format!("{} at {amplification:?}x, legs of {leg}, trial {}; {left} left", method.label(), number + 1)
}
