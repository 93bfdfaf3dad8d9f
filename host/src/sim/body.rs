//! Builds the Ant as one rapier multibody on a flat ground.
//!
//! Owns frames and mass properties. Nine bodies: torso, four thighs, four
//! shins. A thigh's frame sits on its hip axis, x along the thigh, z up; a
//! shin's frame sits on its knee axis and is aligned with the thigh's where
//! the shin would be horizontal and straight out at a fold of zero.
//! Multibody coordinates and not impulse joints: those do not converge at
//! this mass ratio, the torso sinks and speed falls by half.

use crate::robot::Robot;
use rapier3d::prelude::*;

/// Azimuth of each leg, 45, 135, 225 and 315 degrees, as the sign of cosine and sine.
pub const LEG_SIGNS: [(f64, f64); 4] = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];

/// A servo's largest dimension, for its inertia: 40 mm, the standard size.
const SERVO_SIZE_M: f64 = 0.04;
/// How thick a leg's tube is where it may touch the ground.
const TUBE_RADIUS_M: f64 = 0.006;

/// The world with the robot in it, and the handles to find it there.
pub struct Body {
    pub physics: PhysicsWorld,
    pub torso: RigidBodyHandle,
    /// Legs 1 to 4.
    pub thighs: [RigidBodyHandle; 4],
    pub shins: [RigidBodyHandle; 4],
    pub multibody: MultibodyIndex,
}

/// Where and how the robot starts.
pub struct Pose0 {
    pub joint_angles_rad: [f64; 8],
    pub height_m: f64,
    pub yaw_rad: f64,
    pub friction: f64,
    pub step_s: f64,
}

/// Floats of the engine are single; this is where ours become so.
pub fn real(value: f64) -> Real {
    value as Real
}

/// A point of the shin, in its frame, at a distance from the knee.
pub fn along_shin(robot: &Robot, distance_m: f64) -> Vector {
    let slope = robot.geometry.shin_below_horizontal_deg.to_radians();
    Vector::new(real(distance_m * slope.cos()), 0.0, real(-distance_m * slope.sin()))
}

/// The middle of the foot's ball, in the shin's frame.
pub fn foot_in_shin(robot: &Robot) -> Vector {
    along_shin(robot, robot.scaled_shin_m() - robot.geometry.foot_radius_m)
}

fn cuboid_inertia(mass_kg: f64, x_m: f64, y_m: f64, z_m: f64) -> [f64; 3] {
    let twelfth = mass_kg / 12.0;
    [twelfth * (y_m * y_m + z_m * z_m), twelfth * (x_m * x_m + z_m * z_m), twelfth * (x_m * x_m + y_m * y_m)]
}

/// Frame and electronics in the middle, a servo at each hip.
fn torso_mass(robot: &Robot) -> MassProperties {
    let Robot { geometry, mass, .. } = robot;
    let width_m = 2.0 * geometry.hip_offset_m;
    let frame = cuboid_inertia(mass.torso_kg, width_m, width_m, 2.0 * geometry.torso_half_height_m);
    let servo = cuboid_inertia(mass.servo_kg, SERVO_SIZE_M, SERVO_SIZE_M / 2.0, SERVO_SIZE_M);
    let lever = mass.servo_kg * geometry.hip_offset_m * geometry.hip_offset_m;
    let inertia = [
        frame[0] + 4.0 * (servo[0] + lever),
        frame[1] + 4.0 * (servo[1] + lever),
        frame[2] + 4.0 * (servo[2] + 2.0 * lever),
    ];
    let total_kg = mass.torso_kg + 4.0 * mass.servo_kg;
    MassProperties::new(Vector::ZERO, real(total_kg), Vector::from_array(inertia.map(real)))
}

/// A tube with a servo at its end.
fn thigh_mass(robot: &Robot) -> MassProperties {
    let Robot { geometry, mass, .. } = robot;
    let total_kg = mass.thigh_kg + mass.servo_kg;
    let com_m = (mass.thigh_kg * geometry.thigh_m / 2.0 + mass.servo_kg * geometry.thigh_m) / total_kg;
    let tube = cuboid_inertia(mass.thigh_kg, geometry.thigh_m, TUBE_RADIUS_M, TUBE_RADIUS_M);
    let servo = cuboid_inertia(mass.servo_kg, SERVO_SIZE_M, SERVO_SIZE_M / 2.0, SERVO_SIZE_M);
    let from_com = |at_m: f64| (at_m - com_m) * (at_m - com_m);
    let lever = mass.thigh_kg * from_com(geometry.thigh_m / 2.0) + mass.servo_kg * from_com(geometry.thigh_m);
    let inertia = [tube[0] + servo[0], tube[1] + servo[1] + lever, tube[2] + servo[2] + lever];
    MassProperties::new(Vector::X * real(com_m), real(total_kg), Vector::from_array(inertia.map(real)))
}

/// A tube along the shin's slope.
fn shin_mass(robot: &Robot) -> MassProperties {
    let length_m = robot.scaled_shin_m();
    let inertia = cuboid_inertia(robot.scaled_shin_kg(), length_m, 2.0 * TUBE_RADIUS_M, 2.0 * TUBE_RADIUS_M);
    let slope = robot.geometry.shin_below_horizontal_deg.to_radians();
    MassProperties::with_principal_inertia_frame(
        along_shin(robot, length_m / 2.0),
        real(robot.scaled_shin_kg()),
        Vector::from_array(inertia.map(real)),
        Rotation::from_rotation_y(real(slope)),
    )
}

