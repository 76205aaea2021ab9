"""Scenes as other programs read them: `zwidth simulate --as`, run, against the exact solver.

What needs no more than SciPy, MuJoCo and rumoca (a compiler of Modelica) is checked here; engines.py has Drake and PyBullet.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import mujoco
import numpy as np
import pandas as pd
import rumoca

from checks import check, close, equal, run

QUARTER = 0.7853981633974483
LEVER, MASS = 0.045, 0.1
FREE = 'name = "free"\nzones = [{ demand.spring = { stiffness_n_per_rad = 0.0, damping_ns_per_rad = 0.0, rest_rad = 0.0 } }]'
SPRING = f'name = "spring"\nzones = [{{ demand.spring = {{ stiffness_n_per_rad = 4.0, damping_ns_per_rad = 1.0, rest_rad = -{QUARTER} }} }}]'
WALL = SPRING[:-1] + ', { from_rad = -0.2, demand = "full" }]'
VISCOUS = "friction = { static_n = 0.0, kinetic_n = 0.0, viscous_ns_per_rad = 0.3 }"
DRY = "friction = { static_n = 0.5, kinetic_n = 0.5, viscous_ns_per_rad = 0.3 }"
STICTION = "friction = { static_n = 0.6, kinetic_n = 0.4, viscous_ns_per_rad = 0.3 }"
SOFT = 'finger = {{ law = "{law}", mass_kg = 0.021, stiffness_n_per_m = 584.6, damping_ns_per_m = 1.53{length} }}'
FINGER = SOFT.format(law="consistent", length="")
FINGER_WITH_END = SOFT.format(law="consistent", length=", length_m = 0.006")
FINGER_OF_THESIS = SOFT.format(law="thesis", length=", length_m = 0.006")
LAGS = 'max_n = 13.0, law = "coulomb", lag_on_off_s = [0.015, 0.01]'
SLOW, LARGE = "sine = { magnitude = 1.0, omega_rad_s = 3.0 }", "sine = { magnitude = 1.5, omega_rad_s = 3.0 }"
USUAL = {
    "mode": "active", "environment": SPRING, "start": -0.5, "input": SLOW, "motor": "max_n = 3.25",
    "brake": 'max_n = 13.0, law = "coulomb"', "stops": f", stops_rad = [-{QUARTER}, {QUARTER}]", "more": "",
}  # fmt: skip
# What each differs in from the usual.
SCENES = {
    "ramp": {"input": "ramp = { magnitude = 1.0, period_s = 2.0 }"},
    "sine": {},
    "step": {"input": "step = { magnitude = 1.0, period_s = 2.0 }", "more": DRY},
    "series": {"input": "series = { t_s = [0.0, 0.5, 0.5, 1.2, 1.7], value = [0.0, 1.0, 2.0, 0.3, 1.0] }", "more": STICTION},
    "swing": {"environment": FREE, "start": -0.3, "input": "sine = { magnitude = 0.05, omega_rad_s = 3.0 }", "more": VISCOUS, "stops": ""},
    "stick": {"environment": FREE, "start": 0.1, "input": "line = { value = 0.25 }", "more": DRY},
    "stick_slip": {
        "environment": FREE, "input": "line = { value = 0.0 }",
        "more": STICTION + "\npull = { stiffness_n_per_rad = 8.0, displacement.line = { value = 0.0, rate = 0.3 } }",
    },
    "stop": {"environment": FREE, "input": "line = { value = 1.0 }", "more": DRY},
    "hybrid": {"mode": "hybrid", "motor": "max_n = 1.0", "input": LARGE, "more": DRY},
    "passive": {"mode": "passive", "start": -QUARTER, "brake": 'max_n = 13.0, law = "coulomb", dead_zone_n = 0.2', "input": LARGE, "more": DRY},
    "signed": {"mode": "hybrid", "motor": "max_n = 1.0", "brake": 'max_n = 13.0, law = "thesis"'},
    "wall": {"environment": WALL, "motor": "max_n = 5.0", "start": -0.4, "input": "ramp = { magnitude = 2.2, period_s = 2.0 }", "more": DRY},
    "wall_hybrid": {"mode": "hybrid", "environment": WALL, "input": "sine = { magnitude = 2.2, omega_rad_s = 3.0 }", "more": STICTION},
    "wall_passive": {
        "mode": "passive", "environment": WALL, "brake": 'max_n = 13.0, law = "coulomb", dead_zone_n = 0.2', "more": DRY,
        "input": "sine = { magnitude = 2.2, omega_rad_s = 3.0 }",
    },
    "free_passive": {"mode": "passive", "environment": FREE, "brake": LAGS, "input": "sine = { magnitude = 0.05, omega_rad_s = 3.0 }", "more": VISCOUS},
    "free_hybrid": {
        "mode": "hybrid", "environment": FREE, "brake": 'max_n = 13.0, law = "coulomb", let_go_n = 1.0',
        "input": "sine = { magnitude = 0.05, omega_rad_s = 3.0 }", "more": VISCOUS,
    },
    "weight": {"input": "sine = { magnitude = 0.7, omega_rad_s = 3.0 }", "more": DRY + "\ngravity = { mass_kg = 0.2, radius_m = 0.05 }"},
    "finger": {"more": DRY + "\n" + FINGER},
    "finger_with_end": {"input": "sine = { magnitude = 2.5, omega_rad_s = 5.0 }", "more": DRY + "\n" + FINGER_WITH_END},
    "finger_of_thesis": {"input": "sine = { magnitude = 2.5, omega_rad_s = 5.0 }", "more": DRY + "\n" + FINGER_OF_THESIS},
    "motor_lag": {"motor": "max_n = 3.0, lag_s = 0.01", "more": DRY},
    "brake_lag": {"mode": "passive", "start": -QUARTER, "brake": LAGS, "more": DRY},
    "hybrid_motor_lag": {"mode": "hybrid", "motor": "max_n = 1.0, lag_s = 0.01", "input": LARGE, "more": DRY},
    "hybrid_brake_lag": {"mode": "hybrid", "motor": "max_n = 1.0", "brake": LAGS, "input": LARGE, "more": DRY},
    "let_go": {"mode": "hybrid", "motor": "max_n = 1.0", "brake": 'max_n = 13.0, law = "coulomb", let_go_n = 1.0', "input": LARGE, "more": DRY},
}  # fmt: skip
# What MuJoCo's soft constraints and its steps of 2 ms leave of a few tenths of a radian, rad: dry friction that slides before it holds, one level of it,
# and a stop that gives way by its default time of 20 ms. The program beside a model turns between actuators once a step.
SMOOTH, HELD, SWITCHED, SOFT_END, LAGGING = 2e-3, 1e-2, 2e-2, 5e-2, 1e-1
MUJOCO = {
    "ramp": SMOOTH, "sine": SMOOTH, "step": SMOOTH, "swing": SMOOTH, "finger": HELD, "passive": HELD, "motor_lag": HELD, "brake_lag": HELD, "wall": HELD,
    "stick": HELD, "series": HELD, "stick_slip": HELD, "hybrid": SWITCHED, "signed": SWITCHED, "let_go": SWITCHED, "stop": SWITCHED, "weight": SWITCHED,
    "wall_hybrid": SWITCHED, "wall_passive": SWITCHED, "free_passive": SMOOTH, "free_hybrid": SMOOTH, "finger_with_end": SOFT_END, "hybrid_motor_lag": LAGGING, "hybrid_brake_lag": LAGGING,
}  # fmt: skip
# What no format but the programs can say, and words of what is told then.
REFUSED = {
    "mujoco": {"finger_of_thesis": "leaves the lever's acceleration out"},
    "modelica": {
        "finger_with_end": "the blow at the tissue's rigid end",
        "hybrid_motor_lag": "a lagging actuator in a hybrid drive",
        "hybrid_brake_lag": "a lagging actuator in a hybrid drive",
    },
}


class Scene:
    """A scene's file in a folder, its exact motion, and what it is written as."""

    def __init__(self, zwidth, folder, name, step=0.002):
        self.zwidth, self.name, self.folder = zwidth, name, Path(folder)
        self.path = self.folder / f"{name}.toml"
        s = USUAL | SCENES[name]
        plant = f"mass_kg = {MASS}, lever_m = {LEVER}{s['stops']}"
        self.path.write_text(
            f'name = "{name}"\nmode = "{s["mode"]}"\nduration_s = 2.0\nstep_s = {step}\nplant = {{ {plant} }}\nmotor = {{ {s["motor"]} }}\n'
            f'brake = {{ {s["brake"]} }}\ninput = {{ {s["input"]} }}\nstart = {{ theta_rad = {s["start"]} }}\n{s["more"]}\n[environment]\n{s["environment"]}\n'
        )

    def exact(self):
        """Times, angles and velocities; of a weight those of an adaptive solver, because the exact one has no curves."""
        solver = "dormand_prince" if self.name == "weight" else "exact"
        run(self.zwidth, "simulate", self.path, "--solver", solver, "--tolerance", "1e-12", "--out", self.folder, "--quiet")
        table = pd.read_parquet(self.folder / f"{self.name}.trajectory.parquet")
        return table[["t_s", "theta_rad", "theta_dot_rad_s"]].to_numpy()

    def written(self, form, ending):
        """The scene in another format: its file."""
        out = self.folder / f"{self.name}.{ending}"
        run(self.zwidth, "simulate", self.path, "--as", form, "--out", out, "--quiet")
        return out

    def ran(self, form, ending="py"):
        """What the program that is written prints."""
        program = self.written(form, "xml").with_suffix(".py") if form == "mujoco" else self.written(form, ending)
        table = program.with_suffix(".csv")
        done = subprocess.run([sys.executable, program, table], capture_output=True, text=True, check=False)
        if done.returncode:
            raise SystemExit(f"{program.name} of {form} ended with {done.returncode}:\n{done.stderr}")
        return pd.read_csv(table).to_numpy()

    def refusal(self, form):
        """What is told of a scene that a format cannot say."""
        done = subprocess.run([self.zwidth, "simulate", self.path, "--as", form], capture_output=True, text=True, check=False)
        return done.stderr if done.returncode == 1 else ""


