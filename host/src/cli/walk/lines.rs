//! Follows an attached walk, and takes changes that are typed.
//!
//! Holds the progress bar and the words for the changes. A thread reads the lines,
//! because the walk cannot wait for input; it ends with the program. Does not depend on
//! the link.

use crate::cli::ranges;
use crate::device::link::words;
use crate::device::session::Watcher;
use crate::gait::gait_file::limits::as_typed;
use crate::gait::gait_player::Playable;
use indicatif::{ProgressBar, ProgressStyle};
use protocol::{Amplitude, Command, FRAME_RATE_HZ, Refusal, Speed, State};
use std::io::{BufRead as _, IsTerminal as _};
use std::sync::mpsc::{self, Receiver};

/// Lines of standard input as they come.
#[derive(Debug)]
pub struct Lines(Option<Receiver<String>>);

impl Lines {
    /// Reads a terminal, or any other input if `even_if_not_typed`.
    pub fn open(even_if_not_typed: bool) -> Self {
        if !even_if_not_typed && !std::io::stdin().is_terminal() {
            return Self(None);
        }
        let (sender, receiver) = mpsc::channel();
        std::thread::spawn(move || {
            for line in std::io::stdin().lock().lines() {
                let Ok(line) = line else { return };
                if sender.send(line).is_err() {
                    return;
                }
            }
        });
        Self(Some(receiver))
    }

    fn next(&self) -> Option<String> {
        self.0.as_ref()?.try_recv().ok()
    }
}

/// What a line asks for.
fn change(line: &str) -> Result<Command, String> {
    let mut words = line.split_whitespace();
    let number = |text: Option<&str>| {
        let text = text.ok_or("a number is missing: amp 1.8, speed 0.5")?;
        text.replace(',', ".").parse::<f64>().map_err(|_| format!("{text:?} is not a number"))
    };
    match words.next() {
        Some("stop" | "q" | "quit") => Ok(Command::Stop),
        Some("pause") => Ok(Command::SetSpeed(Speed::PAUSED)),
        Some("resume") => Ok(Command::SetSpeed(Speed::ONE)),
        Some("amp") => {
            let amplitude = ranges::amplitude(number(words.next())?).map_err(|e| e.to_string())?;
            Ok(Command::SetAmplitude(amplitude))
        }
        Some("speed") => {
            let speed = ranges::speed(number(words.next())?).map_err(|e| e.to_string())?;
            Ok(Command::SetSpeed(speed))
        }
        _ => Err(format!("{line:?}? Type `amp 1.8`, `speed 0.5`, `pause`, `resume` or `stop`")),
    }
}

/// Shows how far the walk has come, and passes on what is typed.
#[derive(Debug)]
pub struct WalkConsole {
    bar: ProgressBar,
    lines: Lines,
    kept_within: Option<Playable>,
    stop_was_typed: bool,
    amplitude: Option<Amplitude>,
    speed: Option<Speed>,
}

impl WalkConsole {
    /// `frames` is the length of the bar; an amplitude is passed on only if the
    /// gait is `kept_within` its limits at it.
    pub fn new(frames: Option<u32>, is_silent: bool, lines: Lines, kept_within: Option<Playable>) -> Self {
        let bar = if is_silent { ProgressBar::hidden() } else { progress_bar(frames) };
        Self { bar, lines, kept_within, stop_was_typed: false, amplitude: None, speed: None }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// Whether `stop` was typed, and granted.
    pub const fn stop_was_typed(&self) -> bool {
        self.stop_was_typed
    }

    /// The last amplitude that was typed, and granted.
    pub const fn amplitude(&self) -> Option<Amplitude> {
        self.amplitude
    }

    /// The last speed that was typed, and granted.
    pub const fn speed(&self) -> Option<Speed> {
        self.speed
    }

    fn within_limits(&self, command: Command) -> Result<Command, String> {
        let (Command::SetAmplitude(amplitude), Some(gait)) = (&command, &self.kept_within) else {
            return Ok(command);
        };
        gait.check_limits(as_typed(*amplitude)).map_err(|leaves| match leaves.largest {
            Some(largest) => format!("{leaves}; the largest amplitude that fits is {largest}"),
            None => leaves.to_string(),
        })?;
        Ok(command)
    }

    fn say(&self, text: &str) {
        self.bar.suspend(|| eprintln!("{text}"));
    }
}

impl Watcher for &mut WalkConsole {
    fn progress(&mut self, state: State, played: u32) {
        self.bar.set_message(words::state(state));
        if state != State::Entering {
            self.bar.set_position(u64::from(played / FRAME_RATE_HZ));
        }
    }

    fn requested_change(&mut self) -> Option<Command> {
        let line = self.lines.next()?;
        if line.trim().is_empty() {
            return None;
        }
        match change(&line).and_then(|command| self.within_limits(command)) {
            Ok(command) => Some(command),
            Err(text) => {
                self.say(&text);
                None
            }
        }
    }

    fn answered(&mut self, change: Command, refusal: Option<Refusal>) {
        if let Some(refusal) = refusal {
            let text =
                format!("the robot refused to {}: {}", words::command(&change), words::refusal(refusal));
            return self.say(&text);
        }
        match change {
            Command::SetAmplitude(amplitude) => self.amplitude = Some(amplitude),
            Command::SetSpeed(speed) => self.speed = Some(speed),
            Command::Stop => self.stop_was_typed = true,
            _ => {}
        }
    }
}

fn progress_bar(frames: Option<u32>) -> ProgressBar {
    let (bar, template) = match frames {
        Some(frames) => {
            (ProgressBar::new(u64::from(frames / FRAME_RATE_HZ)), "{msg:9} {bar:40} {pos}/{len} s")
        }
        None => (ProgressBar::new_spinner(), "{msg:9} {spinner} {pos} s; Ctrl-C stops"),
    };
    let style = ProgressStyle::with_template(template);
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_is_understood() {
        let amplitude = Amplitude::from_f64(1.8).unwrap();
        for line in ["amp 1.8", "  amp   1,8 "] {
            assert_eq!(change(line), Ok(Command::SetAmplitude(amplitude)));
        }
        assert_eq!(change("pause"), Ok(Command::SetSpeed(Speed::PAUSED)));
        assert_eq!(change("resume"), Ok(Command::SetSpeed(Speed::ONE)));
        assert_eq!(change("speed 2"), Ok(Command::SetSpeed(Speed::MAX)));
        assert_eq!(change("stop"), Ok(Command::Stop));
    }

    #[test]
    fn what_is_not_understood_is_answered_with_what_would_be() {
        assert!(change("faster").unwrap_err().contains("`speed 0.5`"));
        assert_eq!(change("amp x"), Err("\"x\" is not a number".into()));
        assert!(change("amp").unwrap_err().contains("a number is missing"));
        assert!(change("amp 9").unwrap_err().contains("within 0.5 to 3"));
        assert!(change("speed 3").unwrap_err().contains("within 0 to 2"));
    }
}
