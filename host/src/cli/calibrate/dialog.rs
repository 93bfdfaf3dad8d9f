//! Questions and keys, at a terminal or line by line without one.
//!
//! At a terminal single keys are read, so that a servo follows an arrow key while the
//! robot is kept alive. Without one, each line is a key or an answer, as scripts and
//! tests write them. The terminal's raw mode ends however the dialog ends. Does not
//! depend on what is asked.

use crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use crossterm::terminal;
use std::io::{BufRead as _, IsTerminal as _};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

/// A key, or the line that stands for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// Arrow keys: so many counts, longer pulses positive.
    Step(i32),
    /// Accept.
    Enter,
    /// Any other key.
    Letter(char),
}

/// Why no more answers come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UserExit {
    /// Ctrl-C, Escape or `q`.
    Quit,
    /// No more lines, or a broken terminal.
    InputEnded,
}

/// Standard input and standard error, with a user or a script behind them.
#[derive(Debug)]
pub struct Dialog {
    /// Lines, where there is no terminal.
    lines: Option<Receiver<String>>,
    is_raw: bool,
}

impl Dialog {
    /// Reads keys from a terminal, else lines from standard input.
    pub fn open() -> Self {
        if std::io::stdin().is_terminal() {
            return Self { lines: None, is_raw: false };
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
        Self { lines: Some(receiver), is_raw: false }
    }

    /// Prints a paragraph to standard error.
    pub fn say(&mut self, text: &str) {
        self.set_raw(false);
        eprintln!("{text}");
    }

    /// Shows where a servo is; at a terminal in place of what was shown before.
    pub fn show(&mut self, text: &str) {
        if self.lines.is_none() {
            eprint!("\r\x1b[K{text} ");
        } else {
            eprintln!("{text}");
        }
    }

    /// Ends the line that [`Self::show`] keeps writing.
    pub fn end_show(&mut self) {
        self.set_raw(false);
        if self.lines.is_none() {
            eprintln!("");
        }
    }

    /// Asks for a line.
    pub fn ask(&mut self, question: &str) -> Result<String, UserExit> {
        self.set_raw(false);
        eprint!("{question} ");
        let line = match &self.lines {
            Some(lines) => lines.recv().map_err(|_| UserExit::InputEnded)?,
            None => {
                let mut line = String::new();
                match std::io::stdin().lock().read_line(&mut line) {
                    Ok(count) if count > 0 => line,
                    _ => return Err(UserExit::InputEnded),
                }
            }
        };
        if self.lines.is_some() {
            eprintln!("{line}");
        }
        match line.trim() {
            "q" => Err(UserExit::Quit),
            answer => Ok(answer.to_owned()),
        }
    }

    /// Asks for yes or no; nothing is `default`.
    pub fn agrees(&mut self, question: &str, default: bool) -> Result<bool, UserExit> {
        let choice = if default { "[Y/n]" } else { "[y/N]" };
        loop {
            match self.ask(&format!("{question} {choice}"))?.to_ascii_lowercase().as_str() {
                "" => return Ok(default),
                "y" | "yes" => return Ok(true),
                "n" | "no" => return Ok(false),
                other => self.say(&format!("{other:?}: type y or n")),
            }
        }
    }

    /// Asks for a number within a range; nothing is `default`.
    pub fn number(&mut self, question: &str, default: f64, (min, max): (f64, f64)) -> Result<f64, UserExit> {
        loop {
            let answer = self.ask(&format!("{question} [{default}]"))?;
            if answer.is_empty() {
                return Ok(default);
            }
            // A decimal comma is a habit, not a mistake.
            match answer.replace(',', ".").parse::<f64>() {
                Ok(value) if (min..=max).contains(&value) => return Ok(value),
                Ok(value) => self.say(&format!("{value} is out of range; it must be within {min} to {max}")),
                Err(_) => self.say(&format!("{answer:?} is not a number; type one such as {default}")),
            }
        }
    }

    /// Asks for a whole number up to `max`; nothing is `default`.
    pub fn whole(&mut self, question: &str, default: u8, max: u8) -> Result<u8, UserExit> {
        loop {
            let value = self.number(question, f64::from(default), (0.0, f64::from(max)))?;
            if value.fract() == 0.0 {
                return Ok(value as u8);
            }
            self.say(&format!("{value} is not a whole number"));
        }
    }

    /// The next key, if one comes in time.
    pub fn key(&mut self, timeout: Duration) -> Result<Option<Key>, UserExit> {
        let Some(lines) = &self.lines else { return self.pressed(timeout) };
        match lines.recv_timeout(timeout) {
            Ok(line) => key_of(line.trim()).map(Some),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(UserExit::InputEnded),
        }
    }

    fn pressed(&mut self, timeout: Duration) -> Result<Option<Key>, UserExit> {
        self.set_raw(true);
        if !event::poll(timeout).map_err(|_| UserExit::InputEnded)? {
            return Ok(None);
        }
        let Event::Key(key) = event::read().map_err(|_| UserExit::InputEnded)? else { return Ok(None) };
        if key.kind == KeyEventKind::Release {
            return Ok(None);
        }
        Ok(Some(match key.code {
            KeyCode::Right => Key::Step(1),
            KeyCode::Left => Key::Step(-1),
            KeyCode::Up => Key::Step(10),
            KeyCode::Down => Key::Step(-10),
            KeyCode::Enter => Key::Enter,
            // An Enter that was pressed before the terminal was raw.
            KeyCode::Char('j') if key.modifiers.contains(KeyModifiers::CONTROL) => Key::Enter,
            KeyCode::Esc | KeyCode::Char('q') => return Err(UserExit::Quit),
            KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => {
                return Err(UserExit::Quit);
            }
            KeyCode::Char(letter) => key_of_letter(letter),
            _ => return Ok(None),
        }))
    }

    fn set_raw(&mut self, is_raw: bool) {
        if self.lines.is_some() || is_raw == self.is_raw {
            return;
        }
        let _ = if is_raw { terminal::enable_raw_mode() } else { terminal::disable_raw_mode() };
        self.is_raw = is_raw;
    }
}

impl Drop for Dialog {
    fn drop(&mut self) {
        self.set_raw(false);
    }
}

const fn key_of_letter(letter: char) -> Key {
    match letter {
        '+' => Key::Step(1),
        '-' => Key::Step(-1),
        letter => Key::Letter(letter.to_ascii_lowercase()),
    }
}

fn key_of(line: &str) -> Result<Key, UserExit> {
    let mut letters = line.chars();
    match (letters.next(), letters.next()) {
        (None, _) => Ok(Key::Enter),
        (Some('q'), None) => Err(UserExit::Quit),
        (Some(letter), None) => Ok(key_of_letter(letter)),
        // `+25`, `-3`: so many in one step.
        _ => Ok(line.parse().map_or(Key::Letter('?'), Key::Step)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_stand_for_keys() {
        assert_eq!(key_of(""), Ok(Key::Enter));
        assert_eq!(key_of("+"), Ok(Key::Step(1)));
        assert_eq!(key_of("-"), Ok(Key::Step(-1)));
        assert_eq!(key_of("+25"), Ok(Key::Step(25)));
        assert_eq!(key_of("-3"), Ok(Key::Step(-3)));
        assert_eq!(key_of("Y"), Ok(Key::Letter('y')));
        assert_eq!(key_of("what"), Ok(Key::Letter('?')));
        assert_eq!(key_of("q"), Err(UserExit::Quit));
    }
}