def off(found, expect):
    """The largest difference of the angles at the same times, rad; infinite where something is not a number."""
    expect = expect[: len(found)]
    if not np.allclose(found[:, 0], expect[:, 0], atol=1e-9):
        return np.inf
    return np.nan_to_num(np.abs(found[:, 1] - expect[:, 1]).max(), nan=np.inf)


def check_all(zwidth):
    with tempfile.TemporaryDirectory() as folder:
        for name in SCENES:
            scene = Scene(zwidth, folder, name)
            exact = scene.exact()
            found = off(scene.ran("python"), exact)
            check(f"{name} as python: within 1e-9 rad of the exact motion", found < 1e-9, found)
            modelica(scene, exact)
            if name in REFUSED["mujoco"]:
                words = scene.refusal("mujoco")
                check(f"{name} as mujoco: is refused", REFUSED["mujoco"][name] in words, words)
            else:
                found = off(scene.ran("mujoco"), exact)
                check(f"{name} as mujoco: within {MUJOCO[name]:g} rad of the exact motion", found < MUJOCO[name], found)
        finer(zwidth, folder)
        creep(Scene(zwidth, folder, "stick"))
        numbers(zwidth, folder)
        swing(Scene(zwidth, folder, "swing"))
        at_rest(zwidth, Path(folder))


