"""Random scenes over the engines that can be driven in a loop: how often each stands, creeps, or misses an event, by
`zwidth judge`.

    python extremes.py ENGINE OUT --zwidth PATH [--number N] [--seed SEED]     in the environment that has the engine
    python extremes.py --all VENVS OUT --zwidth PATH                           every engine below, and OUT/extremes.json of all

Each scene also has an answer in closed form, for which neither `exact` nor an engine is asked. Where the judge calls a
run right that is further from it than the bounds below, one of the two is wrong, which is counted:

* *stands*: a push of 5 to 95 % of the dry friction moves nothing;
* *arrives*: a push F beyond the friction takes the lever from rest to a stop at theta after
  t = sqrt(2 theta M L / (F - F_k)), where it stays;
* *stops*: a lever thrown at v comes to rest after theta = v² M L / (2 F_k), t = v M L / F_k, where it stays.
"""

import argparse
import importlib
import json
import math
import random
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from judged import judged
from scene import Scene

HERE = Path(__file__).parent
DURATION_S, STEP_S = 0.5, 1e-3
# What the judge may call right: a speed, rad/s; an angle, rad, beyond what the lever moves in a step at its fastest; and,
# for the time of an event, s and so many of the engine's steps.
CREEPS_RAD_S, ELSEWHERE_RAD, LATE_S, LATE_STEPS = 1e-5, math.radians(0.5), 1e-3, 2.0
# Engine, setting, number of scenes (of the slow ones fewer), environment.
RUNS = [
    ("mujoco", "default", 10_000, "main"), ("dart", "default", 10_000, "main"), ("loop", "euler_tanh", 3_000, "main"), ("loop", "euler_sign", 3_000, "main"),
    ("pybullet", "default", 3_000, "main"), ("scipy", "located", 1_000, "main"), ("mujoco", "stiff_1ms", 1_000, "main"), ("loop", "projected", 1_000, "main"),
    ("pybullet", "motor_1ms", 1_000, "main"), ("drake", "plant", 300, "drake"), ("mujoco", "noslip", 100, "main"), ("drake", "witness", 30, "drake"), ("scipy", "rk45_tanh", 30, "main"),
]


def drawn(number, seed):
    """Scenes with their kind, angle and time of what happens: the same for every engine."""
    chance = random.Random(seed)
    between = lambda low, high: math.exp(chance.uniform(math.log(low), math.log(high)))
    for i in range(number):
        kind = ("stands", "arrives", "stops")[i % 3]
        mass, lever, dry = between(0.002, 0.2), between(0.04, 0.2), between(0.05, 1.0)
        inertia, stop, push, speed, angle, time = mass * lever, 0.7, 0.0, 0.0, 0.0, 0.0
        if kind == "stands":
            push = dry * chance.uniform(0.05, 0.95)
        elif kind == "arrives":
            stop, time = between(0.05, 0.6), between(0.02, 0.3)
            push, angle = dry + 2.0 * stop * inertia / time**2, stop
        else:
            time = min(between(0.01, 0.3), math.sqrt(2.0 * 0.5 * inertia / dry))
            speed = dry * time / inertia
            angle = 0.5 * speed * time
        free = {"spring": {"stiffness_n_per_rad": 0.0, "damping_ns_per_rad": 0.0, "rest_rad": 0.0}}
        yield kind, angle, time, {
            "name": kind, "mode": "active", "duration_s": DURATION_S, "step_s": STEP_S,
            "environment": {"name": "free", "zones": [{"demand": free}]},
            "plant": {"mass_kg": mass, "lever_m": lever, "stops_rad": [-0.7, stop]}, "motor": {"max_n": 0.0},
            "brake": {"max_n": 0.0, "law": "coulomb"}, "input": {"line": {"value": push}},
            "start": {"theta_rad": 0.0, "theta_dot_rad_s": speed},
            "friction": {"static_n": dry, "kinetic_n": dry, "viscous_ns_per_rad": 0.0},
        }


