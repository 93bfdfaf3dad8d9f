//! The learning curve as TensorBoard reads it: `tensorboard --logdir runs`.
//!
//! Holds the event file's bytes: records of a length, its checksum, a protobuf
//! `Event` and its checksum. Does not depend on a protobuf library: four fields are
//! written. The file is written as a whole when a run starts or resumes, so that no
//! evaluation is in it twice, and appended to from then on, because TensorBoard keeps
//! it open.

use super::curve::CurvePoint;
use crate::run_folder::{self, FileError};
use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// The file in the run folder; TensorBoard looks for "tfevents" in the name.
pub const EVENTS: &str = "events.out.tfevents.psto";

/// An event file that grows by one evaluation at a time.
#[derive(Debug)]
pub struct EventFile {
    path: PathBuf,
    file: File,
    /// Start of the run, as if it had never been interrupted.
    began: SystemTime,
}

impl EventFile {
    /// Writes the evaluations so far, of a run that has taken `wall_s`, and stays open for more.
    ///
    /// # Errors
    /// [`FileError`] if the file cannot be written.
    pub fn create(folder: &Path, curve: &[CurvePoint], wall_s: f64) -> Result<Self, FileError> {
        let path = folder.join(EVENTS);
        let now = SystemTime::now();
        // A damaged checkpoint may hold any number; time then counts from now.
        let began = Duration::try_from_secs_f64(wall_s).ok().and_then(|past| now.checked_sub(past));
        let began = began.unwrap_or(now);
        let mut bytes = record(&version(began));
        for point in curve {
            bytes.extend(record(&event(began, point)));
        }
        run_folder::write(&path, &bytes)?;
        let file = OpenOptions::new().append(true).open(&path).map_err(FileError::on("write", &path))?;
        Ok(Self { path, file, began })
    }

    /// Adds one evaluation.
    ///
    /// # Errors
    /// [`FileError`] if the file cannot be written.
    pub fn append(&mut self, point: &CurvePoint) -> Result<(), FileError> {
        // One write, so that a reader sees whole records.
        self.file.write_all(&record(&event(self.began, point))).map_err(FileError::on("write", &self.path))
    }
}

/// A record of one event.
fn record(event: &[u8]) -> Vec<u8> {
    let length = (event.len() as u64).to_le_bytes();
    let mut bytes = length.to_vec();
    bytes.extend(masked_crc(&length).to_le_bytes());
    bytes.extend(event);
    bytes.extend(masked_crc(event).to_le_bytes());
    bytes
}

/// TensorFlow's masked checksum: CRC-32C, rotated and offset, because a CRC of data
/// that contains its own CRC is weak.
fn masked_crc(bytes: &[u8]) -> u32 {
    crc32c::crc32c(bytes).rotate_right(15).wrapping_add(0xa282_ead8)
}

/// The first event of a file, its version.
fn version(began: SystemTime) -> Vec<u8> {
    let mut bytes = Vec::new();
    double(&mut bytes, 1, unix_s(began));
    length_delimited(&mut bytes, 3, b"brain.Event:2");
    bytes
}

/// One evaluation; its step counts updates, as the paper's Figure 3 does.
fn event(began: SystemTime, point: &CurvePoint) -> Vec<u8> {
    let scalars = [
        ("evaluation/reward", point.reward),
        ("evaluation/speed_m_s", point.speed_m_s),
        ("evaluation/episode_steps", point.episode_steps),
        ("learning/critic_loss", point.critic_loss),
        ("learning/actor_loss", point.actor_loss),
        ("learning/q_mean", point.q_mean),
        ("learning/env_steps", point.env_steps as f64),
    ];
    let mut summary = Vec::new();
    for (tag, value) in scalars {
        let mut scalar = Vec::new();
        length_delimited(&mut scalar, 1, tag.as_bytes());
        // Field 2, `simple_value`, four bytes.
        scalar.push(2 << 3 | 5);
        scalar.extend((value as f32).to_le_bytes());
        length_delimited(&mut summary, 1, &scalar);
    }
    let mut bytes = Vec::new();
    double(&mut bytes, 1, unix_s(began) + point.wall_s);
    // Field 2, `step`.
    bytes.push(2 << 3);
    varint(&mut bytes, point.updates);
    length_delimited(&mut bytes, 5, &summary);
    bytes
}

fn unix_s(time: SystemTime) -> f64 {
    time.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs_f64()
}

fn double(bytes: &mut Vec<u8>, field: u8, value: f64) {
    bytes.push(field << 3 | 1);
    bytes.extend(value.to_le_bytes());
}

fn length_delimited(bytes: &mut Vec<u8>, field: u8, content: &[u8]) {
    bytes.push(field << 3 | 2);
    varint(bytes, content.len() as u64);
    bytes.extend(content);
}

/// Protobuf's varint: seven bits a byte, the lowest first.
fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(updates: u64) -> CurvePoint {
        CurvePoint {
            env_steps: 10 * updates,
            updates,
            wall_s: 1.0,
            reward: 12.5,
            speed_m_s: 0.125,
            episode_steps: 300.0,
            critic_loss: 0.5,
            actor_loss: -1.0,
            q_mean: 2.0,
        }
    }

    /// Each record's event, checksums checked.
    fn events(mut bytes: &[u8]) -> Vec<Vec<u8>> {
        let mut events = Vec::new();
        while !bytes.is_empty() {
            let (length, rest) = bytes.split_at(8);
            let (crc, rest) = rest.split_at(4);
            assert_eq!(crc, masked_crc(length).to_le_bytes());
            let (event, rest) = rest.split_at(u64::from_le_bytes(length.try_into().unwrap()) as usize);
            let (crc, rest) = rest.split_at(4);
            assert_eq!(crc, masked_crc(event).to_le_bytes());
            events.push(event.to_vec());
            bytes = rest;
        }
        events
    }

    /// The first bytes that TensorFlow itself writes into every event file: 24
    /// bytes of event, and the checksum of that length.
    #[test]
    fn a_file_begins_as_tensorflows_do() {
        let bytes = record(&version(UNIX_EPOCH));

        assert_eq!(bytes[..12], [24, 0, 0, 0, 0, 0, 0, 0, 0xa3, 0x7f, 0x4b, 0x22]);
        assert_eq!(bytes[12..23], [0x09, 0, 0, 0, 0, 0, 0, 0, 0, 0x1a, 13]);
    }

    #[test]
    fn an_evaluation_is_written_with_its_step_and_its_reward() {
        let event = event(UNIX_EPOCH, &point(300));

        // Wall time 1 s, then step 300 = 0b10_0101100.
        assert_eq!(event[..9], [&[0x09][..], &1.0_f64.to_le_bytes()].concat());
        assert_eq!(event[9..12], [0x10, 0b1010_1100, 0b10]);
        let reward = [b"evaluation/reward".as_slice(), &[0x15], &12.5_f32.to_le_bytes()].concat();
        assert!(event.windows(reward.len()).any(|window| window == reward));
    }

    #[test]
    fn a_resumed_run_has_every_evaluation_once() {
        let folder = tempfile::tempdir().unwrap();
        let read = || events(&std::fs::read(folder.path().join(EVENTS)).unwrap()).len();
        let mut file = EventFile::create(folder.path(), &[], 0.0).unwrap();
        file.append(&point(1)).unwrap();
        file.append(&point(2)).unwrap();
        assert_eq!(read(), 3);

        let mut file = EventFile::create(folder.path(), &[point(1)], 5.0).unwrap();
        file.append(&point(2)).unwrap();

        assert_eq!(read(), 3);
    }
}
