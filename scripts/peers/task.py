"""The Ant's task as both peers play it: observation, reward and end of host/src/sim/ant_env.rs.

Holds the arithmetic, on arrays with a row for each robot, and reads the numbers from
host/configs/paper.toml and host/robots/ant/robot.toml. Does not depend on an engine. A
configuration with reward terms that are not written here is an error.
"""

import pathlib
import tomllib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONFIG = ROOT / "host/configs/paper.toml"
ROBOT = ROOT / "host/robots/ant"

# Keys of [env.reward] that `weigh` uses; any other one must have the weight 0.
REWARD_KEYS = {
    "alive",
    "alive_height_m",
    "forward",
    "electricity_form",
    "electricity",
    "stall",
    "joint_at_limit",
    "feet_collision",
}
OBSERVATION, ACTION = 27, 8
CONTROL_HZ, PHYSICS_STEPS = 60, 4
ACTION_RAD = np.radians(45.0)
# host/src/sim/reward.rs and ant_env.rs.
JOINT_SPEED_SCALE, AT_LIMIT_SHARE, TOUCHING_M = 0.1, 0.99, 0.02
# host/robots/ant/ant.xml; where the shin ends before the foot's radius is taken off it.
HIP_XY_M, THIGH_M, SHIN_TIP_M = 0.07, 0.1414, 0.23
LEG_RAD = np.radians([45.0, 135.0, 225.0, 315.0])
NEXT_LEG = [1, 2, 3, 0]


class Unsupported(Exception):
    """The configuration asks for something that the peers' task does not have."""


