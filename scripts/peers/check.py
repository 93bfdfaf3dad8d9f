"""Compares the peers' bodies, tasks and gaits with each other (bench-peers.py --check).

Holds the comparison. Does not depend on timing; it takes a few seconds.
"""

import pathlib
import tempfile

import mujoco
import numpy as np

from peers import body
from peers.bullet_ant import BulletAnt
from peers.mujoco_ants import MujocoAnts
from peers.task import CONTROL_HZ, Task, trot

POSES_RAD = [np.zeros(8), np.linspace(-0.5, 0.5, 8), np.array([0.3, -0.3] * 4)]
WALK_S = 12
RANDOM_STEPS = 2_000
STANDING_M = 0.17


def mass_kg(bullet):
    return sum(bullet.engine.getDynamicsInfo(bullet.robot, link)[0] for link in range(-1, 8))


def shins_bullet_m(bullet, angles):
    bullet.reset(options={"angles": angles})
    knees = bullet.engine.getLinkStates(bullet.robot, bullet.joints[4:], computeForwardKinematics=1)
    # The shin's centre of mass, and its frame's origin: the knee.
    return np.array([[state[0], state[4]] for state in knees])


def shins_mujoco_m(ants, angles):
    ants.reset(0, angles)
    world = ants.worlds[0]
    mujoco.mj_kinematics(ants.model, world)
    shins = [ants.model.body(f"shin{leg}").id for leg in range(1, 5)]
    return np.stack([world.xipos[shins], world.xpos[shins]], 1)


def walked(step, reset):
    """Mean speed along x, m/s, and mean height of the torso's middle."""
    reset()
    rows = np.array([step(trot(number)) for number in range(WALK_S * CONTROL_HZ)])
    return (rows[-1, 0] - rows[0, 0]) / WALK_S, rows[:, 2].mean()


def report():
    """Prints what was compared; the exit status."""
    task, wrong = Task(), 0

    def say(what, value, expected, tolerance):
        nonlocal wrong
        good = bool(np.all(np.abs(np.asarray(value) - np.asarray(expected)) <= tolerance))
        wrong += not good
        shown = f"{float(np.ravel(value)[0]):.5f}, {float(np.ravel(expected)[0]):.5f}"
        print(f"{'ok   ' if good else 'WRONG'} {what}: {shown} (within {tolerance:g})")

    with tempfile.TemporaryDirectory() as folder:
        ants = MujocoAnts(task, 1)
        path = pathlib.Path(folder) / "ant.urdf"
        path.write_text(body.urdf(task, ants.model))
        bullet = BulletAnt(task, path)
        say("mass in PyBullet and MuJoCo, kg", mass_kg(bullet), ants.model.body_mass.sum(), 1e-6)
        for number, angles in enumerate(POSES_RAD):
            of = f"shins of pose {number} in both, m"
            say(of, shins_bullet_m(bullet, angles), shins_mujoco_m(ants, angles), 1e-6)

        # The numbers of `the_papers_five_terms_are_as_worked_out_by_hand` in host/src/sim/reward.rs,
        # but legs apart.
        action = np.array([[0.5, -0.5, 1.0, 0.0, 0.0, 0.0, 0.0, -1.0]])
        speeds = np.array([[2.0, -1.0, 0.0, 2.0, 0.0, 0.0, 0.0, 1.0]])
        angles = np.radians(45.0) * np.array([[0.5, -0.5, 0.995, 0.0, 0.0, 0.0, 0.0, -1.01]])
        reward, fell = task.weigh(action, np.array([0.12 / CONTROL_HZ]), np.array([0.15]), angles, speeds)
        touching = task.touching(angles)
        say("reward worked out by hand", reward + touching, 1.0 + 0.12 - 0.09375 - 0.2, 1e-12)
        say("legs 1 and 2 crossed touch", task.touching(np.radians([[60, -60] + [0] * 6])), 1, 0)
        say("all legs apart do not", task.touching(np.zeros((1, 8))), 0, 0)

        def with_bullet(action):
            bullet.step(action)
            return bullet.position[0]

        def with_mujoco(action):
            ants.step(action[None])
            return ants.q[0, :3].copy()

        starts = np.zeros(8)
        mujoco_m_s, height_m = walked(with_mujoco, lambda: ants.reset(0, starts))
        print(f"      the torso walks at {height_m:.3f} m in MuJoCo", end="")
        bullet_m_s, height_m = walked(with_bullet, lambda: bullet.reset(options={"angles": starts}))
        print(f", at {height_m:.3f} m in PyBullet")
        say("speed of host bench's trot in PyBullet and MuJoCo, m/s", bullet_m_s, mujoco_m_s, 0.05)

        # Training starts with random actions: an engine that is unstable at this step would throw the robot up.
        for name, step in (("MuJoCo", with_mujoco), ("PyBullet", with_bullet)):
            rng = np.random.default_rng(0)
            highest_m = max(step(rng.uniform(-1.0, 1.0, 8))[2] for _ in range(RANDOM_STEPS))
            say(f"a torso under random actions stays low in {name}, m", highest_m, STANDING_M, STANDING_M)
        bullet.close()
    return 1 if wrong else 0
