//! Golden bytes of every message: a change here is a new protocol version.

use protocol::command::{ActiveGait, HelloReply, Limits, Status, Storage};
use protocol::frame::{MAX_FRAME_LEN, Request, encode};
use protocol::gait::{GaitError, GaitTable, MAX_ENCODED_LEN};
use protocol::{
    Amplitude, Angle, Chunk, Command, Event, Fault, JointCurve, Message, Name, Refusal, Reply, ResetCause,
    State, Telemetry,
};

#[track_caller]
fn golden<T>(message: &T, hex: &str)
where
    T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + std::fmt::Debug,
{
    let mut buffer = [0; MAX_FRAME_LEN];
    let bytes = postcard::to_slice(message, &mut buffer).expect("fits a frame");
    let written: String = bytes.iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(written, hex, "{message:?}");

    let read: T = postcard::from_bytes(bytes).expect("reads back");
    assert_eq!(&read, message);
}

fn command(command: Command, hex: &str) {
    golden(&Request { seq: 0x2A, command }, hex);
}

fn reply(reply: Reply, hex: &str) {
    golden(&Message::Reply { seq: 0x2A, reply }, hex);
}

fn amplitude(value: f64) -> Amplitude {
    Amplitude::from_f64(value).expect("in range")
}

#[test]
fn commands_keep_their_bytes() {
    command(Command::Hello { protocol_version: 2 }, "2a0002");
    command(Command::Status, "2a01");
    command(Command::UploadBegin { len: 251 }, "2a02fb01");
    command(Command::UploadChunk { offset: 64, data: Chunk::of(&[1, 0, 2]) }, "2a034003010002");
    command(Command::UploadCommit { amplitude: amplitude(2.2), persist: true }, "2a04e68c0101");
    command(Command::ReadGait { offset: 192 }, "2a05c001");
    command(Command::Walk { amplitude: None, frames: Some(720), detached: true }, "2a060001d00501");
    command(
        Command::Walk { amplitude: Some(Amplitude::MAX), frames: None, detached: false },
        "2a060180c0010000",
    );
    command(Command::Stop, "2a07");
    command(Command::SetAmplitude(Amplitude::ONE), "2a088040");
    command(Command::StreamTelemetry { every_frames: 1 }, "2a0901");
    command(Command::ClearFault, "2a0a");
}

#[test]
fn replies_keep_their_bytes() {
    let limits = Limits {
        frame_rate_hz: 60,
        max_gait_len: 256,
        max_chunk_len: 64,
        min_amplitude: Amplitude::MIN,
        max_amplitude: Amplitude::MAX,
    };
    let hello = HelloReply {
        protocol_version: 2,
        firmware_version: [0, 1, 0],
        limits,
        reset_cause: ResetCause::External,
    };
    reply(Reply::Hello(hello), "002a00020001003c800240802080c00101");
    reply(Reply::Refused(Refusal::ProtocolVersion { robot: 2 }), "002a010002");
    reply(Reply::Done, "002a02");
    let gait = ActiveGait {
        name: Name::new("walk").expect("a name"),
        crc32: 0xDEAD_BEEF,
        amplitude: amplitude(2.2),
    };
    reply(
        Reply::Status(Status {
            state: State::Fault(Fault::SensorLost),
            gait: Some(gait),
            storage: Storage::Saved,
            bus_mv: 6000,
            bad_frames: 3,
        }),
        "002a0305010177616c6b000000000000000000000000effdb6f50de68c0102f02e03",
    );
    reply(
        Reply::Status(Status {
            state: State::Idle,
            gait: None,
            storage: Storage::RamOnly,
            bus_mv: 0,
            bad_frames: 0,
        }),
        "002a030100000000",
    );
    reply(Reply::GaitChunk(Chunk::of(&[7, 8])), "002a04020708");
}

#[test]
fn refusals_keep_their_bytes() {
    for (refusal, hex) in [
        (Refusal::Unknown, "002a0101"),
        (Refusal::UploadRange, "002a0102"),
        (Refusal::UploadIncomplete, "002a0103"),
        (Refusal::BadGait(GaitError::Crc), "002a010401"),
        (Refusal::BadGait(GaitError::JointLimits(3)), "002a01040403"),
        (Refusal::Amplitude, "002a0105"),
        (Refusal::NoGait, "002a0106"),
        (Refusal::Faulted(Fault::Watchdog), "002a010702"),
        (Refusal::AlreadyWalking, "002a0108"),
        (Refusal::ChipMissing(Fault::ServoDriverLost), "002a010900"),
        (Refusal::StorageBusy, "002a010a"),
        (Refusal::SupplyTooLow { bus_mv: 4500 }, "002a010b9423"),
        (Refusal::Faulted(Fault::Undervoltage), "002a010703"),
        (Refusal::Faulted(Fault::Overcurrent), "002a010704"),
    ] {
        reply(Reply::Refused(refusal), hex);
    }
}

