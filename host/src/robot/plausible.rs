//! Whether a robot could be built: its lengths, masses, inertia and leg order.
//!
//! Holds the bounds of what is plausible for eight hobby servos, and what is told
//! by them: an error where the robot would be another one than meant, else a
//! warning. Does not depend on the file formats nor on the simulation.

use super::drawn::{Drawn, DrawnLeg, Part, weld};
use super::error::ModelError;
use super::fields::Field;
use super::inertia::Inertia;
use super::raw::Hinge;
use super::sections::Model;
use super::solid::Solid;
use super::warning::RobotWarning;
use super::{Limbs, Robot};
use crate::energy::STANDARD_GRAVITY_M_S2;
use nalgebra::{Isometry3, Point3, Vector3};
use protocol::{JOINT_COUNT, LEG_COUNT};

/// From hip to tip: what is beyond is an error.
const LEG_M: [f64; 2] = [0.005, 3.0];
/// From hip to tip: what is beyond is a warning.
const USUAL_LEG_M: [f64; 2] = [0.02, 1.2];
/// From a part's centre of mass to its farthest point, in the same way.
const PART_M: f64 = 3.0;
const USUAL_PART_M: f64 = 1.5;
/// Radius of gyration over that distance: no mass within the part has more than 1.
const GYRATION: [f64; 2] = [1.5, 5.0];
/// A rod has 0.3 to 0.6 of its reach, a servo at the end of a light tube 0.1.
const LEAST_GYRATION: f64 = 0.02;
/// Of a ball as large as the part; steel has 7850.
const MOST_DENSITY_KG_M3: f64 = 8000.0;
/// A hip nearer to an axis than this, or than this share of the farthest hip, is on it.
const ON_AXIS_M: f64 = 1e-3;
const ON_AXIS_SHARE: f64 = 0.05;
/// As in the simulation, nearer to the ground than this is contact.
const CONTACT_M: f64 = 1e-3;

/// Where legs 1 to 4 are: the signs of x and y, and the words.
const QUADRANTS: [([f64; 2], &str); LEG_COUNT] = [
    ([1.0, 1.0], "front left"),
    ([-1.0, 1.0], "rear left"),
    ([-1.0, -1.0], "rear right"),
    ([1.0, -1.0], "front right"),
];

/// A part's shapes and the points where joints carry it.
struct Outline<'d> {
    part: &'d Part,
    pivots_m: Vec<Point3<f64>>,
}

impl Outline<'_> {
    /// From a point to the farthest of the part.
    fn reach_m(&self, from: &Point3<f64>) -> f64 {
        let solids = self.part.iter().flat_map(|piece| &piece.solids);
        let pivots = self.pivots_m.iter().map(|pivot| (pivot - from).norm());
        solids.map(|solid| solid.farthest_m(from)).chain(pivots).fold(0.0, f64::max)
    }

    /// Its first body.
    fn name(&self) -> String {
        self.part.first().map_or_else(String::new, |piece| piece.name.clone())
    }
}

fn place(frame: &Isometry3<f64>) -> Point3<f64> {
    frame.translation.vector.into()
}

/// Torso, then thigh and shin of each leg.
fn outlines(drawn: &Drawn) -> Vec<Outline<'_>> {
    let hips = drawn.legs.iter().map(|leg| place(&leg.hip.in_parent)).collect();
    let mut outlines = vec![Outline { part: &drawn.torso, pivots_m: hips }];
    for leg in &drawn.legs {
        let thigh = vec![place(&leg.hip.in_child), place(&leg.knee.in_parent)];
        outlines.push(Outline { part: &leg.thigh, pivots_m: thigh });
        outlines.push(Outline { part: &leg.shin, pivots_m: vec![place(&leg.knee.in_child)] });
    }
    outlines
}

/// Looks at the body as its file draws it.
///
/// # Errors
/// [`ModelError`] for legs in the wrong order, and for lengths and inertia that
/// no such robot has.
pub fn check(drawn: &Drawn, model: &Model) -> Result<Vec<RobotWarning>, ModelError> {
    let outlines = outlines(drawn);
    let mut warnings = Vec::new();
    warnings.extend(lengths(drawn, &outlines)?);
    leg_order(drawn, model)?;
    warnings.extend(gyration(&outlines, model.file.ends_with(".urdf"))?);
    let dense = outlines.iter().find_map(|outline| {
        let whole = weld(outline.part);
        let reach_m = outline.reach_m(&whole.centre_m);
        let ball_m3 = 4.0 / 3.0 * core::f64::consts::PI * reach_m.powi(3);
        (whole.mass_kg > MOST_DENSITY_KG_M3 * ball_m3).then(|| RobotWarning::Dense {
            body: outline.name(),
            mass_kg: whole.mass_kg,
            reach_m,
        })
    });
    warnings.extend(dense);
    Ok(warnings)
}