class Task:
    def __init__(self):
        self.config = tomllib.loads(CONFIG.read_text())
        self.robot = tomllib.loads((ROBOT / "robot.toml").read_text())
        env, self.reward = self.config["env"], self.config["env"]["reward"]
        unknown = [name for name, weight in self.reward.items() if name not in REWARD_KEYS and weight]
        if unknown:
            raise Unsupported(f"{CONFIG}: scripts/peers/task.py has no reward term {', '.join(unknown)}: add it there")
        plain = (
            self.reward["electricity_form"] == "action-times-speed"
            and "slew_limit_rad_s" not in env
            and env["max_tilt_rad"] > np.pi
            and self.config["leg_scale"] == 1.0
            and not any(env["start"][term] for term in ("yaw_rad", "height_m", "friction_share"))
        )
        if not plain:
            raise Unsupported(f"{CONFIG} has settings that scripts/peers/task.py does not have: add them there")
        self.episode_steps = env["episode_steps"]
        self.setpoint_limit = env["setpoint_limit"]
        self.start_joint_rad = env["start"]["joint_rad"]
        servo, geometry = self.robot["servo"], self.robot["geometry"]
        # A servo's own setpoint moves no faster than the servo turns without load.
        self.reach_rad = servo["no_load_speed_rad_s"] / CONTROL_HZ
        self.end_stop_rad = np.radians(servo["end_stop_deg"])
        self.foot_radius_m = geometry["foot_radius_m"]
        self.foot_m = SHIN_TIP_M - self.foot_radius_m
        self.slope_rad = np.radians(geometry["shin_below_horizontal_deg"])
        self.stiffness_n_m_rad = np.full(ACTION, servo["stiffness_n_m_rad"])

    def standing_height_m(self, angles):
        """Height of the level torso above its lowest foot."""
        return float(np.max(self.foot_m * np.sin(self.slope_rad + angles[4:]))) + self.foot_radius_m

    def start_angles(self, rng):
        return rng.uniform(-self.start_joint_rad, self.start_joint_rad, ACTION)

    def setpoint(self, setpoint_rad, action):
        """The servos' setpoints after an action."""
        asked = np.clip(action, -self.setpoint_limit, self.setpoint_limit) * ACTION_RAD
        asked = np.clip(asked, -self.end_stop_rad, self.end_stop_rad)
        return setpoint_rad + np.clip(asked - setpoint_rad, -self.reach_rad, self.reach_rad)

    @staticmethod
    def observe(position, quaternion_xyzw, velocity, turning, angles, speeds):
        """[robots, 27]; velocities in the world's frame."""
        seen = np.empty((len(position), OBSERVATION), np.float32)
        seen[:, 0] = position[:, 2]
        # q and -q are the same orientation: show the policy only one of them.
        seen[:, 1:5] = np.where(quaternion_xyzw[:, 3:] < 0.0, -quaternion_xyzw, quaternion_xyzw)
        seen[:, 5:13] = angles / ACTION_RAD
        seen[:, 13:16] = velocity
        seen[:, 16:19] = turning
        seen[:, 19:27] = JOINT_SPEED_SCALE * speeds
        return seen

    def weigh(self, action, moved_m, height_m, angles, speeds):
        """Rewards and ends, [robots] each; `moved_m` along x over the step."""
        reward = self.reward
        standing = height_m > reward["alive_height_m"]
        total = np.where(standing, reward["alive"], -reward["alive"])
        total += reward["forward"] * moved_m * CONTROL_HZ
        total += reward["electricity"] * JOINT_SPEED_SCALE / ACTION * np.abs(action * speeds).sum(1)
        total += reward["stall"] / ACTION * (action * action).sum(1)
        total += reward["joint_at_limit"] * (np.abs(angles) > AT_LIMIT_SHARE * ACTION_RAD).sum(1)
        total += reward["feet_collision"] * self.touching(angles)
        return total, ~standing

    def touching(self, angles):
        """Pairs of neighbouring shins nearer than TOUCHING_M, [robots], from the joint angles."""
        azimuth, slope = LEG_RAD + angles[:, :4], self.slope_rad + angles[:, 4:]
        flat = np.cos(slope)
        out = np.stack([np.cos(azimuth), np.sin(azimuth)], 2)
        hips = HIP_XY_M * np.sqrt(2.0) * np.stack([np.cos(LEG_RAD), np.sin(LEG_RAD)], 1)
        knees = np.zeros((len(angles), 4, 3))
        knees[:, :, :2] = hips + THIGH_M * out
        shins = np.empty((len(angles), 4, 3))
        shins[:, :, :2] = self.foot_m * flat[:, :, None] * out
        shins[:, :, 2] = -self.foot_m * np.sin(slope)
        middles = knees + 0.5 * shins
        apart = middles[:, NEXT_LEG] - middles
        # Shins whose middles are a shin apart cannot touch, which is true for nearly all.
        near = (apart * apart).sum(2) < (self.foot_m + TOUCHING_M) ** 2
        pairs = np.zeros(len(angles), int)
        for row, leg in np.argwhere(near):
            other = NEXT_LEG[leg]
            gap = segment_distance(knees[row, leg], shins[row, leg], knees[row, other], shins[row, other])
            pairs[row] += gap < TOUCHING_M
        return pairs


def segment_distance(from_a, along_a, from_b, along_b):
    """Minimum distance of two segments of the same length, which is not 0."""
    between = from_a - from_b
    aa, bb, ab = along_a @ along_a, along_b @ along_b, along_a @ along_b
    at_a = 0.0
    determinant = aa * bb - ab * ab
    if determinant > 1e-9 * aa * bb:
        at_a = np.clip((ab * (along_b @ between) - bb * (along_a @ between)) / determinant, 0.0, 1.0)
    # Clamped to one segment and then to the other.
    at_b = np.clip((ab * at_a + along_b @ between) / bb, 0.0, 1.0)
    at_a = np.clip((ab * at_b - along_a @ between) / aa, 0.0, 1.0)
    return np.linalg.norm(between + at_a * along_a - at_b * along_b)


def trot(step):
    """The action that `host bench` walks with: diagonal legs together, 1.6 s a stride."""
    phase = 2.0 * np.pi * step / CONTROL_HZ / 1.6 + np.pi * (np.arange(ACTION) % 2)
    # Counter-clockwise is backwards on the left and forwards on the right.
    side = np.where(np.arange(ACTION) < 2, 1.0, -1.0)
    return np.where(np.arange(ACTION) < 4, side * 0.5 * np.sin(phase), 0.3 * np.cos(phase)) / ACTION_RAD
