//! Turns one stride of actions into rows of samples that a robot plays as they are.
//!
//! For trajectories that no degree-10 curve can follow, such as the paper's
//! "original". Holds the resampling to the rows that a robot has room for, and its
//! error. Centre and amplitude are those of [`crate::gait::fit`]: the centre is the
//! mean, and deviations scale about it. Does not depend on files.

use crate::gait::fit::Scale;
use protocol::gait::{MAX_ROWS, STEP_UNITS_PER_DEG, SampledTable};
use protocol::{JOINT_COUNT, Joint, Name};
use thiserror::Error;

/// Largest deviation that a byte's 127 steps of 255/512 degree reach.
const MAX_DEVIATION_DEG: f64 = 63.2;

/// Why a stride cannot be sampled.
#[derive(Debug, Clone, PartialEq, Error)]
// The messages say what each field is.
#[allow(missing_docs)]
pub enum SampleError {
    /// One row is a pose, not a stride.
    #[error("the stride has {rows} rows; a sampled gait needs 2")]
    TooFewRows { rows: usize },
    /// A name that the robot cannot store.
    #[error("{name:?} is not a valid name; a name is 1 to {} printable ASCII characters", Name::CAPACITY)]
    Name { name: String },
    /// Wider than a byte holds.
    #[error(
        "{} swings {deviation_deg:.1} degrees from its mean at amplitude 1.0; a sampled gait holds {MAX_DEVIATION_DEG}",
        .joint.name()
    )]
    Deviation { joint: Joint, deviation_deg: f64 },
    /// The middle of a joint's movement is out of its limits.
    #[error(
        "{} moves about {centre_deg:.1} degrees; its limit is {limit_deg} either way",
        .joint.name()
    )]
    Centre { joint: Joint, centre_deg: f64, limit_deg: f64 },
    /// Another value that no table holds.
    #[error("the stride makes no table: its duration is {period_us} us, its joint limit {limit_deg} degrees")]
    Table {
        /// Duration of the stride.
        period_us: u32,
        limit_deg: f64,
    },
}

/// A sampled gait, and how far it is from the recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampled {
    /// What the robot plays.
    pub table: SampledTable,
    /// Rows of the recording.
    pub recorded_rows: usize,
    /// One step of a sample, in degrees at amplitude 1.0.
    pub step_deg: f64,
    /// Farthest that any joint strays from the recording, in degrees at amplitude 1.0.
    pub worst_deg: f64,
}

/// Samples a stride of equally spaced rows; the last one leads back to the first.
///
/// Up to 27 rows are taken as they are, more are resampled to 27 along straight lines.
///
/// # Errors
/// [`SampleError`], naming the joint and its value.
pub fn sample(
    rows: &[[f64; JOINT_COUNT]],
    scale: &Scale,
    name: &str,
    period_us: u32,
) -> Result<Sampled, SampleError> {
    if rows.len() < 2 {
        return Err(SampleError::TooFewRows { rows: rows.len() });
    }
    let table_name = Name::new(name).ok_or_else(|| SampleError::Name { name: name.into() })?;
    let means: [f64; JOINT_COUNT] = std::array::from_fn(|joint| {
        scale.signs[joint] * rows.iter().map(|row| row[joint]).sum::<f64>() / rows.len() as f64
    });
    let centres_deg = means.map(|mean| scale.centre_unit_deg * mean + scale.centre_offset_deg);
    let recorded_deg: Vec<[f64; JOINT_COUNT]> = rows
        .iter()
        .map(|row| {
            std::array::from_fn(|joint| scale.unit_deg * (scale.signs[joint] * row[joint] - means[joint]))
        })
        .collect();
    for joint in Joint::ALL {
        let deviation_deg = recorded_deg.iter().map(|row| row[joint.index()].abs()).fold(0.0, f64::max);
        if deviation_deg > MAX_DEVIATION_DEG {
            return Err(SampleError::Deviation { joint, deviation_deg });
        }
        let (centre_deg, limit_deg) = (centres_deg[joint.index()], scale.limit_deg);
        if centre_deg.abs() > limit_deg.floor() {
            return Err(SampleError::Centre { joint, centre_deg, limit_deg });
        }
    }
    let played_deg = resampled(&recorded_deg, rows.len().min(MAX_ROWS));
    // Whole degrees on the robot, and never more than was asked.
    let limit_deg = scale.limit_deg.floor() as i8;
    let limits_deg = (-limit_deg, limit_deg);
    let table = SampledTable::quantise(table_name, period_us, limits_deg, &centres_deg, &played_deg)
        .ok_or(SampleError::Table { period_us, limit_deg: scale.limit_deg })?;
    let step_deg = f64::from(table.step) / STEP_UNITS_PER_DEG;
    let quantised_deg: Vec<[f64; JOINT_COUNT]> =
        table.rows.as_slice().iter().map(|row| row.map(|steps| f64::from(steps) * step_deg)).collect();
    Ok(Sampled {
        worst_deg: worst_deg(&recorded_deg, &quantised_deg),
        recorded_rows: rows.len(),
        step_deg,
        table,
    })
}

