"""The task in PyBullet, as a gymnasium environment for Stable-Baselines3.

Holds one connection to the engine. Solver iterations and substeps are set as
pybullet-gym's scenes set them, on which the paper's authors built.
"""

import gymnasium
import numpy as np
import pybullet
from pybullet_utils.bullet_client import BulletClient

from peers.task import ACTION, CONTROL_HZ, OBSERVATION, PHYSICS_STEPS

SOLVER_ITERATIONS = 5


class BulletAnt(gymnasium.Env):
    def __init__(self, task, urdf_path, seed=0):
        self.task, self.rng = task, np.random.default_rng(seed)
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (OBSERVATION,), np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (ACTION,), np.float32)
        self.engine = engine = BulletClient(connection_mode=pybullet.DIRECT)
        engine.setGravity(0.0, 0.0, -9.81)
        engine.setPhysicsEngineParameter(
            fixedTimeStep=1.0 / CONTROL_HZ, numSubSteps=PHYSICS_STEPS, numSolverIterations=SOLVER_ITERATIONS
        )
        ground = engine.createMultiBody(0.0, engine.createCollisionShape(pybullet.GEOM_PLANE))
        self.robot = engine.loadURDF(str(urdf_path), flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
        joints = {engine.getJointInfo(self.robot, j)[1].decode(): j for j in range(ACTION)}
        self.joints = [joints[f"{kind}{leg}"] for kind in ("hip", "knee") for leg in range(1, 5)]
        servo = task.robot["servo"]
        # The engine multiplies the friction of both surfaces.
        engine.changeDynamics(ground, -1, lateralFriction=1.0)
        for link in range(-1, ACTION):
            engine.changeDynamics(
                self.robot, link, lateralFriction=task.robot["ground"]["friction"], linearDamping=0.0,
                angularDamping=0.0, jointDamping=0.0,
            )  # fmt: skip
        # The engine's position motor approaches its target by this share each physics step, at
        # the rate of our spring with its damper: a lag of damping / stiffness.
        step_s = 1.0 / (CONTROL_HZ * PHYSICS_STEPS)
        self.gains = list(step_s * task.stiffness_n_m_rad / servo["damping_n_m_s_rad"])
        self.velocity_gains = [1.0] * ACTION
        self.torques = [servo["torque_limit_n_m"]] * ACTION
        # Beyond this distance of the target the spring is at the torque limit.
        self.pull_rad = servo["torque_limit_n_m"] / task.stiffness_n_m_rad

    def read(self):
        engine, robot = self.engine, self.robot
        position, orientation = engine.getBasePositionAndOrientation(robot)
        velocity, turning = engine.getBaseVelocity(robot)
        states = engine.getJointStates(robot, self.joints)
        self.position, self.orientation = np.array([position]), np.array([orientation])
        self.velocity, self.turning = np.array([velocity]), np.array([turning])
        self.angles = np.array([[state[0] for state in states]])
        self.speeds = np.array([[state[1] for state in states]])

    def observe(self):
        seen = self.task.observe(
            self.position, self.orientation, self.velocity, self.turning, self.angles, self.speeds
        )
        return seen[0]

    def reset(self, seed=None, options=None):
        if seed is not None:
            self.rng = np.random.default_rng(seed)
        angles = (options or {}).get("angles")
        angles = self.task.start_angles(self.rng) if angles is None else angles
        height_m = self.task.standing_height_m(angles)
        self.engine.resetBasePositionAndOrientation(self.robot, [0.0, 0.0, height_m], [0.0, 0.0, 0.0, 1.0])
        self.engine.resetBaseVelocity(self.robot, [0.0] * 3, [0.0] * 3)
        for joint, angle in zip(self.joints, angles):
            self.engine.resetJointState(self.robot, joint, angle, 0.0)
        self.setpoint_rad, self.steps = np.array(angles), 0
        self.read()
        return self.observe(), {}

    def step(self, action):
        action = np.clip(action, -1.0, 1.0)
        self.setpoint_rad = self.task.setpoint(self.setpoint_rad, action)
        pull = np.clip(self.setpoint_rad - self.angles[0], -self.pull_rad, self.pull_rad)
        self.engine.setJointMotorControlArray(
            self.robot, self.joints, pybullet.POSITION_CONTROL, targetPositions=self.angles[0] + pull,
            forces=self.torques, positionGains=self.gains, velocityGains=self.velocity_gains,
        )  # fmt: skip
        before_m = self.position[:, 0]
        self.engine.stepSimulation()
        self.steps += 1
        self.read()
        reward, fell = self.task.weigh(
            action[None], self.position[:, 0] - before_m, self.position[:, 2], self.angles, self.speeds
        )
        cut = not fell[0] and self.steps >= self.task.episode_steps
        return self.observe(), float(reward[0]), bool(fell[0]), cut, {}

    def close(self):
        self.engine.disconnect()
