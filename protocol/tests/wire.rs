//! Golden bytes of every message: a change here is a new protocol version.

use protocol::calibration::CalibrationError;
use protocol::command::{
    ActiveGait, CalibrationSource, HelloReply, Limits, Record, Status, Storage, StoredGait,
};
use protocol::frame::{MAX_FRAME_LEN, Request, encode, unframe};
use protocol::gait::{GaitError, GaitTable, MAX_ENCODED_LEN};
use protocol::{
    Amplitude, Angle, Chunk, Command, Event, Fault, JointCurve, Message, Name, Refusal, Reply, ResetCause,
    Speed, State, Telemetry, WalkEnd,
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
    // What robots read and write with is another program: it must be the same format.
    assert_eq!(protocol::wire::from_bytes::<T>(bytes).as_ref(), Ok(message));
    let mut frame_buffer = [0; MAX_FRAME_LEN];
    let mut frame = encode(message, &mut frame_buffer).expect("fits").to_vec();
    let end = frame.len() - 1;
    assert_eq!(unframe(&mut frame[..end]), Ok(&*bytes), "{message:?}");
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
    command(Command::Hello { protocol_version: 3 }, "2a0003");
    command(Command::Status, "2a01");
    command(Command::UploadBegin { len: 251 }, "2a02fb01");
    command(Command::UploadChunk { offset: 64, data: Chunk::of(&[1, 0, 2]) }, "2a034003010002");
    command(Command::UploadCommit { amplitude: amplitude(2.2), persist: true }, "2a04e68c0101");
    command(Command::CalibrationCommit, "2a05");
    command(Command::Read { record: Record::Gait, offset: 192 }, "2a0600c001");
    command(Command::Read { record: Record::Calibration, offset: 0 }, "2a060100");
    command(Command::Read { record: Record::LastTrial, offset: 5 }, "2a060205");
    command(
        Command::Walk { amplitude: None, frames: Some(720), detached: true, dry_run: false },
        "2a070001d0050100",
    );
    command(
        Command::Walk { amplitude: Some(Amplitude::MAX), frames: None, detached: false, dry_run: true },
        "2a070180c001000001",
    );
    command(Command::Stop, "2a08");
    command(Command::SetAmplitude(Amplitude::ONE), "2a098040");
    command(Command::SetSpeed(Speed::MAX), "2a0a808001");
    command(Command::SetSpeed(Speed::PAUSED), "2a0a00");
    command(Command::StreamTelemetry { every_frames: 1 }, "2a0b01");
    command(Command::ClearFault, "2a0c");
    command(Command::Stream, "2a0d");
    command(Command::Setpoints { data: Chunk::of(&[0xD2, 0xFF]) }, "2a0e02d2ff");
    command(Command::StoredGait { slot: 2 }, "2a0f02");
    command(Command::SelectGait { slot: 1 }, "2a1001");
    command(Command::EraseGait { slot: 0 }, "2a1100");
    command(Command::Nudge { channel: 7, counts: 330 }, "2a1207ca02");
}

#[test]
fn replies_keep_their_bytes() {
    let limits = Limits {
        frame_rate_hz: 60,
        max_gait_len: 264,
        max_chunk_len: 64,
        min_amplitude: Amplitude::MIN,
        max_amplitude: Amplitude::MAX,
        gait_slots: 3,
        stream_capacity: 4,
    };
    let hello = HelloReply {
        protocol_version: 3,
        firmware_version: [0, 1, 0],
        limits,
        reset_cause: ResetCause::External,
    };
    reply(Reply::Hello(hello), "002a00030001003c880240802080c001030401");
    reply(Reply::Refused(Refusal::ProtocolVersion { robot: 3 }), "002a010003");
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
            calibration: CalibrationSource::Stored,
            bus_mv: 6000,
            reset_cause: ResetCause::BrownOut,
            uptime_frames: 3600,
            stack_left: 400,
            bad_frames: 3,
            dropped_bytes: 200,
            bus_errors: 1,
        }),
        "002a0306010177616c6b000000000000000000000000effdb6f50de68c010201f02e02901c900303c80101",
    );
    reply(
        Reply::Status(Status {
            state: State::Idle,
            gait: None,
            storage: Storage::RamOnly,
            calibration: CalibrationSource::Default,
            bus_mv: 0,
            reset_cause: ResetCause::PowerOn,
            uptime_frames: 0,
            stack_left: 0,
            bad_frames: 0,
            dropped_bytes: 0,
            bus_errors: 0,
        }),
        "002a030100000000000000000000",
    );
    reply(Reply::Piece(Chunk::of(&[7, 8])), "002a04020708");
    reply(Reply::Buffered(4), "002a0504");
    reply(Reply::Stored(None), "002a0600");
    let stored =
        StoredGait { name: Name::new("walk").expect("a name"), amplitude: amplitude(2.2), at_start: true };
    reply(Reply::Stored(Some(stored)), "002a060177616c6b000000000000000000000000e68c0101");
}

