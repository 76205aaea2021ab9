"""MuJoCo Warp on the processor: MuJoCo's equations as Warp kernels, in float32."""

import importlib.metadata

import mujoco
import mujoco_warp as mjw
import warp as wp

from engine import Setting
from engines.mujoco import mjcf
from stepping import drive, friction_level

NAME = "MuJoCo Warp"
BOOK = "MuJoCo documentation, MuJoCo Warp (MJWarp), "
SETTINGS = [
    Setting("default", "default", "timestep 2 ms, Euler", BOOK + "“Feature Parity”", {"step_s": 2e-3}),
    Setting("noslip", "best", "timestep 1 ms, noslip_iterations 100, time constant of friction 2 steps, of limits 5",
            BOOK + "“Feature Parity”; Computation, “NoSlip solver”; “Solver parameters”",
            {"step_s": 1e-3, "noslip": 100, "solref": (5e-3, 1.0), "friction": (2e-3, 1.0)}),
]


def versions():
    return f"mujoco-warp {importlib.metadata.version('mujoco-warp')}, warp-lang {wp.__version__}, mujoco {mujoco.__version__}"


def run(scene, setting):
    wp.config.quiet = True
    wp.init()
    plain = mujoco.MjModel.from_xml_string(mjcf(scene, **setting.options))
    start = mujoco.MjData(plain)
    start.qpos[0], start.qvel[0] = scene.theta_rad, scene.theta_dot_rad_s
    with wp.ScopedDevice("cpu"):
        model, data = mjw.put_model(plain), mjw.put_data(plain, start)
        # On the processor these are views of the engine's own memory.
        qpos, qvel, applied = data.qpos.numpy(), data.qvel.numpy(), data.qfrc_applied.numpy()
        friction = model.dof_frictionloss.numpy()
        mjw.step(model, data)  # compiles
        qpos[0, 0], qvel[0, 0] = scene.theta_rad, scene.theta_dot_rad_s
        data.qacc_warmstart.zero_()

        def step(bias_n, level_n, rest_n):
            if scene.dry:
                friction[..., 0] = scene.lever_m * friction_level(qvel[0, 0], level_n, rest_n)
            applied[0, 0] = scene.lever_m * bias_n
            mjw.step(model, data)

        return drive(scene, plain.opt.timestep, lambda: (float(qpos[0, 0]), float(qvel[0, 0])), step)
