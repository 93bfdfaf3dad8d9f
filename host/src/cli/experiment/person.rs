//! What the person at the robot is asked, before and after each walk.
//!
//! Owns the questions and their answers. A thread reads the line, so that
//! Ctrl-C is heard while a question is open.

use crate::experiment::trial::{Place, Raw, Trial};
use crate::run_folder::FileError;
use std::io::IsTerminal as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

/// How soon a Ctrl-C is heard.
const TICK: Duration = Duration::from_millis(50);

/// What is to happen with a trial.
pub enum Before {
    Walk,
    /// Leave it out for now.
    Skip,
    /// Ends for today.
    Quit,
}

/// What is to become of a walk.
pub enum After {
    /// As it was judged.
    Note(Raw),
    /// It does not count, and is walked again.
    Again,
    /// Leave it out for now.
    Skip,
    /// Ends for today.
    Quit,
}

/// Somebody, or nobody, at standard input.
pub struct Person<'a> {
    /// Legs that the robot has on, as far as was said.
    legs_on: Option<f64>,
    is_there: bool,
    /// Set by Ctrl-C.
    stop: &'a AtomicBool,
}

impl<'a> Person<'a> {
    /// Nobody, where standard input is no terminal.
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
            eprintln!(
                "\nFrom here on: legs of {} L. Mount them, and check that the robot stands.",
                place.leg
            );
            self.legs_on = Some(place.leg);
        }
        eprintln!("\n{trial}");
        let question = "Put the robot on its mark. Enter walks, s leaves this trial out, q ends for today: ";
        Ok(match self.ask(question, &["", "s", "q"])?.as_deref() {
            Some("") => Before::Walk,
            Some("s") => Before::Skip,
            _ => Before::Quit,
        })
    }

    /// After a walk: what neither robot nor tracker can see, and what is to become of a walk that the
    /// robot broke off. `asks_way`: nobody but the person knows whether it went backwards.
    pub fn after(&self, raw: Raw, asks_way: bool) -> Result<After, FileError> {
        if !self.is_there || (!raw.stopped && !raw.fall_unseen && !asks_way) {
            return Ok(After::Note(raw));
        }
        if raw.stopped {
            let question = "The robot broke it off or refused it; why stands above. Enter clears the fault and walks it again, \
                            n notes it as broken off, s leaves it out, q ends for today: ";
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
                "Enter if it walked well, f if it fell, b if it went backwards, r to walk it again: ",
                &["", "f", "b", "r"],
            )
        } else {
            ("Enter if it walked well, f if it fell, r to walk it again: ", &["", "f", "r"])
        };
        Ok(match self.ask(question, answers)?.as_deref() {
            Some("") => After::Note(raw),
            Some("f") => After::Note(Raw { fell: true, ..raw }),
            Some("b") => After::Note(Raw { backwards: true, ..raw }),
            Some(_) => After::Again,
            None => After::Quit,
        })
    }

    /// Says what was noted.
    pub fn told(&self, trial: &Trial) {
        match (trial.mark, trial.speed_m_s, trial.cost_of_transport) {
            (Some(mark), ..) => eprintln!("Noted as: {}. It counts in no mean.", mark.text()),
            (None, Some(speed_m_s), Some(cost)) => {
                eprintln!("Noted: {speed_m_s:.3} m/s, cost of transport {cost:.3}.");
            }
            _ => {}
        }
    }

    /// One of the answers; `None` at the end of input, and after Ctrl-C.
    fn ask(&self, question: &str, answers: &[&str]) -> Result<Option<String>, FileError> {
        loop {
            forget_what_was_typed();
            eprint!("{question}");
            let Some(said) = self.line()? else {
                eprintln!("");
                return Ok(None);
            };
            if answers.contains(&said.as_str()) {
                return Ok(Some(said));
            }
            let letters: Vec<&str> = answers.iter().copied().filter(|answer| !answer.is_empty()).collect();
            eprintln!("{said:?} is neither Enter nor one of {}", letters.join(", "));
        }
    }

    /// What was typed; `None` at the end of input, and after Ctrl-C.
    fn line(&self) -> Result<Option<String>, FileError> {
        let (sender, receiver) = mpsc::channel();
        std::thread::spawn(move || {
            let mut line = String::new();
            let read = std::io::stdin().read_line(&mut line);
            // Nobody waits for it any more after Ctrl-C.
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

/// Keys that were pressed before a question are no answer to it: the robot would walk.
fn forget_what_was_typed() {
    #[cfg(unix)]
    {
        use nix::sys::termios::{FlushArg, tcflush};
        // Of what cannot be flushed nothing was typed at it.
        let _ = tcflush(std::io::stdin(), FlushArg::TCIFLUSH);
    }
}

/// What is to be walked.
pub fn title(place: Place, number: u32, left: usize) -> String {
    let Place { method, leg, amplification } = place;
    format!("{} at {amplification:?}x, legs of {leg} L, trial {}; {left} to go", method.label(), number + 1)
}
