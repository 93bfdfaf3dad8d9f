//! Messages: requests in; answers, events and telemetry out.
//!
//! Holds when each is sent. Does not depend on what a request does, which is in
//! [`super::commands`], nor on framing, which is in [`crate::link`].

use protocol::{Event, Refusal, Reply, Telemetry};

use super::App;
use crate::hal::Board;
use crate::link::{self, Incoming, Message};

impl App {
    pub(super) const fn stream_every(&mut self, frames: u8) {
        self.telemetry_every = frames;
        self.telemetry_in = 0;
    }

    #[inline(never)]
    pub(super) fn send_telemetry(&mut self, board: &mut impl Board) {
        if self.telemetry_every == 0 {
            return;
        }
        self.telemetry_in = self.telemetry_in.saturating_sub(1);
        if self.telemetry_in > 0 {
            return;
        }
        self.telemetry_in = self.telemetry_every;
        let telemetry = Telemetry {
            uptime_frames: self.uptime_frames,
            state: self.state(),
            trial_frames: self.trial.frames,
            trial_energy_uj: self.trial.energy_uj,
            clipped_frames: self.trial.clipped_frames,
            phase: self.live.phase,
            bus_mv: self.sample.bus_mv(),
            current_ua: self.sample.current_ua(),
            missed_samples: self.trial.missed_samples,
        };
        link::send(board.serial(), &Message::Telemetry(&telemetry));
    }

    #[inline(never)]
    pub(super) fn listen(&mut self, board: &mut impl Board) {
        // One request a turn: the bus and the next frame are looked at between them.
        let Some(heard) = self.link.listen(board.serial()) else { return };
        if !matches!(heard, Incoming::Unknown(_)) {
            self.silent_frames = 0;
        }
        let (seq, outcome) = match heard {
            Incoming::Command(seq, command) => {
                self.streamed = matches!(command, link::Command::Setpoints { .. });
                let Some(outcome) = self.obey(board, seq, &command) else { return };
                self.link.remember(outcome);
                (seq, outcome)
            }
            Incoming::Repeat(seq, outcome) => (seq, outcome),
            Incoming::Unknown(seq) => (seq, Err(Refusal::Unknown)),
        };
        let reply = match outcome {
            Err(refusal) => Reply::Refused(refusal),
            Ok(()) if self.streamed => Reply::Buffered(self.upload.waiting()),
            Ok(()) => Reply::Done,
        };
        link::answer(board.serial(), seq, &reply);
    }

    pub(super) fn tell(&mut self, event: Event) {
        // Four at once never happen within a message's time; the newest counts.
        if self.events.is_full() {
            self.events.pop_front();
        }
        let _ = self.events.push_back(event);
    }

    #[inline(never)]
    pub(super) fn report(&mut self, board: &mut impl Board) {
        if let Some(&event) = self.events.front()
            && link::send(board.serial(), &Message::Event(event))
        {
            self.events.pop_front();
        }
    }
}