/// A hinge about `axis` of both frames, at `anchor` in the parent, turned by `turn` about z there.
fn hinge(anchor: Vector, turn: Rotation, x_to_axis: Rotation) -> GenericJoint {
    GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
        .local_frame1(Pose::from_parts(anchor, turn * x_to_axis))
        .local_frame2(Pose::from_rotation(x_to_axis))
        .build()
}

fn dynamic(mass: MassProperties, pose: Pose) -> RigidBody {
    // Bodies fall asleep by default, and servos do not wake them.
    RigidBodyBuilder::dynamic().additional_mass_properties(mass).pose(pose).can_sleep(false).build()
}

impl Body {
    /// Puts the robot on the ground. A fresh world for each start: nothing of
    /// an earlier episode, such as contact impulses, can leak into the next.
    pub fn new(robot: &Robot, start: &Pose0) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::new(0.0, 0.0, -9.81);
        let parameters = &mut physics.integration_parameters;
        parameters.dt = real(start.step_s);
        // One pass of four sweeps: with these the speed agrees with a converged
        // solution to a few percent; the warm start does the rest.
        parameters.num_solver_iterations = 1;
        parameters.num_internal_pgs_iterations = 4;

        let on_ground = InteractionGroups::new(Group::GROUP_1, Group::GROUP_2, InteractionTestMode::And);
        let on_robot = InteractionGroups::new(Group::GROUP_2, Group::GROUP_1, InteractionTestMode::And);
        // Equal on both sides, so that the mean that rapier takes is the value.
        let friction = real(start.friction);
        let ground = physics.bodies.insert(RigidBodyBuilder::fixed());
        physics.colliders.insert_with_parent(
            ColliderBuilder::halfspace(rapier3d::na::Unit::new_unchecked(Vector::Z))
                .friction(friction)
                .collision_groups(on_ground),
            ground,
            &mut physics.bodies,
        );
        let solid = |shape: ColliderBuilder| shape.density(0.0).friction(friction).collision_groups(on_robot);

        let geometry = &robot.geometry;
        let torso_pose = Pose::from_parts(
            Vector::Z * real(start.height_m),
            Rotation::from_rotation_z(real(start.yaw_rad)),
        );
        let torso = physics.bodies.insert(dynamic(torso_mass(robot), torso_pose));
        let half_width = real(geometry.hip_offset_m);
        physics.colliders.insert_with_parent(
            solid(ColliderBuilder::cuboid(half_width, half_width, real(geometry.torso_half_height_m))),
            torso,
            &mut physics.bodies,
        );

        let to_z = Rotation::from_rotation_y(-core::f32::consts::FRAC_PI_2);
        let to_y = Rotation::from_rotation_z(core::f32::consts::FRAC_PI_2);
        let thigh_m = real(geometry.thigh_m);
        // Hips first: joint j is then degree of freedom 6 + j.
        let thighs = LEG_SIGNS.map(|(x, y)| {
            let thigh = physics.bodies.insert(dynamic(thigh_mass(robot), torso_pose));
            physics.colliders.insert_with_parent(
                solid(ColliderBuilder::capsule_from_endpoints(
                    Vector::ZERO,
                    Vector::X * thigh_m,
                    real(TUBE_RADIUS_M),
                )),
                thigh,
                &mut physics.bodies,
            );
            let anchor = Vector::new(real(x * geometry.hip_offset_m), real(y * geometry.hip_offset_m), 0.0);
            let turn = Rotation::from_rotation_z(real(y.atan2(x)));
            physics.multibody_joints.insert(torso, thigh, hinge(anchor, turn, to_z), true);
            thigh
        });
        let foot = foot_in_shin(robot);
        let shins = thighs.map(|thigh| {
            let shin = physics.bodies.insert(dynamic(shin_mass(robot), torso_pose));
            physics.colliders.insert_with_parent(
                solid(ColliderBuilder::ball(real(geometry.foot_radius_m)).translation(foot)),
                shin,
                &mut physics.bodies,
            );
            let knee = hinge(Vector::X * thigh_m, Rotation::IDENTITY, to_y);
            physics.multibody_joints.insert(thigh, shin, knee, true);
            shin
        });

        // `insert` has just put the torso into a multibody.
        #[expect(clippy::expect_used, reason = "an invariant of the lines above")]
        let multibody =
            physics.multibody_joints.rigid_body_link(torso).expect("the torso has four hips").multibody;
        let mut body = Self { physics, torso, thighs, shins, multibody };
        body.pose(robot, start);
        body
    }

    /// Sets joint angles and the damping of servos, and settles all poses.
    fn pose(&mut self, robot: &Robot, start: &Pose0) {
        let PhysicsWorld { multibody_joints, bodies, colliders, .. } = &mut self.physics;
        // Else the centres of mass are known from the second step on only.
        for link in [self.torso].iter().chain(&self.thighs).chain(&self.shins) {
            bodies[*link].recompute_mass_properties_from_colliders(colliders);
        }
        let Some(multibody) = multibody_joints.get_multibody_mut(self.multibody) else { return };
        multibody.set_self_contacts_enabled(false);
        // Rapier damps every rotation by 0.1, that of the whole robot included.
        let damping = multibody.damping_mut();
        damping.fill(0.0);
        damping.rows_mut(6, 8).fill(real(robot.servo.damping_n_m_s_rad));
        if robot.servo.friction_n_m > 0.0 {
            multibody.frictions_mut().rows_mut(6, 8).fill(real(robot.servo.friction_n_m));
        }
        let mut displacements = [0.0; 14];
        for (displacement, &angle) in displacements[6..].iter_mut().zip(&start.joint_angles_rad) {
            *displacement = real(angle);
        }
        multibody.forward_kinematics(bodies, true);
        multibody.apply_displacements(&displacements);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
    }
}
