"""A sweep of scenes by the module, beside SciPy on the same scenes to the same error (docs/python.md).

    python benches/python/sweep.py [RUNS [OF_SCIPY]]        (an environment with the wheel, NumPy and SciPy)

SciPy runs the program that `zwidth simulate --as python` writes of the scene: DOP853 with every change of the motion as an event.
Some of the masses are run by it, because all would take hours; times are per run, and their ratio is of one process.
"""

import importlib.util
import pathlib
import sys
import tempfile
import time

import numpy as np

import zwidth

RUNS = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
OF_SCIPY = int(sys.argv[2]) if len(sys.argv) > 2 else 20
SCENE = pathlib.Path(__file__).resolve().parents[2] / "scenes" / "step.toml"


def written(folder):
    """The scene as a program for SciPy, as a module."""
    path = pathlib.Path(folder) / "scene.py"
    zwidth.command("simulate", str(SCENE), "--as", "python", "--out", str(path))
    spec = importlib.util.spec_from_file_location("scene", path)
    module = importlib.util.module_from_spec(spec)
    sys.modules["scene"] = module
    spec.loader.exec_module(module)
    return module


masses = np.linspace(0.005, 0.05, RUNS)
began = time.perf_counter()
runs = zwidth.simulate(str(SCENE), plant__mass_kg=masses)
ours_s = (time.perf_counter() - began) / RUNS
ends = np.asarray(runs.table["theta_end_rad"])

with tempfile.TemporaryDirectory() as folder:
    scene = written(folder)
    places = np.linspace(0, RUNS - 1, OF_SCIPY).astype(int)
    off, theirs_s = 0.0, 0.0
    for place in places:
        scene.MASS = float(masses[place])
        began = time.perf_counter()
        _, states = scene.simulate()
        theirs_s += (time.perf_counter() - began) / OF_SCIPY
        off = max(off, abs(states[-1, 0] - ends[place]))

print(f"zwidth: {RUNS} runs, {1e6 * ours_s:.1f} us each")
print(f"SciPy:  {OF_SCIPY} runs, {1e3 * theirs_s:.1f} ms each; at the end at most {off:.1e} rad from the exact motion")
print(f"ratio {theirs_s / ours_s:.0f}")