#[test]
fn refusals_keep_their_bytes() {
    for (refusal, hex) in [
        (Refusal::Unknown, "002a0101"),
        (Refusal::UploadRange, "002a0102"),
        (Refusal::UploadIncomplete, "002a0103"),
        (Refusal::BadGait(GaitError::Crc), "002a010401"),
        (Refusal::BadGait(GaitError::JointLimits(3)), "002a01040403"),
        (Refusal::BadGait(GaitError::Kind), "002a010405"),
        (Refusal::BadGait(GaitError::Rows), "002a010406"),
        (Refusal::BadGait(GaitError::Step), "002a010407"),
        (Refusal::Amplitude, "002a0105"),
        (Refusal::NoGait, "002a0106"),
        (Refusal::Faulted(Fault::Watchdog), "002a010702"),
        (Refusal::Faulted(Fault::Undervoltage), "002a010703"),
        (Refusal::Faulted(Fault::Overcurrent), "002a010704"),
        (Refusal::AlreadyWalking, "002a0108"),
        (Refusal::ChipMissing(Fault::ServoDriverLost), "002a010900"),
        (Refusal::StorageBusy, "002a010a"),
        (Refusal::SupplyTooLow { bus_mv: 4500 }, "002a010b9423"),
        (Refusal::StorageFull, "002a010c"),
        (Refusal::NoSuchGait, "002a010d"),
        (Refusal::BadCalibration(CalibrationError::Length), "002a010e00"),
        (Refusal::BadCalibration(CalibrationError::Channel(7)), "002a010e0107"),
        (Refusal::BadCalibration(CalibrationError::Pulse(0)), "002a010e0200"),
        (Refusal::BadCalibration(CalibrationError::Board), "002a010e03"),
        (Refusal::ServosOn, "002a010f"),
        (Refusal::StreamFull, "002a0110"),
        (Refusal::NoStream, "002a0111"),
        (Refusal::Range, "002a0112"),
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
    golden::<Message>(&Message::Telemetry(telemetry), "01e80703d0053fb496000000000002808002dc2e97c00101");
    let stopping = Telemetry { state: State::Stopping, ..telemetry };
    golden::<Message>(&Message::Telemetry(stopping), "01e80704d0053fb496000000000002808002dc2e97c00101");
    golden::<Message>(&Message::Event(Event::Started(ResetCause::Watchdog)), "020003");
    golden::<Message>(&Message::Event(Event::Fault(Fault::ServoDriverLost)), "020100");
    for (end, hex) in [
        (WalkEnd::Finished, "020200"),
        (WalkEnd::Asked, "020201"),
        (WalkEnd::LinkLost, "020202"),
        (WalkEnd::StopByte, "020203"),
        (WalkEnd::Button, "020204"),
        (WalkEnd::StreamDry, "020205"),
        (WalkEnd::Fault(Fault::Overcurrent), "02020604"),
    ] {
        golden::<Message>(&Message::Event(Event::WalkEnded(end)), hex);
    }
}

fn frame(request: &Request) -> String {
    let mut buffer = [0; MAX_FRAME_LEN];
    encode(request, &mut buffer).expect("fits").iter().map(|b| format!("{b:02x}")).collect()
}

#[test]
fn the_frame_around_a_command_keeps_its_bytes() {
    assert_eq!(frame(&Request { seq: 0, command: Command::Hello { protocol_version: 3 } }), "0101040357f400");
}

/// 0xD2, 2, 0 and CRC 0xCFCB: the code byte before each tells which of the two it was.
#[test]
fn a_stop_byte_and_a_zero_in_a_frame_keep_their_code_bytes() {
    assert_eq!(frame(&Request { seq: 0xD2, command: Command::UploadBegin { len: 0 } }), "81020203cbcf00");
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

    assert_eq!(bytes.len(), 251);
    let head: String = bytes[..29].iter().map(|b| format!("{b:02x}")).collect();
    assert_eq!(head, "00676f6c64656e0000000000000000000087d6120000180002".to_owned() + "00c90037");
    // A message followed by its CRC-32 leaves this residue, whatever the message.
    assert_eq!(protocol::crc::crc32(bytes), 0x2144_DF1C);
    assert_eq!(GaitTable::decode(bytes), Ok(table()));
}

/// Robots find each field by its place: postcard is what the places must be.
#[test]
fn tables_are_postcard_whatever_their_period() {
    for period_us in [100_000, 123_456, 2_097_151, 2_097_152, 60_000_000] {
        let table = GaitTable { period_us, ..table() };
        let mut buffer = [0; MAX_ENCODED_LEN];
        let encoded = table.encode(&mut buffer).expect("a valid table").to_vec();

        let mut buffer = [0; MAX_ENCODED_LEN];
        let by_postcard = postcard::to_slice(&(0_u8, table), &mut buffer).expect("encodes").to_vec();
        assert_eq!(encoded[..encoded.len() - 4], by_postcard);
        assert_eq!(GaitTable::decode(&encoded), Ok(table));
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
