//! Builds a robot as one rapier multibody on flat ground.
//!
//! Holds the engine's handles and settings. Does not depend on servos' setpoints
//! or on gaits. Nine bodies: torso, four thighs, four shins, as [`Limbs`] describes
//! them; joint coordinates read 0 at neutral. Multibody coordinates and not impulse
//! joints: those do not converge at this mass ratio, so that the torso sinks and
//! the speed is half of what it should be.

use crate::energy::SIMULATED_GRAVITY_M_S2;
use crate::robot::{Hinge, Inertia, Limbs, Link, Servo, Shape, Solid};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion};
use protocol::{JOINT_COUNT, LEG_COUNT};
use rapier3d::prelude::*;

/// Degrees of freedom of the torso, which come before the joints'.
const TORSO_FREEDOMS: usize = 6;

/// The world with the robot in it, and the handles to find it there.
pub struct Body {
    pub physics: PhysicsWorld,
    pub torso: RigidBodyHandle,
    /// Legs 1 to 4.
    pub thighs: [RigidBodyHandle; LEG_COUNT],
    pub shins: [RigidBodyHandle; LEG_COUNT],
    pub multibody: MultibodyIndex,
    /// Unit vectors in the frame of the part that carries the joint.
    pub axes: [Vector; JOINT_COUNT],
    /// Middle of each foot's ball, in its shin's frame.
    pub feet: [Vector; LEG_COUNT],
    /// A point of each knee's axis, in its shin's frame.
    pub knees: [Vector; LEG_COUNT],
}

/// The pose, the friction and the physics step that a world starts with.
pub struct Pose0 {
    pub joint_angles_rad: [f64; JOINT_COUNT],
    pub height_m: f64,
    pub yaw_rad: f64,
    pub friction: f64,
    pub step_s: f64,
}

/// In the engine's single precision.
pub fn real(value: f64) -> Real {
    value as Real
}

fn vector(point: &Point3<f64>) -> Vector {
    Vector::new(real(point.x), real(point.y), real(point.z))
}

fn pose(frame: &Isometry3<f64>) -> Pose {
    let turn = frame.rotation.coords;
    Pose::from_parts(
        vector(&Point3::from(frame.translation.vector)),
        Rotation::from_xyzw(real(turn.x), real(turn.y), real(turn.z), real(turn.w)),
    )
}

/// A pose of the engine in double precision.
pub fn frame(pose: &Pose) -> Isometry3<f64> {
    let [x, y, z] = pose.translation.to_array().map(f64::from);
    let [i, j, k, w] = pose.rotation.to_array().map(f64::from);
    Isometry3::from_parts(
        Translation3::new(x, y, z),
        UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, i, j, k)),
    )
}

fn mass(inertia: &Inertia) -> MassProperties {
    let principal = inertia.principal();
    let moments = principal.moments_kg_m2.map(real);
    MassProperties::with_principal_inertia_frame(
        vector(&inertia.centre_m),
        real(inertia.mass_kg),
        Vector::new(moments.x, moments.y, moments.z),
        pose(&Isometry3::from_parts(Translation3::identity(), principal.axes)).rotation,
    )
}

fn hinge(hinge: &Hinge) -> GenericJoint {
    GenericJointBuilder::new(JointAxesMask::LOCKED_REVOLUTE_AXES)
        .local_frame1(pose(&hinge.in_parent))
        .local_frame2(pose(&hinge.in_child))
        .build()
}

fn dynamic(link: &Link, pose: Pose) -> RigidBody {
    // Bodies fall asleep by default, and servos do not wake them.
    RigidBodyBuilder::dynamic()
        .additional_mass_properties(mass(&link.inertia))
        .pose(pose)
        .can_sleep(false)
        .build()
}

fn collider(solid: &Solid) -> ColliderBuilder {
    let at = pose(&solid.pose);
    // The engine's cylinders stand along y, ours along z.
    let upright = Pose::from_rotation(Rotation::from_rotation_x(core::f32::consts::FRAC_PI_2));
    match &solid.shape {
        Shape::Ball { radius_m } => ColliderBuilder::ball(real(*radius_m)).position(at),
        Shape::Capsule { half_m, radius_m } => {
            ColliderBuilder::capsule_z(real(*half_m), real(*radius_m)).position(at)
        }
        Shape::Cylinder { half_m, radius_m } => {
            ColliderBuilder::cylinder(real(*half_m), real(*radius_m)).position(at * upright)
        }
        Shape::Cuboid { half_m } => {
            ColliderBuilder::cuboid(real(half_m.x), real(half_m.y), real(half_m.z)).position(at)
        }
    }
}