/// The torso's mass as drawn.
///
/// # Errors
/// [`ModelError::Weight`] where it is out of bounds, with what the unit may be.
pub fn torso_kg(drawn: &Drawn) -> Result<f64, ModelError> {
    let torso = &drawn.torso[0];
    let mass_kg = torso.inertia.mass_kg;
    let bounds = Field::named("mass.torso_kg").and_then(|field| field.fixed_bounds());
    let (least_kg, most_kg) = bounds.unwrap_or((0.0, f64::INFINITY));
    if (least_kg..=most_kg).contains(&mass_kg) {
        return Ok(mass_kg);
    }
    let hint = if mass_kg > most_kg {
        "masses are in kilograms and lengths in metres: are these grams or millimetres? Correct them"
    } else {
        "masses are in kilograms and densities in kg/m^3: are these in another unit? Correct them"
    };
    Err(ModelError::Weight { body: torso.name.clone(), mass_kg, least_kg, most_kg, hint })
}

fn lengths(drawn: &Drawn, outlines: &[Outline<'_>]) -> Result<Option<RobotWarning>, ModelError> {
    let [least_m, most_m] = LEG_M;
    let unit = |length_m: f64| if length_m < 1.0 { "kilometres or another unit" } else { LARGE };
    let of_leg = |leg: usize, drawn: &DrawnLeg| {
        let thigh_m = (place(&drawn.knee.in_parent) - place(&drawn.hip.in_child)).norm();
        let (ball_m, radius_m) = drawn.ball();
        let length_m = thigh_m + (ball_m - place(&drawn.knee.in_child)).norm() + radius_m;
        (format!("leg {}, from hip to tip,", leg + 1), length_m, least_m, most_m, USUAL_LEG_M)
    };
    let legs = drawn.legs.iter().enumerate().map(|(leg, drawn)| of_leg(leg, drawn));
    let parts = outlines.iter().map(|outline| {
        let what = format!("the reach of the part with {:?} from its centre of mass", outline.name());
        let reach_m = outline.reach_m(&weld(outline.part).centre_m);
        (what, reach_m, 0.0, PART_M, [0.0, USUAL_PART_M])
    });
    let mut warning = None;
    for (what, length_m, least_m, most_m, usual_m) in legs.chain(parts) {
        if !(least_m..=most_m).contains(&length_m) {
            return Err(ModelError::Length { what, length_m, least_m, most_m, unit: unit(length_m) });
        }
        if !(usual_m[0]..=usual_m[1]).contains(&length_m) && warning.is_none() {
            warning = Some(RobotWarning::Length { what, length_m, unit: unit(length_m) });
        }
    }
    Ok(warning)
}

const LARGE: &str = "millimetres, centimetres or inches";

/// Each leg is to be in its own quadrant about the middle of the four hips; legs
/// whose hips are on an axis are looked at by their feet.
fn leg_order(drawn: &Drawn, model: &Model) -> Result<(), ModelError> {
    let hips = drawn.legs.each_ref().map(|leg| place(&leg.hip.in_parent));
    let feet = drawn.legs.each_ref().map(|leg| leg.hip.at(0.0) * leg.knee.at(0.0) * leg.ball().0);
    let (hip_signs, foot_signs) = (signs(&hips), signs(&feet));
    for leg in 0..LEG_COUNT {
        let Some(found) = hip_signs[leg].or(foot_signs[leg]) else { continue };
        let (must_signs, must) = QUADRANTS[leg];
        if found == must_signs {
            continue;
        }
        let (_, is) = QUADRANTS.into_iter().find(|(signs, _)| *signs == found).unwrap_or(QUADRANTS[leg]);
        let place_m = if hip_signs[leg].is_some() { hips[leg] } else { feet[leg] };
        return Err(ModelError::LegOrder {
            leg: leg + 1,
            hip: model.hips[leg].clone(),
            x_m: place_m.x,
            y_m: place_m.y,
            is,
            must,
        });
    }
    Ok(())
}

/// On which side of their middle four points are; none near an axis.
fn signs(points: &[Point3<f64>; LEG_COUNT]) -> [Option<[f64; 2]>; LEG_COUNT] {
    let middle = points.iter().fold(Vector3::zeros(), |sum, point| sum + point.coords) / LEG_COUNT as f64;
    let from = points.map(|point| point.coords - middle);
    let farthest_m = from.iter().map(|from| from.xy().amax()).fold(0.0, f64::max);
    let least_m = ON_AXIS_M.max(ON_AXIS_SHARE * farthest_m);
    from.map(|from| {
        (from.x.abs() > least_m && from.y.abs() > least_m).then(|| [from.x.signum(), from.y.signum()])
    })
}

fn gyration_m(inertia: &Inertia) -> f64 {
    (inertia.principal().moments_kg_m2.max() / inertia.mass_kg).sqrt()
}

fn gyration(outlines: &[Outline<'_>], is_urdf: bool) -> Result<Vec<RobotWarning>, ModelError> {
    let [usual, most] = GYRATION;
    // The body with the largest radius for its part's size.
    let mut worst: Option<(f64, String, f64, f64, f64)> = None;
    let mut warnings = Vec::new();
    for outline in outlines {
        for piece in outline.part.iter().filter(|piece| piece.inertia.mass_kg > 0.0) {
            let (gyration_m, reach_m) =
                (gyration_m(&piece.inertia), outline.reach_m(&piece.inertia.centre_m));
            let share = gyration_m / reach_m.max(1e-6);
            if worst.as_ref().is_none_or(|(most, ..)| share > *most) {
                worst = Some((share, piece.name.clone(), gyration_m, reach_m, piece.inertia.mass_kg));
            }
        }
        let whole = weld(outline.part);
        let (gyration_m, reach_m) = (gyration_m(&whole), outline.reach_m(&whole.centre_m));
        if gyration_m < LEAST_GYRATION * reach_m && warnings.is_empty() {
            warnings.push(RobotWarning::PointMass { body: outline.name(), gyration_m, reach_m });
        }
    }
    let Some((share, body, gyration_m, reach_m, mass_kg)) = worst else { return Ok(warnings) };
    if share > most {
        let more = if is_urdf { "" } else { ", or leave the <inertial> out and give the geoms a mass" };
        return Err(ModelError::Gyration { body, gyration_m, mass_kg, reach_m, more });
    }
    if share > usual {
        warnings.push(RobotWarning::Gyration { body, gyration_m, reach_m });
    }
    Ok(warnings)
}

/// Looks at the robot as it is built: what the description changes is in it.
pub fn built(robot: &Robot) -> Vec<RobotWarning> {
    let limbs = Limbs::of(robot);
    let mut warnings = Vec::new();
    let lowest = |solids: &[Solid], pose: &Isometry3<f64>| {
        solids.iter().map(|solid| solid.lowest_m(pose)).fold(f64::INFINITY, f64::min)
    };
    let below = limbs.legs.iter().enumerate().find_map(|(leg, limb)| {
        let shin = limb.hip.at(0.0) * limb.knee.at(0.0);
        let below_m = (shin * limb.foot_m).z - limbs.foot_radius_m - lowest(&limb.shin.solids, &shin);
        (below_m > CONTACT_M).then(|| RobotWarning::ShinBelowFoot {
            leg: leg + 1,
            foot: robot.model.feet[leg].clone(),
            below_mm: 1000.0 * below_m,
        })
    });
    warnings.extend(below);
    let torques_n_m = holding_n_m(&limbs);
    let limit_n_m = robot.servo.torque_limit_n_m;
    let most = torques_n_m.iter().copied().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b));
    if let Some((j, needed_n_m)) = most.filter(|(_, needed_n_m)| *needed_n_m > limit_n_m) {
        let joint = if j < LEG_COUNT { &robot.model.hips[j] } else { &robot.model.knees[j - LEG_COUNT] };
        warnings.push(RobotWarning::TooHeavy {
            mass_kg: limbs.mass_kg(),
            joint: joint.clone(),
            needed_n_m,
            limit_n_m,
        });
    }
    let squares: f64 = torques_n_m.iter().map(|torque| torque.min(limit_n_m).powi(2)).sum();
    let needed_w = robot.power.electronics_w + robot.power.heat_w_per_n2_m2 * squares;
    let most_w = robot.supply.most_power_w();
    if needed_w > most_w {
        let (nominal_v, resistance_ohm) = (robot.supply.nominal_v, robot.supply.resistance_ohm);
        warnings.push(RobotWarning::WeakSupply { needed_w, nominal_v, resistance_ohm, most_w });
    }
    warnings
}

