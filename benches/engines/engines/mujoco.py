"""MuJoCo: a hinge with frictionloss and a range."""

import mujoco

from engine import Setting
from stepping import drive, friction_level

NAME = "MuJoCo"
BOOK = "MuJoCo documentation, "  # of 4.0
SETTINGS = [
    Setting("default", "default", "timestep 2 ms, Euler, Newton, solref 0.02 1, solimp 0.9 0.95", BOOK + "XML Reference, “option” and “joint”", {"step_s": 2e-3}),
    Setting("noslip", "best", "timestep 0.1 ms, implicitfast, noslip_iterations 100, time constant of friction 2 steps, of limits 5",
            BOOK + "Computation, “NoSlip solver”; “Solver parameters” (timeconst at least 2 × timestep), “Preventing slip”",
            {"step_s": 1e-4, "integrator": "implicitfast", "noslip": 100, "solref": (5e-4, 1.0), "friction": (2e-4, 1.0)}),
    Setting("stiff_1ms", "more", "timestep 1 ms, noslip_iterations 100, time constant of friction 2 steps, of limits 5", "",
            {"step_s": 1e-3, "integrator": "implicitfast", "noslip": 100, "solref": (5e-3, 1.0), "friction": (2e-3, 1.0)}),
    Setting("noslip_default", "more", "the defaults with noslip_iterations 100", "", {"step_s": 2e-3, "noslip": 100}),
    *[Setting(f"default_{us}us", "more", f"the defaults, timestep {us} µs", "", {"step_s": us * 1e-6}) for us in (500, 100, 20)],
    Setting("noslip_20us", "more", "noslip, timestep 20 µs", "", {"step_s": 2e-5, "integrator": "implicitfast", "noslip": 100, "solref": (1e-4, 1.0), "friction": (4e-5, 1.0)}),
]


def versions():
    return f"mujoco {mujoco.__version__}"


def mjcf(scene, step_s, integrator="Euler", noslip=0, solref=(0.02, 1.0), friction=(0.02, 1.0), impedance=0.9):
    """The lever as a point mass at the end of a massless rod, in the plane without gravity."""
    return f"""<mujoco>
  <compiler angle="radian"/>
  <option timestep="{step_s!r}" gravity="0 0 0" integrator="{integrator}" noslip_iterations="{noslip}"/>
  <worldbody>
    <body>
      <inertial pos="{scene.lever_m!r} 0 0" mass="{scene.mass_kg!r}" diaginertia="1e-12 1e-12 1e-12"/>
      <joint name="lever" type="hinge" axis="0 0 1" frictionloss="{max(scene.kinetic_n * scene.lever_m, 1e-9 * scene.dry)!r}"
             solreffriction="{friction[0]!r} {friction[1]!r}" solimpfriction="{impedance!r} {max(impedance, 0.95)!r} 0.001"
             limited="true" range="{scene.low_rad!r} {scene.high_rad!r}" solreflimit="{solref[0]!r} {solref[1]!r}"/>
    </body>
  </worldbody>
</mujoco>"""


def run(scene, setting):
    model = mujoco.MjModel.from_xml_string(mjcf(scene, **setting.options))
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = scene.theta_rad, scene.theta_dot_rad_s
    lever_m, dry = scene.lever_m, scene.dry

    def step(bias_n, level_n, rest_n):
        if dry:
            model.dof_frictionloss[0] = lever_m * friction_level(data.qvel[0], level_n, rest_n)
        data.qfrc_applied[0] = lever_m * bias_n
        mujoco.mj_step(model, data)

    return drive(scene, model.opt.timestep, lambda: (data.qpos[0], data.qvel[0]), step)