#[test]
fn telemetry_and_events_keep_their_bytes() {
    let telemetry = Telemetry {
        uptime_frames: 1000,
        state: State::Walking,
        trial_frames: 720,
        trial_energy_uj: 9_876_543,
        clipped_frames: 2,
        phase: 0x8000,
        bus_mv: 5980,
        current_ua: -12_300,
        missed_samples: 1,
    };
    golden::<Message>(&Message::Telemetry(telemetry), "01e80703d005bfe8da0402808002dc2e97c00101");
    golden::<Message>(&Message::Event(Event::Started(ResetCause::Watchdog)), "020003");
    golden::<Message>(&Message::Event(Event::Fault(Fault::ServoDriverLost)), "020100");
    golden::<Message>(&Message::Event(Event::WalkFinished), "0202");
    golden::<Message>(&Message::Event(Event::LinkLost), "0203");
}

#[test]
fn the_frame_around_a_command_keeps_its_bytes() {
    let request: Request = Request { seq: 0, command: Command::Hello { protocol_version: 2 } };

    let frame: String =
        encode(&request, &mut [0; MAX_FRAME_LEN]).expect("fits").iter().map(|b| format!("{b:02x}")).collect();

    assert_eq!(frame, "01010402dee500");
}

#[test]
fn checksums_match_their_published_check_values() {
    assert_eq!(protocol::crc::crc16(b"123456789"), 0x906E);
    assert_eq!(protocol::crc::crc32(b"123456789"), 0xCBF4_3926);
}

fn table() -> GaitTable {
    let joint = |k: usize| {
        let mut coefficients = [0.0; 11];
        coefficients[1] = 10.0 + k as f64;
        coefficients[10] = -0.5;
        JointCurve::quantise(2.0 - k as f64, (-55.0, 55.0), &coefficients).expect("fits")
    };
    GaitTable {
        name: Name::new("golden").expect("a name"),
        period_us: 1_234_567,
        unit: Angle::from_whole_deg(24),
        joints: core::array::from_fn(joint),
    }
}

#[test]
fn a_gait_table_keeps_its_bytes_and_its_length() {
    let mut buffer = [0; MAX_ENCODED_LEN];
    let bytes = table().encode(&mut buffer).expect("a valid table");

    assert_eq!(bytes.len(), 249);
    let head: String = bytes[..27].iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(head, "676f6c64656e0000000000000000000087ad4b0018000200c90037");
    // A message followed by its CRC-32 leaves this residue, whatever the message.
    assert_eq!(protocol::crc::crc32(bytes), 0x2144_DF1C);
    assert_eq!(GaitTable::decode(bytes), Ok(table()));
}

/// The robot reads and writes tables by hand; postcard is what they must be.
#[test]
fn tables_are_postcard_whatever_their_period() {
    for period_us in [100_000, 123_456, 2_097_151, 2_097_152, 60_000_000] {
        let table = GaitTable { period_us, ..table() };
        let mut by_hand = Vec::new();
        table.for_each_byte(|byte| by_hand.push(byte));

        let mut buffer = [0; MAX_ENCODED_LEN];
        assert_eq!(postcard::to_slice(&table, &mut buffer).expect("encodes"), by_hand);
        let crc = protocol::crc::crc32(&by_hand);
        by_hand.extend(crc.to_le_bytes());
        assert_eq!(GaitTable::decode(&by_hand), Ok(table));
    }
}

#[test]
fn the_longest_table_fits_its_limit() {
    let longest = GaitTable { period_us: protocol::gait::MAX_PERIOD_US, ..table() };

    assert!(longest.encode(&mut [0; MAX_ENCODED_LEN]).expect("fits").len() <= MAX_ENCODED_LEN);
}

#[test]
fn a_damaged_table_is_refused() {
    let mut buffer = [0; MAX_ENCODED_LEN];
    let len = table().encode(&mut buffer).expect("a valid table").len();

    for at in 0..len {
        buffer[at] ^= 0x10;
        assert_eq!(GaitTable::decode(&buffer[..len]), Err(GaitError::Crc));
        buffer[at] ^= 0x10;
    }
    for short in 0..len {
        assert!(GaitTable::decode(&buffer[..short]).is_err());
    }
}

#[test]
fn values_out_of_range_are_refused_by_name() {
    let refused = |change: fn(&mut GaitTable)| {
        let mut table = table();
        change(&mut table);
        table.encode(&mut [0; MAX_ENCODED_LEN]).expect_err("a value out of range")
    };

    assert_eq!(refused(|t| t.name = Name::default()), GaitError::Name);
    assert_eq!(refused(|t| t.period_us = 99_999), GaitError::Period);
    assert_eq!(refused(|t| t.joints[5].min = t.joints[5].max), GaitError::JointLimits(5));
    assert_eq!(refused(|t| t.joints[0].max = Angle::from_whole_deg(91)), GaitError::JointLimits(0));
    assert_eq!(refused(|t| t.joints[7].centre = Angle::from_whole_deg(60)), GaitError::JointLimits(7));
}

#[test]
fn a_stride_takes_its_period_and_ends_at_the_start_of_the_next() {
    for frames in [6, 27, 132, 720, 3600] {
        // Rounded down to the microsecond, as a gait file is.
        let table = GaitTable { period_us: frames * 1_000_000 / 60, ..table() };

        let advance = u64::from(table.phase_step()) * u64::from(frames);

        let early = advance.checked_sub(1 << 32).expect("past the stride's end");
        assert!(early < 1 << 16, "{frames} frames: {early} of 65536 to the first phase of all");
    }
}