/// The loop at `count` evenly spaced phases.
fn resampled(rows: &[[f64; JOINT_COUNT]], count: usize) -> Vec<[f64; JOINT_COUNT]> {
    if count == rows.len() {
        return rows.to_vec();
    }
    (0..count).map(|i| interpolated(rows, i as f64 / count as f64)).collect()
}

/// The loop at a phase in 0 to 1, along straight lines.
#[must_use]
pub fn interpolated(rows: &[[f64; JOINT_COUNT]], phase: f64) -> [f64; JOINT_COUNT] {
    let place = phase.rem_euclid(1.0) * rows.len() as f64;
    let row = place as usize % rows.len();
    let (from, to) = (&rows[row], &rows[(row + 1) % rows.len()]);
    let share = place - place.floor();
    std::array::from_fn(|joint| from[joint] + (to[joint] - from[joint]) * share)
}

/// Farthest between the two loops at the recording's own rows.
fn worst_deg(recorded: &[[f64; JOINT_COUNT]], played: &[[f64; JOINT_COUNT]]) -> f64 {
    let stray = |(i, row): (usize, &[f64; JOINT_COUNT])| {
        let there = interpolated(played, i as f64 / recorded.len() as f64);
        row.iter().zip(there).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    recorded.iter().enumerate().map(stray).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::gait_player::Playable;
    use protocol::Amplitude;
    use protocol::gait::MAX_ENCODED_LEN;
    use std::f64::consts::TAU;

    fn scale() -> Scale {
        Scale {
            signs: [1., 1., 1., 1., 1., 1., -1., -1.],
            unit_deg: crate::gait::scale::TABLE_DEG_PER_ACTION,
            centre_unit_deg: crate::gait::scale::POLICY_DEG_PER_ACTION,
            centre_offset_deg: 1.0,
            limit_deg: 55.5,
        }
    }

    /// `rows` rows of a wave about action 0.2, two strides for the knees.
    fn waves(rows: usize) -> Vec<[f64; JOINT_COUNT]> {
        (0..rows)
            .map(|i| {
                std::array::from_fn(|joint| {
                    let strides = if joint < 4 { 1.0 } else { 2.0 };
                    0.2 + 0.5 * (TAU * strides * i as f64 / rows as f64 + joint as f64).sin()
                })
            })
            .collect()
    }

    #[test]
    fn the_angles_are_those_of_the_recording_scaled_about_its_mean() {
        let rows = waves(27);
        let sampled = sample(&rows, &scale(), "waves", 450_000).unwrap();
        let mut buffer = [0; MAX_ENCODED_LEN];
        let playable = Playable::from_bytes(sampled.table.encode(&mut buffer).unwrap()).unwrap();

        for (joint, sign) in [(Joint::Hip2, 1.0), (Joint::Knee3, -1.0)] {
            for (i, row) in rows.iter().enumerate() {
                // Just after the row, where rounding the phase down cannot lead before it.
                let phase = (i * 65_536).div_ceil(27) as u16;
                let asked =
                    playable.encoded().setpoint(joint, phase, Amplitude::from_f64(2.0).unwrap()).deg();
                let expected = 45.0 * sign * 0.2 + 1.0 + 2.0 * 24.0 * sign * (row[joint.index()] - 0.2);
                assert!((asked - expected).abs() < sampled.step_deg + 0.02, "{asked}, {expected}");
            }
        }
    }

    #[test]
    fn up_to_27_rows_are_taken_as_they_are_and_more_are_resampled() {
        let few = sample(&waves(20), &scale(), "few", 450_000).unwrap();
        let many = sample(&waves(270), &scale(), "many", 450_000).unwrap();

        assert_eq!(few.table.rows.as_slice().len(), 20);
        assert!(few.worst_deg <= few.step_deg / 2.0 + 1e-9, "{}", few.worst_deg);
        assert_eq!(many.table.rows.as_slice().len(), MAX_ROWS);
        // The sagitta of 12 degrees over a 13.5th of a turn: 12 (1 - cos(pi / 13.5)).
        assert!((many.worst_deg - 0.32).abs() < 0.1, "{}", many.worst_deg);
    }

    #[test]
    fn limits_are_whole_degrees_and_never_wider_than_asked() {
        let table = sample(&waves(9), &scale(), "limits", 450_000).unwrap().table;

        assert_eq!((table.min_deg, table.max_deg), (-55, 55));
    }

    #[test]
    fn what_no_table_holds_is_refused_by_joint() {
        let refused = |change: fn(&mut Scale)| {
            let mut scale = scale();
            change(&mut scale);
            sample(&waves(9), &scale, "waves", 450_000).unwrap_err().to_string()
        };

        assert!(
            refused(|s| s.unit_deg = 130.0).contains("degrees from its mean at amplitude 1.0; a sampled")
        );
        assert_eq!(
            refused(|s| s.centre_offset_deg = 50.0),
            "hip1 moves about 59.0 degrees; its limit is 55.5 either way"
        );
        let too_few = sample(&waves(9)[..1], &scale(), "waves", 450_000).unwrap_err();
        assert_eq!(too_few, SampleError::TooFewRows { rows: 1 });
        assert!(
            sample(&waves(9), &scale(), "", 450_000).unwrap_err().to_string().contains("is not a valid name")
        );
    }
}
