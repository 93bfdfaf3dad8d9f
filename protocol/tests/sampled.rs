//! Sampled gaits: what is sent is what was meant, and nothing else is taken.

use proptest::prelude::*;
use protocol::gait::{
    Encoded, GaitError, GaitTable, MAX_DEVIATION_DEG, MAX_ENCODED_LEN, MAX_ROWS, Rows, SampledTable,
};
use protocol::{Amplitude, Angle, JOINT_COUNT, Joint, JointCurve, Name};
use serde::Serialize;

type RowsDeg = Vec<[f64; JOINT_COUNT]>;

fn name() -> Name {
    Name::new("sampled").expect("a name")
}

/// Two strides of eight shifted waves, as many rows as asked, at most `stroke_deg` high.
fn waves_deg(rows: usize, stroke_deg: f64) -> RowsDeg {
    let angle = |row: usize, joint: usize| {
        4.0 * core::f64::consts::PI * row as f64 / rows as f64 + 0.7 * joint as f64
    };
    (0..rows).map(|row| core::array::from_fn(|joint| stroke_deg * angle(row, joint).sin())).collect()
}

fn centres_deg() -> [f64; JOINT_COUNT] {
    core::array::from_fn(|joint| 3.5 - joint as f64)
}

fn table(rows_deg: &RowsDeg) -> SampledTable {
    SampledTable::quantise(name(), 2_700_000, (-55, 55), &centres_deg(), rows_deg).expect("a table")
}

fn encoded(table: &SampledTable) -> Vec<u8> {
    table.encode(&mut [0; MAX_ENCODED_LEN]).expect("fits").to_vec()
}

fn taken(bytes: &[u8]) -> Encoded {
    let mut gait = Encoded::EMPTY;
    gait.replace(bytes).expect("a sound gait");
    gait
}

fn refused(bytes: &[u8]) -> GaitError {
    Encoded::default().replace(bytes).expect_err("no sound gait")
}

/// The same bytes with other contents, and a checksum that fits them.
fn forged(bytes: &[u8], forge: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut body = bytes[..bytes.len() - 4].to_vec();
    forge(&mut body);
    let crc = protocol::crc::crc32(&body);
    [body, crc.to_le_bytes().to_vec()].concat()
}

/// Field by field what postcard makes of a plain struct, rows and all.
#[test]
fn an_encoding_is_postcard_of_its_fields() {
    #[derive(Serialize)]
    struct Plain<'a> {
        kind: u8,
        name: Name,
        period: [u8; 4],
        step: u8,
        limits_deg: (i8, i8),
        centres: [[u8; 2]; JOINT_COUNT],
        rows: &'a [[i8; JOINT_COUNT]],
    }
    for rows in [2, 3, 26, MAX_ROWS] {
        let table = table(&waves_deg(rows, 24.0));
        let plain = Plain {
            kind: 1,
            name: table.name,
            period: table.period_us.to_le_bytes(),
            step: table.step,
            limits_deg: (table.min_deg, table.max_deg),
            centres: table.centres.map(|centre| centre.units().to_le_bytes()),
            rows: table.rows.as_slice(),
        };

        let mut buffer = [0; 2 * MAX_ENCODED_LEN];
        let by_postcard = postcard::to_slice(&plain, &mut buffer).expect("fits").to_vec();

        let bytes = encoded(&table);
        assert_eq!(bytes[..bytes.len() - 4], by_postcard);
        assert_eq!(bytes.len(), 45 + JOINT_COUNT * rows);
    }
}

#[test]
fn a_table_keeps_its_bytes() {
    let mut rows_deg = [[0.0; JOINT_COUNT]; 2];
    rows_deg[0][0] = 24.0;
    rows_deg[1][7] = -12.0;

    let bytes = encoded(&table(&rows_deg.to_vec()));

    let hex: String = bytes[..bytes.len() - 4].iter().map(|b| format!("{b:02x}")).collect();
    // 24 degrees over 127 steps are 96.8 units of 1/512 degree: steps of 97.
    assert_eq!(
        hex,
        "0173616d706c6564000000000000000000e0322900".to_owned()
            + "61c937"
            + "8003800280018000"
            + "80ff80fe80fd80fc"
            + "02"
            + "7f00000000000000"
            + "00000000000000c1"
    );
    assert_eq!(protocol::crc::crc32(&bytes), 0x2144_DF1C);
}