impl Body {
    /// Puts the robot on the ground, in a new world: nothing of an earlier
    /// episode, such as contact impulses, can affect the next.
    pub fn new(limbs: &Limbs, servo: &Servo, start: &Pose0) -> Self {
        let mut physics = PhysicsWorld::new();
        physics.gravity = Vector::new(0.0, 0.0, real(-SIMULATED_GRAVITY_M_S2));
        let parameters = &mut physics.integration_parameters;
        parameters.dt = real(start.step_s);
        // One pass of four sweeps: with these the speed agrees with a converged
        // solution to a few percent; the warm start does the rest.
        parameters.num_solver_iterations = 1;
        parameters.num_internal_pgs_iterations = 4;

        let on_ground = InteractionGroups::new(Group::GROUP_1, Group::GROUP_2, InteractionTestMode::And);
        let on_robot = InteractionGroups::new(Group::GROUP_2, Group::GROUP_1, InteractionTestMode::And);
        // Rapier takes the mean of both sides; equal on both, it is the value.
        let friction = real(start.friction);
        let ground = physics.bodies.insert(RigidBodyBuilder::fixed());
        physics.colliders.insert_with_parent(
            ColliderBuilder::halfspace(rapier3d::na::Unit::new_unchecked(Vector::Z))
                .friction(friction)
                .collision_groups(on_ground),
            ground,
            &mut physics.bodies,
        );
        let origin = Pose::from_parts(
            Vector::Z * real(start.height_m),
            Rotation::from_rotation_z(real(start.yaw_rad)),
        );
        let mut insert = |link: &Link, foot: Option<ColliderBuilder>| {
            let body = physics.bodies.insert(dynamic(link, origin));
            for solid in link.solids.iter().map(collider).chain(foot) {
                physics.colliders.insert_with_parent(
                    solid.density(0.0).friction(friction).collision_groups(on_robot),
                    body,
                    &mut physics.bodies,
                );
            }
            body
        };
        let torso = insert(&limbs.torso, None);
        // Hips first: joint j is then degree of freedom 6 + j.
        let thighs = core::array::from_fn(|leg| insert(&limbs.legs[leg].thigh, None));
        let ball = || ColliderBuilder::ball(real(limbs.foot_radius_m));
        let feet = core::array::from_fn(|leg| vector(&limbs.legs[leg].foot_m));
        let shins =
            core::array::from_fn(|leg| insert(&limbs.legs[leg].shin, Some(ball().translation(feet[leg]))));
        for (leg, thigh) in limbs.legs.iter().zip(thighs) {
            physics.multibody_joints.insert(torso, thigh, hinge(&leg.hip), true);
        }
        for (leg, (thigh, shin)) in limbs.legs.iter().zip(core::iter::zip(thighs, shins)) {
            physics.multibody_joints.insert(thigh, shin, hinge(&leg.knee), true);
        }

        // `insert` has just put the torso into a multibody.
        #[expect(clippy::expect_used, reason = "an invariant of the lines above")]
        let multibody =
            physics.multibody_joints.rigid_body_link(torso).expect("the torso has four hips").multibody;
        let axes = core::array::from_fn(|j| {
            let leg = &limbs.legs[j % LEG_COUNT];
            pose(&if j < LEG_COUNT { &leg.hip } else { &leg.knee }.in_parent).rotation * Vector::X
        });
        let knees = core::array::from_fn(|leg| pose(&limbs.legs[leg].knee.in_child).translation);
        let mut body = Self { physics, torso, thighs, shins, multibody, axes, feet, knees };
        body.pose(servo, start);
        body
    }

    /// Sets what resists the joints' speed until it is set again.
    pub fn set_damping(&mut self, of_joints_n_m_s_rad: &[f64; JOINT_COUNT]) {
        let Some(multibody) = self.physics.multibody_joints.get_multibody_mut(self.multibody) else { return };
        // After the torso's six, or none where a test holds it fixed.
        let first = multibody.damping().len().saturating_sub(JOINT_COUNT);
        for (damping, &wanted) in multibody.damping_mut().iter_mut().skip(first).zip(of_joints_n_m_s_rad) {
            *damping = real(wanted);
        }
    }

    /// Sets joint angles and the dry friction of servos, and settles all poses.
    fn pose(&mut self, servo: &Servo, start: &Pose0) {
        let PhysicsWorld { multibody_joints, bodies, colliders, .. } = &mut self.physics;
        // Otherwise the centres of mass are known only from the second step on.
        for link in [self.torso].iter().chain(&self.thighs).chain(&self.shins) {
            bodies[*link].recompute_mass_properties_from_colliders(colliders);
        }
        let Some(multibody) = multibody_joints.get_multibody_mut(self.multibody) else { return };
        multibody.set_self_contacts_enabled(false);
        // Rapier damps every rotation by 0.1, that of the whole robot included.
        multibody.damping_mut().fill(0.0);
        if servo.friction_n_m > 0.0 {
            multibody.frictions_mut().rows_mut(TORSO_FREEDOMS, JOINT_COUNT).fill(real(servo.friction_n_m));
        }
        let mut displacements = [0.0; TORSO_FREEDOMS + JOINT_COUNT];
        for (displacement, &angle) in displacements[TORSO_FREEDOMS..].iter_mut().zip(&start.joint_angles_rad)
        {
            *displacement = real(angle);
        }
        multibody.forward_kinematics(bodies, true);
        multibody.apply_displacements(&displacements);
        multibody.forward_kinematics(bodies, false);
        multibody.update_rigid_bodies(bodies, true);
    }
}
