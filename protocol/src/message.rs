//! Robot to host: the envelope of answers, samples and events.

use crate::command::{Chunk, Reply};
use crate::telemetry::{Event, Telemetry};
use serde::{Deserialize, Serialize};

/// Everything a robot may send; `D` holds a piece of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Message<D = Chunk> {
    /// The answer to the command with sequence number `seq`. Encoding frozen.
    Reply {
        /// The command's sequence number.
        seq: u8,
        /// The answer.
        reply: Reply<D>,
    },
    /// One sample of the stream.
    Telemetry(Telemetry),
    /// Something happened that nobody asked about.
    Event(Event),
}