#[test]
fn the_authors_27_rows_fit_and_28_do_not() {
    let longest = encoded(&table(&waves_deg(27, 60.0)));
    assert!(longest.len() <= MAX_ENCODED_LEN, "{} bytes", longest.len());

    let rows = waves_deg(MAX_ROWS + 1, 24.0);
    assert_eq!(SampledTable::quantise(name(), 2_700_000, (-55, 55), &centres_deg(), &rows), None);
    assert_eq!(Rows::new(&[[0; JOINT_COUNT]; MAX_ROWS + 1]), None);
}

#[test]
fn what_was_encoded_is_read_back() {
    let table = table(&waves_deg(27, 24.0));

    let gait = taken(&encoded(&table));

    assert!(gait.is_sampled());
    assert_eq!((gait.name(), gait.period_us()), (table.name, table.period_us));
    assert_eq!(gait.bytes(), encoded(&table));
    for joint in Joint::ALL {
        assert_eq!(gait.centre(joint), table.centres[joint.index()]);
        assert_eq!(gait.limited(joint, Angle::from_whole_deg(80)), Angle::from_whole_deg(55));
        assert_eq!(gait.limited(joint, Angle::from_whole_deg(-80)), Angle::from_whole_deg(-55));
        assert_eq!(gait.limited(joint, Angle::from_whole_deg(7)), Angle::from_whole_deg(7));
    }
}

/// Straight lines between the rows, the last one leading back to the first.
fn interpolated_deg(rows_deg: &[[f64; JOINT_COUNT]], joint: usize, phase: u16) -> f64 {
    let place = f64::from(phase) / 65_536.0 * rows_deg.len() as f64;
    let row = place as usize;
    let (from, to) = (rows_deg[row][joint], rows_deg[(row + 1) % rows_deg.len()][joint]);
    from + (to - from) * place.fract()
}

/// Half a step, times the amplitude; beside it what polynomials err by, too:
/// half of 1/256 degree each for centre and result, 2^-13 in the amplitude, and
/// a floor of 2^-17 here.
#[test]
fn every_phase_is_within_half_a_step_of_the_lines_between_the_rows() {
    for (rows, stroke_deg) in [(2, 1.0), (7, 24.0), (27, 24.0), (27, 60.0)] {
        let rows_deg = waves_deg(rows, stroke_deg);
        let table = table(&rows_deg);
        let gait = taken(&encoded(&table));
        for amplitude in [0.5, 1.0, 1.875, 3.0] {
            let quantised = Amplitude::from_f64(amplitude).expect("in range");
            let half_step_deg = f64::from(table.step) / 1024.0;
            let bound_deg = amplitude * half_step_deg + 1.0 / 256.0 + stroke_deg / 8192.0 + 0.001;
            for joint in Joint::ALL {
                for phase in 0..=u16::MAX {
                    let deviation_deg = interpolated_deg(&rows_deg, joint.index(), phase);
                    let exact = centres_deg()[joint.index()] + amplitude * deviation_deg;
                    if exact.abs() > 127.0 {
                        continue;
                    }
                    let error = (gait.setpoint(joint, phase, quantised).deg() - exact).abs();
                    assert!(error <= bound_deg, "{error} degrees, {joint:?}, phase {phase}, {amplitude}");
                }
            }
        }
    }
}

