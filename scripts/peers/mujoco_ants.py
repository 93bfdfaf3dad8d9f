"""The task in MuJoCo: several Ants in one process, a row each.

Holds their states and episodes. One call of the engine for each control step and robot;
observation and reward are computed for all robots together, which is fastest in numpy.
"""

import mujoco
import numpy as np

from peers.body import mjcf
from peers.task import ACTION, PHYSICS_STEPS

# In the order of the file each leg's knee follows its hip.
JOINTS = np.array([0, 2, 4, 6, 1, 3, 5, 7])


class MujocoAnts:
    def __init__(self, task, robots, seed=0):
        self.task, self.rng = task, np.random.default_rng(seed)
        self.model = mujoco.MjModel.from_xml_string(mjcf(task))
        self.worlds = [mujoco.MjData(self.model) for _ in range(robots)]
        # Views into the engine's memory, made once.
        self.views = [(world.qpos, world.qvel, world.ctrl) for world in self.worlds]
        self.q, self.v = np.empty((robots, 15)), np.empty((robots, 14))
        self.setpoint_rad, self.steps = np.zeros((robots, ACTION)), np.zeros(robots, int)
        for robot in range(robots):
            self.reset(robot)
        self.observation = self.observe()

    def reset(self, robot, angles=None):
        angles = self.task.start_angles(self.rng) if angles is None else angles
        mujoco.mj_resetData(self.model, self.worlds[robot])
        q, v, _ = self.views[robot]
        q[:3] = 0.0, 0.0, self.task.standing_height_m(angles)
        q[7 + JOINTS] = angles
        self.q[robot], self.v[robot] = q, v
        self.setpoint_rad[robot], self.steps[robot] = angles, 0

    def observe(self):
        q, v = self.q, self.v
        w, axis = q[:, 3:4], q[:, 4:7]
        # The engine's angular velocity is in the torso's frame, the task's in the world's.
        turning = v[:, 3:6]
        twice = 2.0 * cross(axis, turning)
        turning = turning + w * twice + cross(axis, twice)
        xyzw = q[:, [4, 5, 6, 3]]
        return self.task.observe(q[:, :3], xyzw, v[:, :3], turning, q[:, 7 + JOINTS], v[:, 6 + JOINTS])

    def step(self, action, playing=None):
        """Next observations, rewards, terminal, truncated. Afterwards `observation` is that of the new
        episode where one has ended. Robots that are not `playing` stand still; their rows mean nothing."""
        action = np.clip(action, -1.0, 1.0)
        self.setpoint_rad = self.task.setpoint(self.setpoint_rad, action)
        before_m = self.q[:, 0].copy()
        for robot in range(len(self.worlds)) if playing is None else playing:
            q, v, control = self.views[robot]
            control[:] = self.setpoint_rad[robot]
            mujoco.mj_step(self.model, self.worlds[robot], PHYSICS_STEPS)
            self.q[robot], self.v[robot] = q, v
        self.steps += 1
        angles, speeds = self.q[:, 7 + JOINTS], self.v[:, 6 + JOINTS]
        reward, fell = self.task.weigh(action, self.q[:, 0] - before_m, self.q[:, 2], angles, speeds)
        cut = ~fell & (self.steps >= self.task.episode_steps)
        following = self.observation = self.observe()
        over = np.flatnonzero(fell | cut)
        if len(over):
            for robot in over:
                self.reset(robot)
            self.observation = self.observe()
        return following, reward, fell, cut


def cross(a, b):
    """numpy.cross takes five times as long for a few rows."""
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
