//! Whether masses and inertias can be those of the drawn parts.
//!
//! Holds a part's size: the points that its solids and joints reach. Looks-only
//! shapes are not known here, so limits are wide.

use super::{Finding, Mark, Topic};
use crate::robot::statics::Standing;
use crate::robot::{Leg, Limbs, Link, Robot, Shape, Solid};
use core::f64::consts::{FRAC_PI_2, PI};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};

/// Lead is 11,340 kg/m^3; a servo is 1,600, and few bodies are lighter than foam.
const DENSITY_KG_M3: [f64; 2] = [10.0, 20_000.0];
/// Of a part's reach: a hollow ball has 0.82.
const GYRATION: [f64; 2] = [0.03, 1.1];
/// Beyond it there is no doubt.
const GYRATION_WRONG: f64 = 2.0;

/// Points that enclose a solid, in its part's frame.
fn hull(solid: &Solid) -> Vec<Point3<f64>> {
    let half_m = match solid.shape {
        Shape::Ball { radius_m } => Vector3::repeat(radius_m),
        Shape::Capsule { half_m, radius_m } => Vector3::new(radius_m, radius_m, half_m + radius_m),
        Shape::Cylinder { half_m, radius_m } => Vector3::new(radius_m, radius_m, half_m),
        Shape::Cuboid { half_m } => half_m,
    };
    let corner = |k: usize| {
        let sign = |bit: usize| if (k >> bit) & 1 == 0 { -1.0 } else { 1.0 };
        solid.pose * Point3::from(half_m.component_mul(&Vector3::new(sign(0), sign(1), sign(2))))
    };
    (0..8).map(corner).collect()
}

fn volume_m3(solid: &Solid) -> f64 {
    match solid.shape {
        Shape::Ball { radius_m } => 4.0 / 3.0 * PI * radius_m.powi(3),
        Shape::Capsule { half_m, radius_m } => PI * radius_m.powi(2) * (2.0 * half_m + 4.0 / 3.0 * radius_m),
        Shape::Cylinder { half_m, radius_m } => PI * radius_m.powi(2) * 2.0 * half_m,
        Shape::Cuboid { half_m } => 8.0 * half_m.product(),
    }
}

/// How far a solid reaches along each axis of the world, standing at `part`.
fn bounds(solid: &Solid, part: &Isometry3<f64>) -> [[f64; 2]; 3] {
    let middle = (part * solid.pose).translation.vector;
    // Each turn takes one axis down: the solid's lowest point is then its farthest along it.
    let down = [
        UnitQuaternion::from_axis_angle(&Vector3::y_axis(), FRAC_PI_2),
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -FRAC_PI_2),
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), PI),
    ];
    core::array::from_fn(|axis| {
        let most = -solid.lowest_m(&(Isometry3::from_parts(Translation3::identity(), down[axis]) * part));
        // Solids are symmetric about their middles.
        [2.0 * middle[axis] - most, most]
    })
}

/// Length, width and height of the robot at neutral, over the ground.
pub fn span_m(limbs: &Limbs, standing: &Standing<'_>) -> [f64; 3] {
    let mut all = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    let mut take = |found: [[f64; 2]; 3]| {
        for (bound, [low, high]) in all.iter_mut().zip(found) {
            *bound = [bound[0].min(low), bound[1].max(high)];
        }
    };
    for solid in &limbs.torso.solids {
        take(bounds(solid, &Isometry3::identity()));
    }
    for (leg, limb) in limbs.legs.iter().enumerate() {
        limb.thigh.solids.iter().for_each(|solid| take(bounds(solid, &standing.thighs[leg])));
        limb.shin.solids.iter().for_each(|solid| take(bounds(solid, &standing.shins[leg])));
        let foot_m = standing.feet_m[leg];
        take([foot_m.x, foot_m.y, foot_m.z].map(|at| [at - limbs.foot_radius_m, at + limbs.foot_radius_m]));
    }
    [all[0][1] - all[0][0], all[1][1] - all[1][0], all[2][1] + standing.height_m]
}

/// A part, its name, and points besides its solids that it reaches to.
struct Part<'l> {
    name: String,
    link: &'l Link,
    points: Vec<Point3<f64>>,
    foot: Option<Solid>,
}

