"""DART: a revolute joint with Coulomb friction and enforced limits."""

import dartpy as dart
import numpy as np

from engine import Setting
from stepping import drive, friction_level

NAME = "DART"
BOOK = "DART documentation, "
SETTINGS = [
    Setting("default", "default", "time step 1 ms", BOOK + "World (getTimeStep), Joint (setCoulombFriction, setLimitEnforcement)", {"step_s": 1e-3}),
    Setting("fine", "best", "time step 0.1 ms", BOOK + "World (setTimeStep)", {"step_s": 1e-4}),
    Setting("fine_20us", "more", "time step 20 µs", "", {"step_s": 2e-5}),
]


def versions():
    return f"dartpy {dart.__version__}"


def world(scene, step_s):
    world = dart.simulation.World()
    world.setTimeStep(step_s)
    world.setGravity([0, 0, 0])
    skeleton = dart.dynamics.Skeleton("rig")
    joint, body = skeleton.createRevoluteJointAndBodyNodePair()
    joint.setAxis([0, 0, 1])
    inertia = dart.dynamics.Inertia(scene.mass_kg, [scene.lever_m, 0, 0], np.eye(3) * 1e-12)
    body.setInertia(inertia)
    joint.setPositionLowerLimit(0, scene.low_rad)
    joint.setPositionUpperLimit(0, scene.high_rad)
    joint.setLimitEnforcement(True)
    joint.setCoulombFriction(0, scene.kinetic_n * scene.lever_m)
    world.addSkeleton(skeleton)
    skeleton.setPosition(0, scene.theta_rad)
    skeleton.setVelocity(0, scene.theta_dot_rad_s)
    return world, skeleton, joint


def run(scene, setting):
    rig, skeleton, joint = world(scene, setting.options["step_s"])
    lever_m = scene.lever_m

    def step(bias_n, level_n, rest_n):
        if scene.dry:
            joint.setCoulombFriction(0, lever_m * friction_level(skeleton.getVelocity(0), level_n, rest_n))
        skeleton.setForce(0, lever_m * bias_n)
        rig.step()

    return drive(scene, setting.options["step_s"], lambda: (skeleton.getPosition(0), skeleton.getVelocity(0)), step)