def at_rest(zwidth, folder):
    """A lever that came back to its stop, where the spring's rest is, and which no force moves: the program ends."""
    text = (Path(__file__).resolve().parents[2] / "scenes/step.toml").read_text(encoding="utf-8")
    heavy = text.replace("mass_kg = 0.005 ", "mass_kg = 0.1 ")
    check("the lever of the step is made heavy", heavy != text)
    (folder / "heavy.toml").write_text(heavy, encoding="utf-8")
    run(zwidth, "simulate", folder / "heavy.toml", "--solver", "exact", "--out", folder, "--quiet")
    exact = pd.read_parquet(folder / "heavy.trajectory.parquet")[["t_s", "theta_rad"]].to_numpy()
    run(zwidth, "simulate", folder / "heavy.toml", "--as", "python", "--out", folder / "heavy.py", "--quiet")
    # It looped at the stop for as long as it was let.
    done = subprocess.run([sys.executable, folder / "heavy.py", folder / "heavy.csv"], timeout=300, check=False)
    found = off(pd.read_csv(folder / "heavy.csv").to_numpy(), exact) if done.returncode == 0 else np.inf
    check("a lever at rest on its stop as python: within 1e-9 rad of the exact motion", found < 1e-9, found)


def modelica(scene, exact):
    """Compiled and run by rumoca."""
    refused = REFUSED["modelica"].get(scene.name)
    if refused:
        words = scene.refusal("modelica")
        check(f"{scene.name} as modelica: is refused", refused in words, words)
        return
    text = scene.written("modelica", "mo").read_text()
    model = rumoca.Session().loads(text, model="Lever", filename="Lever.mo")
    settings = rumoca.SimConfig(dt=exact[1, 0], rtol=1e-9, atol=1e-11)
    done = model.simulate(t=(0.0, exact[-1, 0]), config=settings)
    times, angles = np.array(done.time), np.array(done["theta"])
    last = np.append(np.diff(times) > 0, True)  # of an event's samples
    found = np.abs(np.interp(exact[:, 0], times[last], angles[last]) - exact[:, 1]).max()
    check(f"{scene.name} as modelica: within 1e-6 rad of the exact motion", found < 1e-6, found)


