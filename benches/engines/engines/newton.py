"""Newton on the processor: one model, given to each of its solvers for jointed bodies."""

import warnings
from importlib.metadata import version

import newton
import numpy as np
import warp as wp

from engine import Setting
from stepping import drive, friction_level

NAME = "Newton"
BOOK = "Newton documentation, "
SETTINGS = [
    Setting("mujoco", "default", "SolverMuJoCo, step 1/600 s as in its examples", BOOK + "Solvers, “Joint feature support”; examples (60 frames of 10 substeps)",
            {"solver": "SolverMuJoCo", "step_s": 1 / 600}),
    Setting("kamino", "best", "SolverKamino, step 2 ms", BOOK + "Solvers, “Joint feature support”; SolverKamino (joint friction, joint limits)",
            {"solver": "SolverKamino", "step_s": 2e-3}),
    *[Setting(name.removeprefix("Solver").lower(), "more", f"{name}, step 1 ms", "", {"solver": name, "step_s": 1e-3})
      for name in ("SolverXPBD", "SolverFeatherstone", "SolverSemiImplicit", "SolverVBD", "SolverSteel")],
]
# A solver that was built without friction takes none later, N m.
LEAST_NM = 1e-9
# Their state is that of bodies; theta is found from it.
MAXIMAL = ("SolverXPBD", "SolverSemiImplicit", "SolverVBD", "SolverKamino")


def versions():
    return ", ".join(f"{name} {version(name)}" for name in ("newton", "warp-lang", "mujoco-warp", "mujoco"))


def run(scene, setting):
    wp.config.quiet = True
    warnings.simplefilter("ignore")
    name, step_s = setting.options["solver"], setting.options["step_s"]
    with wp.ScopedDevice("cpu"):
        builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
        inertia = scene.mass_kg * scene.lever_m**2
        body = builder.add_link(mass=scene.mass_kg, inertia=wp.mat33(np.eye(3) * inertia))
        joint = builder.add_joint_revolute(-1, body, axis=(0, 0, 1), friction=max(scene.kinetic_n * scene.lever_m, LEAST_NM * scene.dry),
                                           limit_lower=scene.low_rad, limit_upper=scene.high_rad)
        builder.add_articulation([joint])
        builder.joint_q[0], builder.joint_qd[0] = scene.theta_rad, scene.theta_dot_rad_s
        if name == "SolverVBD":
            builder.color()
        model = builder.finalize()
        options = {"enable_joint_limits": True} if name == "SolverSteel" else {}
        solver = getattr(newton.solvers, name)(model, **options)
        now, after, control = model.state(), model.state(), model.control()
        newton.eval_fk(model, model.joint_q, model.joint_qd, now)
        newton.eval_fk(model, model.joint_q, model.joint_qd, after)
        q, qd = wp.clone(model.joint_q), wp.clone(model.joint_qd)
        # On the processor these are views of the engine's own memory.
        friction, push = model.joint_friction.numpy(), control.joint_f.numpy()
        solver.step(now, after, control, None, step_s)  # compiles
        # A solver remembers the pose of its last step.
        solver = getattr(newton.solvers, name)(model, **options)
        now, after = model.state(), model.state()
        newton.eval_fk(model, model.joint_q, model.joint_qd, now)

        def read():
            if name in MAXIMAL:
                newton.eval_ik(model, now, q, qd)
                return float(q.numpy()[0]), float(qd.numpy()[0])
            return float(now.joint_q.numpy()[0]), float(now.joint_qd.numpy()[0])

        def step(bias_n, level_n, rest_n):
            nonlocal now, after
            level_nm = np.float32(max(scene.lever_m * friction_level(read()[1], level_n, rest_n), LEAST_NM)) if scene.dry else np.float32(0.0)
            if friction[0] != level_nm:
                friction[0] = level_nm
                solver.notify_model_changed(newton.ModelFlags.JOINT_DOF_PROPERTIES)
            push[0] = scene.lever_m * bias_n
            now.clear_forces()
            solver.step(now, after, control, None, step_s)
            now, after = after, now

        return drive(scene, step_s, read, step)
