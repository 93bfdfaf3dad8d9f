//! A noisy cable: whole frames come through, damaged ones never do.

use proptest::prelude::*;
use protocol::command::Record;
use protocol::crc::crc16;
use protocol::frame::{Decoder, FrameError, MAX_FRAME_LEN, Request, STOP_BYTE, encode, parse};
use protocol::{Amplitude, Chunk, Command, Message, Reply, Speed};

fn framed(request: &Request) -> Vec<u8> {
    encode(request, &mut [0; MAX_FRAME_LEN]).expect("every request fits a frame").to_vec()
}

fn received(bytes: &[u8]) -> Vec<Result<Request, FrameError>> {
    let mut decoder = Decoder::new();
    bytes.iter().filter_map(|&byte| decoder.push(byte).map(|body| body.and_then(parse))).collect()
}

#[test]
fn the_longest_messages_fit_a_frame() {
    let chunk = Chunk::of(&[0xA5; 64]);
    let upload = Request { seq: 255, command: Command::UploadChunk { offset: u16::MAX, data: chunk } };
    assert!(framed(&upload).len() <= MAX_FRAME_LEN);

    let answer = Message::Reply { seq: 255, reply: Reply::Piece(chunk) };
    assert!(encode(&answer, &mut [0; MAX_FRAME_LEN]).is_ok());
}

#[test]
fn an_overlong_frame_is_dropped_and_the_next_one_read() {
    let good = Request { seq: 7, command: Command::Stop };
    let mut bytes = vec![1; 3 * MAX_FRAME_LEN];
    bytes.push(0);
    bytes.extend(framed(&good));

    assert_eq!(received(&bytes), [Err(FrameError::TooLong), Ok(good)]);
}

#[test]
fn a_valid_frame_of_another_version_is_named_as_such() {
    let mut bytes = encode(&[9_u8, 200, 1, 2], &mut [0; MAX_FRAME_LEN]).expect("fits").to_vec();
    bytes.extend(framed(&Request { seq: 1, command: Command::Status }));

    let results = received(&bytes);

    assert_eq!(results[0], Err(FrameError::Meaning));
    assert!(results[1].is_ok());
}

#[test]
fn silence_between_frames_is_no_frame() {
    assert_eq!(received(&[0, 0, 0]), []);
}

fn any_piece() -> impl Strategy<Value = Chunk> {
    prop::collection::vec(any::<u8>(), 0..=64).prop_map(|bytes| Chunk::of(&bytes))
}

fn any_record() -> impl Strategy<Value = Record> {
    prop_oneof![Just(Record::Gait), Just(Record::Calibration), Just(Record::LastTrial)]
}

fn any_amplitude() -> impl Strategy<Value = Amplitude> {
    (Amplitude::MIN.units()..=Amplitude::MAX.units())
        .prop_map(|units| Amplitude::from_units(units).expect("in range"))
}

fn any_request() -> impl Strategy<Value = Request> {
    let command = prop_oneof![
        any::<u8>().prop_map(|protocol_version| Command::Hello { protocol_version }),
        Just(Command::Status),
        any::<u16>().prop_map(|len| Command::UploadBegin { len }),
        (any::<u16>(), any_piece()).prop_map(|(offset, data)| Command::UploadChunk { offset, data }),
        (any_amplitude(), any::<bool>())
            .prop_map(|(amplitude, persist)| Command::UploadCommit { amplitude, persist }),
        Just(Command::CalibrationCommit),
        (any_record(), any::<u16>()).prop_map(|(record, offset)| Command::Read { record, offset }),
        (prop::option::of(any_amplitude()), prop::option::of(any::<u32>()), any::<bool>(), any::<bool>())
            .prop_map(|(amplitude, frames, detached, dry_run)| Command::Walk {
                amplitude,
                frames,
                detached,
                dry_run
            }),
        Just(Command::Stop),
        any_amplitude().prop_map(Command::SetAmplitude),
        (0..=Speed::MAX.units())
            .prop_map(|units| Command::SetSpeed(Speed::from_units(units).expect("in range"))),
        any::<u8>().prop_map(|every_frames| Command::StreamTelemetry { every_frames }),
        Just(Command::ClearFault),
        Just(Command::Stream),
        any_piece().prop_map(|data| Command::Setpoints { data }),
        any::<u8>().prop_map(|slot| Command::StoredGait { slot }),
        any::<u8>().prop_map(|slot| Command::SelectGait { slot }),
        any::<u8>().prop_map(|slot| Command::EraseGait { slot }),
        (any::<u8>(), any::<u16>()).prop_map(|(channel, counts)| Command::Nudge { channel, counts }),
    ];
    (any::<u8>(), command).prop_map(|(seq, command)| Request { seq, command })
}

