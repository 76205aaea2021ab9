"""Scenes as Drake and PyBullet read them: `zwidth simulate --as`, run, against the exact solver.

    python engines.py --zwidth PROGRAM

Their packages are large (engines.txt), so this is part of .ci/long. What smaller ones read is in others.py.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np
import pybullet
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from checks import check, close, end, equal
from others import LEVER, MASS, QUARTER, SCENES, Scene, off

STEP = 0.002
# Steps of first order of 2 ms, rad.
SMOOTH = 2e-3


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--zwidth", type=Path, required=True, help="the program")
    zwidth = arguments.parse_args().zwidth.resolve()
    with tempfile.TemporaryDirectory() as folder:
        for name in SCENES:
            scene = Scene(zwidth, folder, name)
            found = off(scene.ran("drake"), scene.exact())
            check(f"{name} as drake: within 1e-6 rad of the exact motion", found < 1e-6, found)
        numbers(zwidth, folder)
        # A spring that never asks for what its motor lacks, and a lever that only its own drag holds.
        for name, form, push in (
            ("sine", "sdf", lambda t: 1.0 + np.sin(3.0 * t)),
            ("swing", "sdf", lambda t: 0.05 + 0.05 * np.sin(3.0 * t)),
            ("swing", "urdf", lambda t: 0.05 + 0.05 * np.sin(3.0 * t)),
        ):
            scene = Scene(zwidth, folder, name)
            exact = scene.exact()
            found = off(pushed_in_drake(scene, form, push, exact), exact)
            check(f"{name} as {form} in Drake: within {SMOOTH:g} rad of the exact motion", found < SMOOTH, found)
        scene = Scene(zwidth, folder, "swing")
        exact = scene.exact()
        found = off(pushed_in_bullet(scene, lambda t: 0.05 + 0.05 * np.sin(3.0 * t), exact), exact)
        check(f"swing as urdf in PyBullet: within {SMOOTH:g} rad of the exact motion", found < SMOOTH, found)
    end()


def plant_of(scene, form):
    """A plant of Drake in steps of the scene."""
    plant = MultibodyPlant(STEP)
    Parser(plant).AddModels(str(scene.written(form, form)))
    plant.Finalize()
    return plant


def pushed_in_drake(scene, form, push, exact):
    """Times and angles of a lever under the scene's force, which is applied from here."""
    plant = plant_of(scene, form)
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    plant.SetPositions(context, [exact[0, 1]])
    force = plant.get_applied_generalized_force_input_port()
    found = np.empty((len(exact), 2))
    for i, t in enumerate(exact[:, 0]):
        found[i] = t, plant.GetPositions(context)[0]
        # That of the step's middle stands for the step.
        force.FixValue(context, [LEVER * push(t + STEP / 2)])
        simulator.AdvanceTo(t + STEP)
    return found


def pushed_in_bullet(scene, push, exact):
    """The same in PyBullet, whose own motor at the joint and damping of bodies are switched off."""
    world = pybullet.connect(pybullet.DIRECT)
    pybullet.setTimeStep(STEP)
    robot = pybullet.loadURDF(str(scene.written("urdf", "urdf")), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    pybullet.resetJointState(robot, 0, exact[0, 1])
    pybullet.setJointMotorControl2(robot, 0, pybullet.VELOCITY_CONTROL, force=0)
    pybullet.changeDynamics(robot, -1, linearDamping=0.0, angularDamping=0.0)
    found = np.empty((len(exact), 2))
    for i, t in enumerate(exact[:, 0]):
        found[i] = t, pybullet.getJointState(robot, 0)[0]
        pybullet.setJointMotorControl2(robot, 0, pybullet.TORQUE_CONTROL, force=LEVER * push(t + STEP / 2))
        pybullet.stepSimulation()
    pybullet.disconnect(world)
    return found


def numbers(zwidth, folder):
    """The scene's numbers in the plants that Drake makes of SDFormat and URDF, and in PyBullet's robot."""
    scene = Scene(zwidth, folder, "finger_with_end")
    for form in ("sdf", "urdf"):
        plant = plant_of(scene, form)
        inertia = plant.CalcMassMatrix(plant.CreateDefaultContext())
        close(f"{form} in Drake: the lever and the finger about the axis", inertia[0, 0], (MASS + 0.021) * LEVER**2, 1e-12)
        close(f"{form} in Drake: the finger about the axis", inertia[1, 1], 0.021 * LEVER**2, 1e-12)
        equal(f"{form} in Drake: stops", (plant.GetPositionLowerLimits()[0], plant.GetPositionUpperLimits()[0]), (-QUARTER, QUARTER))
        close(f"{form} in Drake: the tissue's end", plant.GetPositionUpperLimits()[1], 0.006 / LEVER, 1e-12)
        drag = 0.3 + (1.0 if form == "sdf" else 0.0)  # SDFormat has the environment's damper in the joint
        close(f"{form} in Drake: drag", plant.GetJointByName("hinge").default_damping(), drag * LEVER, 1e-12)
    weight = plant_of(Scene(zwidth, folder, "weight"), "sdf")
    weight.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -9.80665])  # Drake does not read the world's
    context = weight.CreateDefaultContext()
    weight.SetPositions(context, [0.3])
    moment = weight.CalcGravityGeneralizedForces(context)[0]
    close("sdf in Drake: moment of the weight", moment, 0.2 * 9.80665 * 0.05 * np.sin(0.3), 1e-12)
    world = pybullet.connect(pybullet.DIRECT)
    robot = pybullet.loadURDF(str(scene.written("urdf", "urdf")), useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    inertia = np.array(pybullet.calculateMassMatrix(robot, [0.0, 0.0]))
    close("urdf in PyBullet: the lever and the finger about the axis", inertia[0, 0], (MASS + 0.021) * LEVER**2, 1e-9)
    told = pybullet.getJointInfo(robot, 0)
    close("urdf in PyBullet: dry friction", told[7], 0.5 * LEVER, 1e-12)
    close("urdf in PyBullet: drag", told[6], 0.3 * LEVER, 1e-12)
    equal("urdf in PyBullet: stops", (told[8], told[9]), (-QUARTER, QUARTER))
    pybullet.disconnect(world)


main()
