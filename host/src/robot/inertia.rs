//! Mass, centre and moments of a body, in double precision.
//!
//! Holds how bodies are welded together and stretched along a line. Does not
//! depend on joints.

use nalgebra::{Isometry3, Matrix3, Point3, UnitQuaternion, Vector3};

/// Sweeps after which the moments' axes are taken as they are.
const SWEEPS: usize = 100;
/// No principal moment exceeds the sum of the others; files round.
const ROUNDING: f64 = 1.01;

/// How a body resists being moved and turned, in the frame of its part.
#[derive(Debug, Clone, PartialEq)]
pub struct Inertia {
    /// Its mass.
    pub mass_kg: f64,
    /// Its centre of mass.
    pub centre_m: Point3<f64>,
    /// Its moments about that centre.
    pub tensor_kg_m2: Matrix3<f64>,
}

/// Moments along the axes in which there are no products.
#[derive(Debug, Clone, PartialEq)]
pub struct Principal {
    /// About each axis.
    pub moments_kg_m2: Vector3<f64>,
    /// From those axes to the part's.
    pub axes: UnitQuaternion<f64>,
}

impl Inertia {
    /// Of nothing.
    pub fn none() -> Self {
        Self { mass_kg: 0.0, centre_m: Point3::origin(), tensor_kg_m2: Matrix3::zeros() }
    }

    /// The same body in another frame.
    pub fn moved(&self, to: &Isometry3<f64>) -> Self {
        let turn = to.rotation.to_rotation_matrix();
        Self {
            mass_kg: self.mass_kg,
            centre_m: to * self.centre_m,
            tensor_kg_m2: turn.matrix() * self.tensor_kg_m2 * turn.matrix().transpose(),
        }
    }

    /// Both, as one body.
    pub fn welded(&self, other: &Self) -> Self {
        let mass_kg = self.mass_kg + other.mass_kg;
        if mass_kg <= 0.0 {
            return Self::none();
        }
        let share = other.mass_kg / mass_kg;
        let centre_m = self.centre_m + (other.centre_m - self.centre_m) * share;
        let about = |part: &Self| {
            let lever = part.centre_m - centre_m;
            let square = Matrix3::identity() * lever.norm_squared() - lever * lever.transpose();
            part.tensor_kg_m2 + part.mass_kg * square
        };
        Self { mass_kg, centre_m, tensor_kg_m2: about(self) + about(other) }
    }

    /// The same body with another mass, spread as before.
    pub fn weighing(&self, mass_kg: f64) -> Self {
        let share = mass_kg / self.mass_kg;
        Self { mass_kg, centre_m: self.centre_m, tensor_kg_m2: self.tensor_kg_m2 * share }
    }

    /// The same stuff drawn out to `scale` times its length: mass goes with length.
    pub fn stretched(&self, stretch: &Stretch) -> Self {
        // Second moments of mass transform as products of coordinates do.
        let spread = Matrix3::identity() * (self.tensor_kg_m2.trace() / 2.0) - self.tensor_kg_m2;
        let map = stretch.matrix();
        let spread = map * spread * map.transpose() * stretch.scale;
        Self {
            mass_kg: self.mass_kg * stretch.scale,
            centre_m: stretch.point(&self.centre_m),
            tensor_kg_m2: Matrix3::identity() * spread.trace() - spread,
        }
    }

    /// Its principal moments.
    pub fn principal(&self) -> Principal {
        let symmetric = (self.tensor_kg_m2 + self.tensor_kg_m2.transpose()) / 2.0;
        // Moments far below 1 would be below an absolute tolerance: scale to 1 first.
        let size = symmetric.amax().max(f64::MIN_POSITIVE);
        let Some(found) = (symmetric / size).try_symmetric_eigen(f64::EPSILON, SWEEPS) else {
            return Principal { moments_kg_m2: symmetric.diagonal(), axes: UnitQuaternion::identity() };
        };
        let mut axes = found.eigenvectors;
        if axes.determinant() < 0.0 {
            axes.column_mut(2).neg_mut();
        }
        let axes = nalgebra::Rotation3::from_matrix_unchecked(axes);
        Principal {
            moments_kg_m2: found.eigenvalues * size,
            axes: UnitQuaternion::from_rotation_matrix(&axes),
        }
    }

    /// Whether some body could have it.
    pub fn is_possible(&self) -> bool {
        let moments = self.principal().moments_kg_m2;
        let sum = moments.sum();
        self.mass_kg > 0.0 && moments.iter().all(|moment| *moment > 0.0 && 2.0 * moment <= ROUNDING * sum)
    }
}

/// Drawing a part out along a line from a point on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Stretch {
    /// What stays where it is.
    pub from_m: Point3<f64>,
    /// Unit vector.
    pub along: Vector3<f64>,
    /// 1 changes nothing.
    pub scale: f64,
}

impl Stretch {
    /// Of vectors.
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::identity() + self.along * self.along.transpose() * (self.scale - 1.0)
    }

    /// Of points.
    pub fn point(&self, point_m: &Point3<f64>) -> Point3<f64> {
        self.from_m + self.matrix() * (point_m - self.from_m)
    }
}
