"""The fitted Ant as the peers' engines load it, made from host/robots/ant.

Holds two formats: MJCF with ground, servos and the fitted numbers, and a URDF written
from what MuJoCo compiled of it, so that PyBullet has the same masses, inertias, frames
and shapes. Does not depend on the reward or the observation.
"""

import xml.etree.ElementTree as tree

import mujoco
import numpy as np

from peers.task import PHYSICS_STEPS, CONTROL_HZ, ROBOT, SHIN_TIP_M

STEP_S = 1.0 / (CONTROL_HZ * PHYSICS_STEPS)
HIPS, KNEES = [f"hip{leg}" for leg in range(1, 5)], [f"knee{leg}" for leg in range(1, 5)]


def mjcf(task):
    """ant.xml with robot.toml's overrides, flat ground and eight position actuators."""
    robot, root = task.robot, tree.parse(ROBOT / "ant.xml").getroot()
    servo, friction = robot["servo"], robot["ground"]["friction"]
    # Servos that are fixed to a part become a part of it, as in our simulation.
    root.find("compiler").set("fusestatic", "true")
    # Solver, cone and integrator are MuJoCo's defaults.
    tree.SubElement(root, "option", timestep=repr(STEP_S))
    defaults = root.find("default")
    # Robot and ground touch, parts of the robot do not: contype meets conaffinity.
    tree.SubElement(defaults, "geom", contype="1", conaffinity="2", friction=f"{friction} 0 0", condim="3")
    # Computed implicitly in the joints, as ours is.
    stop = repr(servo["end_stop_deg"])
    tree.SubElement(
        defaults, "joint", damping=repr(servo["damping_n_m_s_rad"]), limited="true", range=f"-{stop} {stop}"
    )
    world = root.find("worldbody")
    ground = {"type": "plane", "size": "0 0 1", "contype": "2", "conaffinity": "1"}
    tree.SubElement(world, "geom", name="ground", **ground)
    torso = root.find(".//body[@name='torso']")
    inertial = torso.find("inertial")
    share = robot["mass"]["torso_kg"] / float(inertial.get("mass"))
    inertial.set("mass", repr(robot["mass"]["torso_kg"]))
    inertial.set("diaginertia", " ".join(repr(float(n) * share) for n in inertial.get("diaginertia").split()))
    for leg in range(1, 5):
        shin = root.find(f".//body[@name='shin{leg}']")
        shin.set("euler", f"0 {robot['geometry']['shin_below_horizontal_deg']!r} 0")
        foot = shin.find("geom[@type='sphere']")
        tip_m = float(foot.get("pos").split()[0]) + float(foot.get("size"))
        if abs(tip_m - SHIN_TIP_M) > 1e-9:
            raise ValueError(f"a shin of ant.xml ends at {tip_m} m, task.py says {SHIN_TIP_M}")
        foot.set("name", f"foot{leg}")
        foot.set("size", repr(task.foot_radius_m))
        foot.set("pos", f"{task.foot_m!r} 0 0")
    actuators = tree.SubElement(root, "actuator")
    limit = repr(servo["torque_limit_n_m"])
    for joint, stiffness in zip(HIPS + KNEES, task.stiffness_n_m_rad):
        tree.SubElement(
            actuators, "position", joint=joint, kp=repr(float(stiffness)), forcerange=f"-{limit} {limit}"
        )
    return tree.tostring(root, encoding="unicode")


def numbers(values):
    return " ".join(repr(float(value)) for value in values)


def rotation(quaternion_wxyz):
    """URDF's roll, pitch, yaw."""
    w, x, y, z = quaternion_wxyz
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2 * (w * y - z * x), -1.0, 1.0))
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return numbers([roll, pitch, yaw])


def urdf(task, model):
    """The body as MuJoCo compiled it, for PyBullet; one link for each moving part."""
    root = tree.Element("robot", name="ant")
    servo = task.robot["servo"]
    for body in range(1, model.nbody):
        link = tree.SubElement(root, "link", name=model.body(body).name)
        inertial = tree.SubElement(link, "inertial")
        # Along the link's own axes: PyBullet takes a base's inertial frame for the base's frame.
        tree.SubElement(inertial, "origin", xyz=numbers(model.body_ipos[body]), rpy="0 0 0")
        tree.SubElement(inertial, "mass", value=repr(float(model.body_mass[body])))
        axes = np.empty(9)
        mujoco.mju_quat2Mat(axes, model.body_iquat[body])
        axes = axes.reshape(3, 3)
        tensor = axes @ np.diag(model.body_inertia[body]) @ axes.T
        places = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}
        # Rounding errors off the diagonal must not become a rotation.
        tensor[np.abs(tensor) < 1e-9 * tensor.max()] = 0.0
        tree.SubElement(inertial, "inertia", **{name: repr(float(tensor[at])) for name, at in places.items()})
        for geom in range(model.ngeom):
            if model.geom_bodyid[geom] == body and model.geom_contype[geom]:
                collision = tree.SubElement(link, "collision")
                frame = {"xyz": numbers(model.geom_pos[geom]), "rpy": rotation(model.geom_quat[geom])}
                tree.SubElement(collision, "origin", **frame)
                shape(tree.SubElement(collision, "geometry"), model.geom_type[geom], model.geom_size[geom])
        if body == 1:
            continue
        name = model.joint(model.body_jntadr[body]).name
        joint = tree.SubElement(root, "joint", name=name, type="revolute")
        tree.SubElement(joint, "parent", link=model.body(model.body_parentid[body]).name)
        tree.SubElement(joint, "child", link=model.body(body).name)
        frame = {"xyz": numbers(model.body_pos[body]), "rpy": rotation(model.body_quat[body])}
        tree.SubElement(joint, "origin", **frame)
        tree.SubElement(joint, "axis", xyz=numbers(model.jnt_axis[model.body_jntadr[body]]))
        low, high = model.jnt_range[model.body_jntadr[body]]
        limit = {"lower": low, "upper": high, "effort": servo["torque_limit_n_m"], "velocity": 100.0}
        tree.SubElement(joint, "limit", **{key: repr(float(value)) for key, value in limit.items()})
    return tree.tostring(root, encoding="unicode")


def shape(geometry, kind, size):
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        tree.SubElement(geometry, "box", size=numbers(2 * size))
    elif kind == mujoco.mjtGeom.mjGEOM_SPHERE:
        tree.SubElement(geometry, "sphere", radius=repr(float(size[0])))
    elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        tree.SubElement(geometry, "capsule", radius=repr(float(size[0])), length=repr(float(2 * size[1])))
    else:
        raise ValueError(f"ant.xml has a shape of MuJoCo's kind {kind}: add it to scripts/peers/body.py")
