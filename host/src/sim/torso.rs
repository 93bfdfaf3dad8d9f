//! Position, orientation and velocity of the torso.

/// The torso's frame, in the world's: for the Ant, its middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TorsoState {
    /// In the world's frame.
    pub position_m: [f64; 3],
    /// Unit quaternion from the torso's frame to the world's.
    pub orientation_xyzw: [f64; 4],
    /// In the world's frame.
    pub velocity_m_s: [f64; 3],
    /// In the world's frame.
    pub angular_velocity_rad_s: [f64; 3],
}

impl TorsoState {
    /// Heading, counter-clockwise from the world's x, in -pi to pi.
    #[must_use]
    pub fn yaw_rad(&self) -> f64 {
        let [x, y, z, w] = self.orientation_xyzw;
        (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))
    }

    /// Angle between the torso's z axis and the world's.
    #[must_use]
    pub fn tilt_rad(&self) -> f64 {
        let [x, y, ..] = self.orientation_xyzw;
        (1.0 - 2.0 * (x * x + y * y)).clamp(-1.0, 1.0).acos()
    }
}