/// The resolution that the module promises: 1/127 of the largest stroke, up to
/// the next 1/512 degree.
#[test]
fn the_largest_stroke_sets_the_step() {
    for stroke_deg in [0.01, 0.5, 10.0, 24.0, 63.2] {
        let mut rows_deg = [[0.0; JOINT_COUNT]; 2];
        rows_deg[1][3] = -stroke_deg;
        let step = table(&rows_deg.to_vec()).step;

        assert!(f64::from(step) * 127.0 >= stroke_deg * 512.0, "{stroke_deg}: step {step}");
        assert!(f64::from(step) <= stroke_deg * 512.0 / 127.0 + 1.0, "{stroke_deg}: step {step}");
    }
}

#[test]
fn what_no_table_holds_is_not_quantised() {
    let quantise = |limits_deg, centres_deg: &[f64; 8], rows_deg: &RowsDeg, period_us| {
        SampledTable::quantise(name(), period_us, limits_deg, centres_deg, rows_deg)
    };
    let (good, still) = (waves_deg(5, 24.0), [0.0; JOINT_COUNT]);
    assert!(quantise((-55, 55), &still, &good, 1_000_000).is_some());

    let with = |value: f64| {
        let mut rows_deg = good.clone();
        rows_deg[4][2] = value;
        rows_deg
    };
    for value in [f64::NAN, f64::INFINITY, -f64::INFINITY, 63.9, -1e300] {
        assert_eq!(quantise((-55, 55), &still, &with(value), 1_000_000), None, "{value}");
    }
    assert_eq!(quantise((-55, 55), &still, &good[..1].to_vec(), 1_000_000), None);
    assert_eq!(quantise((-55, 55), &still, &Vec::new(), 1_000_000), None);
    for centre_deg in [60.0, f64::NAN] {
        assert_eq!(quantise((-55, 55), &[centre_deg; JOINT_COUNT], &good, 1_000_000), None);
    }
    assert_eq!(quantise((55, -55), &still, &good, 1_000_000), None);
    assert_eq!(quantise((-91, 55), &still, &good, 1_000_000), None);
    assert_eq!(quantise((-55, 55), &still, &good, 99_999), None);
}

#[test]
fn damaged_and_forged_bytes_are_refused_and_the_gait_before_stays() {
    let good = encoded(&table(&waves_deg(9, 24.0)));
    let mut gait = taken(&good);
    let mut damaged = good.clone();
    for at in 0..good.len() {
        damaged[at] ^= 0x20;
        assert_eq!(gait.replace(&damaged), Err(GaitError::Crc));
        damaged[at] ^= 0x20;
    }
    for short in 0..good.len() {
        assert!(gait.replace(&good[..short]).is_err());
    }
    assert_eq!(gait.bytes(), good);

    assert_eq!(refused(&forged(&good, |body| body[0] = 2)), GaitError::Kind);
    assert_eq!(refused(&forged(&good, |body| body[1] = 0)), GaitError::Name);
    assert_eq!(refused(&forged(&good, |body| body[17..21].fill(0))), GaitError::Period);
    assert_eq!(refused(&forged(&good, |body| body[21] = 0)), GaitError::Step);
    assert_eq!(refused(&forged(&good, |body| body[22] = 91)), GaitError::JointLimits(0));
    assert_eq!(refused(&forged(&good, |body| body[28..30].fill(0x7F))), GaitError::JointLimits(2));
    assert_eq!(refused(&forged(&good, |body| body[40] = 1)), GaitError::Rows);
    assert_eq!(refused(&forged(&good, |body| body[40] = 28)), GaitError::Rows);
    assert_eq!(refused(&forged(&good, |body| body[40] = 8)), GaitError::Length);
    assert_eq!(refused(&forged(&good, |body| body.push(0))), GaitError::Length);
    assert_eq!(refused(&[0; MAX_ENCODED_LEN + 1]), GaitError::Length);
    assert_eq!(GaitTable::decode(&good), Err(GaitError::Kind));
}

fn polynomial() -> GaitTable {
    let joint = |k: usize| {
        let coefficients = core::array::from_fn(|order| (9.0 - 1.7 * k as f64) / (1.0 + order as f64));
        JointCurve::quantise(2.0 - k as f64, (-55.0, 50.0), &coefficients).expect("fits")
    };
    GaitTable {
        name: name(),
        period_us: 1_234_567,
        unit: Angle::from_whole_deg(24),
        joints: core::array::from_fn(joint),
    }
}

