"""PyBullet: a revolute joint of a multibody (Featherstone), dry friction by its joint motor."""

import tempfile
from importlib.metadata import version
from pathlib import Path

import pybullet as p

from engine import Setting
from stepping import drive, friction_level

NAME = "PyBullet"
GUIDE = "PyBullet Quickstart Guide, "
SETTINGS = [
    Setting("default", "default", "timeStep 1/240 s, damping 0.04; friction by the joint's motor (velocity 0, force = friction), for that of a URDF does nothing",
            GUIDE + "“setTimeStep”, “setJointMotorControl2”, “changeDynamics”", {"step_s": 1 / 240, "damped": True}),
    Setting("motor", "best", "timeStep 0.1 ms; friction by the joint's motor; no damping; no limit of the speed",
            GUIDE + "“setJointMotorControl2” (“joint friction … small force”), “changeDynamics” (linearDamping, angularDamping, jointDamping, maxJointVelocity)",
            {"step_s": 1e-4, "damped": False}),
    Setting("motor_1ms", "more", "the same, timeStep 1 ms", "", {"step_s": 1e-3, "damped": False}),
    Setting("motor_20us", "more", "the same, timeStep 20 µs", "", {"step_s": 2e-5, "damped": False}),
]


def versions():
    return f"pybullet {version('pybullet')}"


def urdf(scene):
    """The lever as a point mass at its end."""
    return f"""<robot name="rig">
  <link name="base"><inertial><mass value="0"/><inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="lever"><inertial><origin xyz="{scene.lever_m!r} 0 0"/><mass value="{scene.mass_kg!r}"/>
    <inertia ixx="1e-12" iyy="1e-12" izz="1e-12" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="lever" type="revolute"><parent link="base"/><child link="lever"/><axis xyz="0 0 1"/>
    <limit lower="{scene.low_rad!r}" upper="{scene.high_rad!r}" effort="1000" velocity="1000"/></joint>
</robot>"""


def run(scene, setting):
    step_s, lever_m = setting.options["step_s"], scene.lever_m
    client = p.connect(p.DIRECT)
    try:
        p.setTimeStep(step_s)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "lever.urdf"
            path.write_text(urdf(scene))
            body = p.loadURDF(str(path), useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
        if not setting.options["damped"]:
            p.changeDynamics(body, -1, linearDamping=0, angularDamping=0)
            p.changeDynamics(body, 0, linearDamping=0, angularDamping=0, jointDamping=0, maxJointVelocity=1e4)
        p.resetJointState(body, 0, scene.theta_rad, scene.theta_dot_rad_s)
        # Every joint begins with a motor that holds it.
        p.setJointMotorControl2(body, 0, p.VELOCITY_CONTROL, force=0)

        def read():
            return p.getJointState(body, 0)[:2]

        def step(bias_n, level_n, rest_n):
            if scene.dry:
                friction_nm = lever_m * friction_level(p.getJointState(body, 0)[1], level_n, rest_n)
                p.setJointMotorControl2(body, 0, p.VELOCITY_CONTROL, targetVelocity=0, force=friction_nm)
            p.setJointMotorControl2(body, 0, p.TORQUE_CONTROL, force=lever_m * bias_n)
            p.stepSimulation()

        return drive(scene, step_s, read, step)
    finally:
        p.disconnect(client)
