//! A recording as poses, one a frame.

use super::{Args, Programme, check_limits};
use crate::cli::Failure;
use crate::cli::recording::{Chosen, DefaultRows};
use crate::device::stream::PoseDeg;
use crate::gait::sampled_gait::interpolated;
use protocol::FRAME_RATE_HZ;

pub fn programme(args: &Args) -> Result<Programme, Failure> {
    let mut recording = args.recording.clone();
    if args.degrees {
        recording.in_degrees();
    }
    let chosen = recording.choose(DefaultRows::All)?;
    let rows = in_degrees(&chosen, args.amplitude.unwrap_or(1.0))?;
    let rate = f64::from(FRAME_RATE_HZ);
    let once = ((chosen.played_s() * rate).round() as usize).max(1);
    let frames = args.seconds.map_or(once, |seconds| (seconds * rate).round() as usize);
    let stride_s = chosen.played_s();
    let pose = move |frame: usize| {
        let place = frame as f64 / rate / stride_s;
        // Once: between the last row and the end there is nowhere to go.
        let place = if frames <= once { place.min(1.0 - 1.0 / rows.len() as f64) } else { place };
        interpolated(&rows, place)
    };
    let limit_deg = chosen.scale.limit_deg;
    let first_round: Vec<PoseDeg> = (0..frames.min(once)).map(&pose).collect();
    check_limits(args, &first_round, limit_deg)?;
    let name = chosen.path.display().to_string();
    let poses = Box::new((0..frames).map(pose));
    // A day of frames, the longest that can be asked for, is 5 million.
    Ok(Programme { name, poses, frames: frames as u32, limit_deg })
}

/// As a gait file has it: scaled about the mean of each joint.
fn in_degrees(chosen: &Chosen, amplitude: f64) -> Result<Vec<PoseDeg>, Failure> {
    let rows = chosen.actions()?;
    let scale = &chosen.scale;
    let mean = |joint: usize| rows.iter().map(|row| row[joint]).sum::<f64>() / rows.len() as f64;
    let means: [f64; protocol::JOINT_COUNT] = std::array::from_fn(mean);
    Ok(rows
        .iter()
        .map(|row| {
            std::array::from_fn(|joint| {
                let sign = scale.signs[joint];
                let centre_deg = scale.centre_unit_deg * sign * means[joint] + scale.centre_offset_deg;
                centre_deg + amplitude * scale.unit_deg * sign * (row[joint] - means[joint])
            })
        })
        .collect())
}
