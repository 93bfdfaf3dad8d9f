//! Which way a displacement goes; forward is +x.
//!
//! Holds the thresholds and the words of a warning. Does not depend on how the
//! displacement came about.

/// Shorter displacements have no direction: a robot that stands settles by some millimetres.
pub const LEAST_DISTANCE_M: f64 = 0.02;

/// Which way a robot went.
///
/// Forward and backward are within 45 degrees of +x and -x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// Towards +x.
    Forward,
    /// Towards -x.
    Backward,
    /// Nearer to the y axis than to the x axis, either way.
    Sideways,
    /// It moved by less than [`LEAST_DISTANCE_M`], or the displacement is NaN.
    None,
}

impl Direction {
    /// Of a displacement along the world's x and y, in metres.
    #[must_use]
    pub fn of([x_m, y_m]: [f64; 2]) -> Self {
        let distance_m = x_m.hypot(y_m);
        if distance_m.is_nan() || distance_m < LEAST_DISTANCE_M {
            Self::None
        } else if y_m.abs() > x_m.abs() {
            Self::Sideways
        } else if x_m > 0.0 {
            Self::Forward
        } else {
            Self::Backward
        }
    }

    /// How a robot that goes this way walks; none if it does not move.
    #[must_use]
    pub const fn name(self) -> Option<&'static str> {
        match self {
            Self::Forward => Some("forward"),
            Self::Backward => Some("backwards"),
            Self::Sideways => Some("sideways"),
            Self::None => None,
        }
    }
}

/// A warning of a walk that goes backwards or sideways; none of any other.
#[must_use]
pub fn direction_warning(displacement_m: [f64; 2], duration_s: f64) -> Option<String> {
    let direction = Direction::of(displacement_m);
    let name = direction.name().filter(|_| direction != Direction::Forward)?;
    let [x_m, y_m] = displacement_m;
    Some(format!("it walks {name}: x {x_m:.2} m, y {y_m:.2} m in {duration_s} s; forward is +x"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_displacement_goes_where_its_larger_part_goes_and_a_small_one_nowhere() {
        for (displacement_m, direction) in [
            ([3.33, -0.2], Direction::Forward),
            ([-3.33, 0.2], Direction::Backward),
            ([1.0, -1.1], Direction::Sideways),
            ([-0.3, 2.0], Direction::Sideways),
            ([-0.01, 0.01], Direction::None),
            ([f64::NAN, 1.0], Direction::None),
        ] {
            assert_eq!(Direction::of(displacement_m), direction, "{displacement_m:?}");
        }
    }

    #[test]
    fn only_a_walk_that_does_not_go_forward_is_warned_of() {
        let said = direction_warning([-3.331, 0.2], 12.0).unwrap();

        assert_eq!(said, "it walks backwards: x -3.33 m, y 0.20 m in 12 s; forward is +x");
        assert!(direction_warning([0.1, 2.0], 12.0).is_some_and(|said| said.contains("sideways")));
        assert_eq!(direction_warning([3.0, 1.0], 12.0), None);
        assert_eq!(direction_warning([0.0, 0.01], 12.0), None);
    }
}
