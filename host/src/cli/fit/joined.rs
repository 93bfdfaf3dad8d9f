//! The stride with each of the two seams, for comparison.
//!
//! Holds the curves, and the servo speeds that they need at amplitude 1.0 and at the
//! policy's own stroke. The gait gets the seam of [`Seams::taken`]. Does not depend on
//! a robot.

use crate::gait::fit::speeds::{PeakSpeed, peak_speeds};
use crate::gait::fit::{self, JointFit, Scale, Seam};
use crate::gait::gait_file::GaitFile;
use crate::gait::gait_player::Playable;
use crate::sim::ant_env::ACTION_DEG;
use protocol::{Amplitude, JOINT_COUNT};

/// A stride joined in one way.
pub struct Joined {
    pub fits: [JointFit; JOINT_COUNT],
    /// As the robot has it.
    pub playable: Playable,
    pub at_one: [PeakSpeed; JOINT_COUNT],
    pub at_own_stroke: Option<[PeakSpeed; JOINT_COUNT]>,
}

impl Joined {
    pub fn new(fits: [JointFit; JOINT_COUNT], playable: Playable, own_stroke: Option<Amplitude>) -> Self {
        let at_one = peak_speeds(&playable, Amplitude::ONE);
        let at_own_stroke = own_stroke.map(|amplitude| peak_speeds(&playable, amplitude));
        Self { fits, playable, at_one, at_own_stroke }
    }
}

/// Both ways.
pub struct Seams {
    seam: Seam,
    pub taken: Joined,
    /// None where that gait would not fit a table.
    pub other: Option<Joined>,
    /// The amplitude that makes the policy's own stroke, if the robot has it.
    pub own_stroke: Option<Amplitude>,
}

impl Seams {
    /// Joins the rows of `taken` in the other way, too; `gait` is the taken one.
    pub fn new(
        seam: Seam,
        taken: Joined,
        rows: &[[f64; JOINT_COUNT]],
        scale: &Scale,
        gait: &GaitFile,
    ) -> Self {
        let own_stroke = own_stroke(scale);
        let joined = |seam| {
            let fits = fit::fit(rows, scale, seam).ok()?;
            let gait = GaitFile { joints: fits.clone().map(|fit| fit.series), ..gait.clone() };
            let playable = Playable::from_bytes(&gait.encoded().ok()?).ok()?;
            Some(Joined::new(fits, playable, own_stroke))
        };
        let other = match seam {
            Seam::Free => Seam::Continuous,
            Seam::Continuous => Seam::Free,
        };
        Self { seam, taken, other: joined(other), own_stroke }
    }

    /// The stride with that seam, if there is such a gait.
    pub fn with(&self, seam: Seam) -> Option<&Joined> {
        if seam == self.seam { Some(&self.taken) } else { self.other.as_ref() }
    }

    pub const fn seam(&self) -> Seam {
        self.seam
    }
}

/// Where a robot's degrees per unit of action are the simulation's again. None
/// for columns that are no actions, or of another kind of scale.
pub fn own_stroke(scale: &Scale) -> Option<Amplitude> {
    Amplitude::from_f64(ACTION_DEG / scale.unit_deg)
}