/// Torque that each servo holds, either way, with the robot level at neutral and a
/// quarter of its weight on each foot. Feet push straight up: hips 1 to 4, then knees.
fn holding_n_m(limbs: &Limbs) -> [f64; JOINT_COUNT] {
    let foot_n = limbs.mass_kg() * STANDARD_GRAVITY_M_S2 / LEG_COUNT as f64;
    core::array::from_fn(|j| {
        let leg = &limbs.legs[j % LEG_COUNT];
        let thigh = leg.hip.at(0.0);
        let shin = thigh * leg.knee.at(0.0);
        let about = |hinge: &Hinge, carrier: &Isometry3<f64>, loads: &[(Point3<f64>, f64)]| {
            let frame = carrier * hinge.in_parent;
            let torque: Vector3<f64> = loads
                .iter()
                .map(|(point_m, up_n)| (point_m - place(&frame)).cross(&(Vector3::z() * *up_n)))
                .sum();
            (frame.rotation * Vector3::x()).dot(&torque).abs()
        };
        let weight = |pose: &Isometry3<f64>, inertia: &Inertia| {
            (pose * inertia.centre_m, -inertia.mass_kg * STANDARD_GRAVITY_M_S2)
        };
        let below = [(shin * leg.foot_m, foot_n), weight(&shin, &leg.shin.inertia)];
        if j < LEG_COUNT {
            let [foot, shin_weight] = below;
            let loads = [foot, shin_weight, weight(&thigh, &leg.thigh.inertia)];
            about(&leg.hip, &Isometry3::identity(), &loads)
        } else {
            about(&leg.knee, &thigh, &below)
        }
    })
}