/// Robots evaluate the bytes, hosts the table: it must be the same.
#[test]
fn a_polynomial_says_the_same_as_bytes_and_as_a_table() {
    let table = polynomial();
    let mut buffer = [0; MAX_ENCODED_LEN];
    let gait = taken(table.encode(&mut buffer).expect("fits"));

    assert!(!gait.is_sampled());
    for joint in Joint::ALL {
        let curve = &table.joints[joint.index()];
        assert_eq!(gait.centre(joint), curve.centre);
        for phase in (0..=u16::MAX).step_by(7).chain([u16::MAX]) {
            for amplitude in [Amplitude::MIN, Amplitude::ONE, Amplitude::MAX] {
                let asked = gait.setpoint(joint, phase, amplitude);
                assert_eq!(asked, table.setpoint(joint, phase, amplitude), "{joint:?} at {phase}");
                assert_eq!(gait.limited(joint, asked), curve.limited(asked));
            }
        }
    }
}

/// Wide limits and deviations at the edge of the type, at any amplitude.
#[test]
fn the_widest_deviation_does_not_overflow() {
    let mut rows_deg = vec![[63.2; JOINT_COUNT], [-63.2; JOINT_COUNT]];
    rows_deg.push([MAX_DEVIATION_DEG - 0.8; JOINT_COUNT]);
    let table = SampledTable::quantise(name(), 100_000, (-90, 90), &[89.0; 8], &rows_deg).expect("a table");
    let gait = taken(&encoded(&table));

    for phase in (0..=u16::MAX).step_by(11) {
        let held = gait.limited(Joint::Knee4, gait.setpoint(Joint::Knee4, phase, Amplitude::MAX));
        assert!((-90.0..=90.0).contains(&held.deg()));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, rng_seed: proptest::test_runner::RngSeed::Fixed(3), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn hostile_bytes_neither_panic_nor_escape_the_limits(
        mut body in prop::collection::vec(any::<u8>(), 0..=MAX_ENCODED_LEN),
        honest in any::<bool>(),
        phase in any::<u16>(),
        amplitude in 4096..=24576_u16,
    ) {
        // Half of them get past the first checks, so that the later ones are tried too.
        if let Some(header) = body.first_chunk_mut::<24>().filter(|_| honest) {
            header[0] &= 1;
            header[1..17].copy_from_slice(b"hostile gait 123");
            header[17..21].copy_from_slice(&1_000_000_u32.to_le_bytes());
            header[22] = 200;
            header[23] = 50;
        }
        let crc = protocol::crc::crc32(&body);
        body.extend(crc.to_le_bytes());
        let mut gait = Encoded::EMPTY;
        let _ = gait.replace(&body);
        let amplitude = Amplitude::from_units(amplitude).expect("in range");
        for joint in Joint::ALL {
            let held = gait.limited(joint, gait.setpoint(joint, phase, amplitude));
            prop_assert!((-90.0..=90.0).contains(&held.deg()));
        }
    }

    /// Any samples in a table that is otherwise sound.
    #[test]
    fn any_samples_are_played_within_the_limits(
        rows in prop::collection::vec(prop::array::uniform8(any::<u8>()), 2..=MAX_ROWS),
        step in 1..=255_u8,
        phase in any::<u16>(),
    ) {
        let good = encoded(&table(&waves_deg(rows.len(), 24.0)));
        let forged = forged(&good, |body| {
            body[21] = step;
            body[41..].copy_from_slice(&rows.concat());
        });
        let mut gait = Encoded::EMPTY;
        prop_assert_eq!(gait.replace(&forged), Ok(()));
        for joint in Joint::ALL {
            let held = gait.limited(joint, gait.setpoint(joint, phase, Amplitude::MAX));
            prop_assert!((-55.0..=55.0).contains(&held.deg()));
        }
    }
}
