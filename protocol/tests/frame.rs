//! A noisy cable: whole frames come through, damaged ones never do.

use proptest::prelude::*;
use protocol::frame::{Decoder, FrameError, MAX_FRAME_LEN, Request, encode, parse};
use protocol::{Amplitude, Chunk, Command, Message, Reply};

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

    let answer = Message::Reply { seq: 255, reply: Reply::GaitChunk(chunk) };
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

fn any_request() -> impl Strategy<Value = Request> {
    let command = prop_oneof![
        any::<u8>().prop_map(|protocol_version| Command::Hello { protocol_version }),
        Just(Command::Status),
        Just(Command::Stop),
        (any::<u16>(), prop::collection::vec(any::<u8>(), 0..=64))
            .prop_map(|(offset, data)| Command::UploadChunk { offset, data: Chunk::of(&data) }),
        (prop::option::of(any::<u32>())).prop_map(|frames| Command::Walk {
            amplitude: Some(Amplitude::ONE),
            frames,
            detached: false
        }),
    ];
    (any::<u8>(), command).prop_map(|(seq, command)| Request { seq, command })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: proptest::test_runner::RngSeed::Fixed(2), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_request_survives_the_wire(request in any_request()) {
        prop_assert_eq!(received(&framed(&request)), [Ok(request)]);
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