def finer(zwidth, folder):
    """What MuJoCo is off by where nothing is held or hit comes from its step."""
    for name in ("ramp", "sine", "swing"):
        errors = []
        for step in (0.002, 0.0005):
            scene = Scene(zwidth, folder, name, step)
            errors.append(off(scene.ran("mujoco"), scene.exact()))
        check(f"{name} as mujoco: a quarter of the step leaves less than half of the error", errors[1] < errors[0] / 2, errors)


def creep(scene):
    """A lever under half its dry friction stands in the file as it is, and creeps with MuJoCo's default."""
    model = mujoco.MjModel.from_xml_path(str(scene.written("mujoco", "xml")))
    moved = {}
    for noslip in (model.opt.noslip_iterations, 0):
        model.opt.noslip_iterations = noslip
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, 0)
        data.actuator("input").ctrl = 0.25
        for _ in range(1000):
            mujoco.mj_step(model, data)
        moved[noslip] = abs(data.qpos[0] - 0.1)
    check("stick as mujoco: stands", moved[10] < 1e-9, moved)
    check("stick as mujoco: creeps without noslip_iterations, as its remark says", moved[0] > 1e-3, moved)


def numbers(zwidth, folder):
    """The scene's numbers in the models that MuJoCo makes of MJCF and URDF."""
    scene = Scene(zwidth, folder, "finger_with_end")
    for form, ending in (("mujoco", "xml"), ("urdf", "urdf")):
        model = mujoco.MjModel.from_xml_path(str(scene.written(form, ending)))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        inertia = np.zeros((2, 2))
        mujoco.mj_fullM(model, data, inertia)
        close(f"{form}: the lever and the finger about the axis", inertia[0, 0], (MASS + 0.021) * LEVER**2, 1e-12)
        close(f"{form}: the finger about the axis", inertia[1, 1], 0.021 * LEVER**2, 1e-12)
        equal(f"{form}: stops", model.jnt_range[0].tolist(), [-QUARTER, QUARTER])
        close(f"{form}: the tissue's end", model.jnt_range[1, 1], 0.006 / LEVER, 1e-12)
        close(f"{form}: dry friction", model.dof_frictionloss[0], 0.5 * LEVER, 1e-12)
        close(f"{form}: viscous friction", model.dof_damping[0], 0.3 * LEVER, 1e-12)
        if form == "mujoco":
            equal("mujoco: step", model.opt.timestep, 0.002)
            close("mujoco: tissue", model.jnt_stiffness[1], 584.6 * LEVER**2, 1e-12)
    weight = Scene(zwidth, folder, "weight")
    model = mujoco.MjModel.from_xml_path(str(weight.written("mujoco", "xml")))
    data = mujoco.MjData(model)
    data.qpos[0] = 0.3
    mujoco.mj_forward(model, data)
    close("mujoco: moment of the weight", -data.qfrc_bias[0], 0.2 * 9.80665 * 0.05 * np.sin(0.3), 1e-12)
    close("mujoco: inertia with a weight", data.M[0], MASS * LEVER**2, 1e-12)


def swing(scene):
    """URDF has no input: MuJoCo runs the lever under the scene's force, which is applied from here."""
    exact = scene.exact()
    model = mujoco.MjModel.from_xml_path(str(scene.written("urdf", "urdf")))
    model.opt.timestep, model.opt.integrator = 0.002, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    data = mujoco.MjData(model)
    data.qpos[0] = exact[0, 1]
    found = np.empty((len(exact), 2))
    for i, t in enumerate(exact[:, 0]):
        found[i] = t, data.qpos[0]
        data.qfrc_applied[0] = LEVER * (0.05 + 0.05 * np.sin(3.0 * t))
        mujoco.mj_step(model, data)
    error = off(found, exact)
    check(f"swing as urdf in MuJoCo: within {SMOOTH:g} rad of the exact motion", error < SMOOTH, error)