def toml(value):
    """A value of a scene's file."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value) if isinstance(value, str) else repr(float(value))


def by_closed_form(kind, angle, time, times, theta):
    """What became of a run, in one word."""
    if not np.isfinite(theta).all():
        return "not finite"
    tail = slice(int(0.9 * len(times)), None)
    moved = np.diff(theta[tail])
    speed = (theta[-1] - theta[tail][0]) / (times[-1] - times[tail][0])
    step = times[1] - times[0]
    allowed = ELSEWHERE_RAD + (2.0 * angle / time * step if time > 0.0 else 0.0)
    turns = int((moved[1:] * moved[:-1] < 0.0).sum())
    if kind == "arrives":
        if theta.max() > angle + allowed:
            return "through the stop"
        if abs(theta[-1] - angle) > allowed:
            return "elsewhere"
        there = np.flatnonzero(theta >= angle - ELSEWHERE_RAD)[0]
        # From ELSEWHERE_RAD before the stop, the rest takes this long at the speed of arrival.
        early = ELSEWHERE_RAD / (2.0 * angle / time)
        if abs(times[there] - (time - early)) > LATE_S + LATE_STEPS * step:
            return "late"
        return "right"
    if turns > len(moved) // 4 and np.abs(moved).max() > 1e-9:
        return "chatters"
    if abs(speed) > CREEPS_RAD_S:
        return "creeps"
    return "right" if abs(theta[-1] - angle) < allowed else "elsewhere"


def run(name, setting_name, number, seed, zwidth):
    engine = importlib.import_module(f"engines.{name}")
    setting = next(s for s in engine.SETTINGS if s.name == setting_name)

    def verdict(i, scene, columns):
        """The judge's, from files that are gone afterwards."""
        path, trajectory = folder / f"{i}.toml", folder / f"{i}.csv"
        path.write_text("".join(f"{key} = {toml(value)}\n" for key, value in scene.items()))
        np.savetxt(trajectory, np.column_stack(columns), "%.17g", ",", header="t_s,theta_rad,theta_dot_rad_s", comments="")
        words = judged(zwidth, Scene(scene, path), trajectory)[0]
        path.unlink()
        trajectory.unlink()
        return words

    def ran(i, kind, angle, time, scene):
        """Kind, the judge's verdict, and whether the closed form agrees with one that nothing is wrong."""
        try:
            times, theta, theta_dot, _ = engine.run(Scene(scene, f"random/{i}.toml"), setting)
        except Exception as failure:  # an engine's own error is a result of the bench
            print(f"{name}, {setting_name}, scene {i}: {type(failure).__name__}: {failure}", file=sys.stderr)
            return kind, None, "failed"
        return kind, pool.submit(verdict, i, scene, (times, theta, theta_dot)), by_closed_form(kind, angle, time, times, theta)

    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(2) as pool:
        folder = Path(temporary)
        runs = [ran(i, *drawn_one) for i, drawn_one in enumerate(drawn(number, seed))]
        judgements = [(kind, words.result() if words else "failed", closed) for kind, words, closed in runs]
    counts, speeds, contradicted = {kind: {} for kind in ("stands", "arrives", "stops")}, [], 0
    for kind, words, closed in judgements:
        word, _, size = words.partition(": ")
        counts[kind][word] = counts[kind].get(word, 0) + 1
        contradicted += word in ("right", "stands") and closed != "right"
        if word == "creeps":
            speeds.append(float(size.removesuffix("°/s")))
    creep = {"median_deg_s": statistics.median(speeds), "largest_deg_s": max(speeds)} if speeds else {}
    return {
        "engine": name, "name": engine.NAME, "setting": setting_name, "about": setting.about, "number": number, "seed": seed,
        "counts": counts, "creep": creep, "contradicted": contradicted,
    }  # fmt: skip


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("engine")
    parser.add_argument("out", type=Path)
    parser.add_argument("--zwidth", required=True)
    parser.add_argument("--setting")
    parser.add_argument("--number", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=58)
    parser.add_argument("--all", action="store_true", help="ENGINE is then the folder of environments")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    if not arguments.all:
        counted = run(arguments.engine, arguments.setting, arguments.number, arguments.seed, arguments.zwidth)
        path = arguments.out / f"extremes.{arguments.engine}.{arguments.setting}.json"
        path.write_text(json.dumps(counted, indent=1))
        return
    for engine, setting, number, venv in RUNS:
        python = Path(arguments.engine) / venv / "bin/python"
        line = [python, HERE / "extremes.py", engine, arguments.out, "--zwidth", arguments.zwidth, "--setting", setting, "--number", str(number), "--seed", str(arguments.seed)]
        subprocess.run(line, cwd=HERE, check=True)
    all_runs = [json.loads((arguments.out / f"extremes.{engine}.{setting}.json").read_text()) for engine, setting, _, _ in RUNS]
    (arguments.out / "extremes.json").write_text(json.dumps(all_runs, indent=1))


if __name__ == "__main__":
    main()