/// COBS as Cheshire and Baker (1999) have it, delimiter included: nothing of ours in it.
fn plain_cobs(bytes: &[u8]) -> Vec<u8> {
    let mut frame = Vec::new();
    for run in bytes.split(|&byte| byte == 0) {
        assert!(run.len() < 254, "longer than a frame");
        frame.push(run.len() as u8 + 1);
        frame.extend(run);
    }
    frame.push(0);
    frame
}

/// Body and checksum, as they stand before COBS.
fn unstuffed(request: &Request) -> Vec<u8> {
    let mut body = [0; MAX_FRAME_LEN];
    let body = postcard::to_slice(request, &mut body).expect("fits a frame").to_vec();
    let crc = crc16(&body).to_le_bytes();
    [body, crc.to_vec()].concat()
}

#[test]
fn a_body_of_nothing_but_stop_bytes_arrives_whole_and_without_one() {
    let request =
        Request { seq: STOP_BYTE, command: Command::Setpoints { data: Chunk::of(&[STOP_BYTE; 64]) } };

    let bytes = framed(&request);

    assert!(!bytes.contains(&STOP_BYTE), "{bytes:02x?}");
    assert_eq!(received(&bytes), [Ok(request)]);
}

/// What the receive interrupt does with it: nothing of the frame is lost.
#[test]
fn a_stop_byte_taken_out_of_the_stream_leaves_the_frame_around_it_whole() {
    let request = Request { seq: 9, command: Command::UploadChunk { offset: 3, data: Chunk::of(&[0; 20]) } };
    let whole = framed(&request);

    for at in 0..=whole.len() {
        let mut bytes = whole.clone();
        bytes.insert(at, STOP_BYTE);
        bytes.retain(|&byte| byte != STOP_BYTE);
        assert_eq!(received(&bytes), [Ok(request)]);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, rng_seed: proptest::test_runner::RngSeed::Fixed(2), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_request_survives_the_wire(request in any_request()) {
        prop_assert_eq!(received(&framed(&request)), [Ok(request)]);
    }

    #[test]
    fn no_frame_has_a_stop_byte_or_a_zero_but_its_last(request in any_request()) {
        let bytes = framed(&request);
        prop_assert!(!bytes.contains(&STOP_BYTE), "{:02x?}", bytes);
        prop_assert_eq!(bytes.iter().position(|&byte| byte == 0), Some(bytes.len() - 1));
    }

    #[test]
    fn a_frame_without_stop_bytes_is_plain_cobs(request in any_request()) {
        let unstuffed = unstuffed(&request);
        prop_assume!(!unstuffed.contains(&STOP_BYTE));
        prop_assert_eq!(framed(&request), plain_cobs(&unstuffed));
    }

    #[test]
    fn a_flipped_bit_never_yields_another_request(request in any_request(), at in any::<prop::sample::Index>(), bit in 0..8_u8) {
        let mut bytes = framed(&request);
        let at = at.index(bytes.len());
        bytes[at] ^= 1 << bit;
        bytes.push(0);
        for result in received(&bytes) {
            prop_assert!(result.is_err());
        }
    }

    #[test]
    fn any_bytes_are_taken_without_a_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        received(&bytes);
    }
}
