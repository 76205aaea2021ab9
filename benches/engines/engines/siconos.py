"""Siconos: Moreau-Jean time stepping with contacts; dry friction as a slider that is pressed on a plane."""

from importlib.metadata import PackageNotFoundError, version

import numpy as np
import siconos.kernel as sk
import siconos.numerics as sn

from engine import Setting
from stepping import drive, friction_level

NAME = "Siconos"
BOOK = "Siconos documentation, "
SETTINGS = [
    Setting("moreau_jean", "default", "MoreauJeanOSI(θ = 1/2), FrictionContact in two dimensions, step 1 ms",
            BOOK + "“Time stepping schemes”, “Friction contact”; the step is the user's", {"step_s": 1e-3, "theta": 0.5}),
    Setting("fine", "best", "MoreauJeanOSI(θ = 1), tolerance 1e-12, step 0.1 ms", BOOK + "“Time stepping schemes”, “Numerics solvers” (dparam)", {"step_s": 1e-4, "theta": 1.0, "tolerance": 1e-12}),
]


def versions():
    try:
        return f"siconos {version('siconos')}"
    except PackageNotFoundError:
        return "siconos, Debian's python3-siconos"


def run(scene, setting):
    step_s = setting.options["step_s"]
    # Two coordinates: the lever, and a slider that 1 N presses on a plane, so that the friction's level is its coefficient.
    lever = sk.LagrangianLinearTIDS(np.array([scene.theta_rad, 0.0]), np.array([scene.theta_dot_rad_s, 0.0]), np.diag([scene.inertia, 1.0]))
    lever.setFExtPtr(np.array([0.0, -1.0]))
    model = sk.NonSmoothDynamicalSystem(0.0, scene.duration_s + step_s)
    model.insertDynamicalSystem(lever)

    def contact(normal, tangent, gap, mu):
        law = sk.NewtonImpactFrictionNSL(0.0, 0.0, mu, 2)
        relation = sk.LagrangianLinearTIR(np.array([normal, tangent]), np.array([gap, 0.0]))
        model.link(sk.Interaction(law, relation), lever)
        return law

    dry = contact([0.0, 1.0], [1.0, 0.0], 0.0, scene.kinetic_n) if scene.dry else None
    contact([-1.0, 0.0], [0.0, 1.0], scene.high_rad, 0.0)
    contact([1.0, 0.0], [0.0, 1.0], -scene.low_rad, 0.0)
    problem = sk.FrictionContact(2, sn.SICONOS_FRICTION_2D_NSGS)
    if "tolerance" in setting.options:
        problem.numericsSolverOptions().dparam[sn.SICONOS_DPARAM_TOL] = setting.options["tolerance"]
    stepping = sk.TimeStepping(model, sk.TimeDiscretisation(0.0, step_s), sk.MoreauJeanOSI(setting.options["theta"]), problem)

    def step(bias_n, level_n, rest_n):
        if dry is not None:
            dry.setMu(friction_level(lever.velocity()[0], level_n, rest_n))
        lever.setFExtPtr(np.array([bias_n, -1.0]))
        stepping.computeOneStep()
        stepping.nextStep()

    return drive(scene, step_s, lambda: (lever.q()[0], lever.velocity()[0]), step)