fn parts<'l>(robot: &Robot, limbs: &'l Limbs) -> Vec<Part<'l>> {
    let origin = |hinge: &Isometry3<f64>| Point3::from(hinge.translation.vector);
    let hips = limbs.legs.iter().map(|leg| origin(&leg.hip.in_parent)).collect();
    let mut parts =
        vec![Part { name: robot.model.torso.clone(), link: &limbs.torso, points: hips, foot: None }];
    for (k, leg) in limbs.legs.iter().enumerate() {
        let Leg { hip, knee, thigh, shin, foot_m } = leg;
        parts.push(Part {
            name: format!("thigh of {}", robot.model.hips[k]),
            link: thigh,
            points: vec![origin(&hip.in_child), origin(&knee.in_parent)],
            foot: None,
        });
        let ball = Solid {
            pose: Isometry3::from_parts(foot_m.coords.into(), UnitQuaternion::identity()),
            shape: Shape::Ball { radius_m: limbs.foot_radius_m },
        };
        parts.push(Part {
            name: format!("shin of {}", robot.model.knees[k]),
            link: shin,
            points: vec![origin(&knee.in_child)],
            foot: Some(ball),
        });
    }
    parts
}

impl Part<'_> {
    fn solids(&self) -> impl Iterator<Item = &Solid> {
        self.link.solids.iter().chain(&self.foot)
    }

    fn reached(&self) -> impl Iterator<Item = Point3<f64>> {
        self.solids().flat_map(hull).chain(self.points.iter().copied())
    }

    /// Mass over the volume of a box around the part, and over that of its solids.
    fn densities_kg_m3(&self) -> [f64; 2] {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for point in self.reached() {
            (low, high) = (low.inf(&point.coords), high.sup(&point.coords));
        }
        let around_m3 = (high - low).product().max(1e-12);
        let solid_m3 = self.solids().map(volume_m3).sum::<f64>().max(1e-12);
        [around_m3, solid_m3].map(|volume_m3| self.link.inertia.mass_kg / volume_m3)
    }

    fn reach_m(&self) -> f64 {
        let centre_m = self.link.inertia.centre_m;
        self.reached().map(|point| (point - centre_m).norm()).fold(1e-6, f64::max)
    }

    fn gyration_m(&self) -> f64 {
        (self.link.inertia.principal().moments_kg_m2.max() / self.link.inertia.mass_kg).max(0.0).sqrt()
    }
}

/// The part that is farthest from what stuff can weigh.
pub fn density(robot: &Robot, limbs: &Limbs) -> Finding {
    let middle = (DENSITY_KG_M3[0] * DENSITY_KG_M3[1]).sqrt();
    let far = |density: f64| (density / middle).ln().abs();
    let worst = parts(robot, limbs)
        .into_iter()
        .map(|part| {
            let [around, solid] = part.densities_kg_m3();
            // Too heavy even for all that it encloses, or too light for what is drawn.
            (part.name, if around >= DENSITY_KG_M3[0] && solid >= DENSITY_KG_M3[0] { around } else { solid })
        })
        .reduce(|a, b| if far(b.1) > far(a.1) { b } else { a });
    let (part, density) = worst.unwrap_or_default();
    Finding::new(Topic::Density, density, "kg/m^3")
        .of(part)
        .within(DENSITY_KG_M3[0], DENSITY_KG_M3[1])
        .otherwise(
            Mark::Warning,
            "no part is made of that: are its masses in kilograms, and its sizes in metres?",
        )
}

/// The part whose inertia is least that of its mass and size.
pub fn inertia(robot: &Robot, limbs: &Limbs) -> Finding {
    let middle = (GYRATION[0] * GYRATION[1]).sqrt();
    let far = |share: f64| (share.max(1e-9) / middle).ln().abs();
    let worst = parts(robot, limbs)
        .into_iter()
        .map(|part| (part.gyration_m() / part.reach_m(), part))
        .reduce(|a, b| if far(b.0) > far(a.0) { b } else { a });
    // There are nine parts.
    let Some((share, part)) = worst else { return Finding::new(Topic::Inertia, 0.0, "m") };
    let [least_m, most_m] = GYRATION.map(|share| share * part.reach_m());
    let finding = Finding::new(Topic::Inertia, part.gyration_m(), "m").of(part.name).within(least_m, most_m);
    let mark = if share > GYRATION_WRONG { Mark::Error } else { Mark::Warning };
    finding.otherwise(
        mark,
        "its moments of inertia are not those of its mass and size: are they in kg m^2, or placeholders?",
    )
}
