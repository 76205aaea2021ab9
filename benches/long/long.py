"""Time and memory against rows: one recording imported, verified and run by zwidth, and the same job in pandas.

    python long.py --zwidth PROGRAM [--rows 10000,100000,...] [--folder FOLDER]     the measurements, as Markdown
    python long.py --peer CSV                                                       the job in pandas alone

Each step is a process of its own; its time is from start to end, its memory the largest resident set that the system saw.
Of several turns (--turns), in each of which every step comes once, times are medians and memory is the largest.
"""

import argparse
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pandas as pd

ROWS = [10_000, 100_000, 1_000_000, 10_000_000, 20_000_000]
RATE_HZ = 1000.0
REST_DEG, REACH_DEG, STIFFNESS = -45.0, 60.0, 4.0
# Rows that are written at a time.
BLOCK = 200_000
STUDY = """
schema = 2
[study]
id = "long"
title = "One long recording"
[design]
repeats = 1
trial_limit_s = 20900.0
[control]
rate_hz = 200.0
[device]
name = "lever"
lever_m = 0.05
[[environments]]
id = "spring"
label = "Spring"
kind = "spring"
stiffness_n_per_rad = 4.0
rest_deg = -45.0
[[modes]]
id = "active"
label = "Active"
"""
MAP = """
kind = "trials"
[trial]
participant = "P01"
session = "S01"
environment = "spring"
mode = "active"
[time]
from = "t_s"
unit = "s"
[[column]]
to = "theta_rad"
from = "angle_deg"
unit = "deg"
[[column]]
to = "theta_dot_rad_s"
from = "velocity_deg_s"
unit = "deg/s"
[[column]]
to = "force_ex_n"
from = "force_n"
unit = "N"
"""


def write_csv(path, rows):
    """A lever pressed again and again into a spring, of so many samples at 1 kHz."""
    draw = np.random.default_rng(1)
    with path.open("w") as file:
        file.write("t_s,angle_deg,velocity_deg_s,force_n\n")
        for begin in range(0, rows, BLOCK):
            t = np.arange(begin, min(begin + BLOCK, rows)) / RATE_HZ
            turn = 2 * np.pi * np.minimum(t, rows / RATE_HZ - 0.5) / 1.7
            angle = REST_DEG + REACH_DEG * (1 - np.cos(turn)) / 2
            velocity = REACH_DEG / 2 * np.sin(turn) * 2 * np.pi / 1.7
            velocity[t >= rows / RATE_HZ - 0.5] = 0.0
            force = STIFFNESS * np.radians(angle - REST_DEG) + 0.2 * np.tanh(velocity / 10) + draw.normal(0, 0.02, len(t))
            frame = pd.DataFrame({"t": t, "a": angle + draw.normal(0, 0.01, len(t)), "v": velocity, "f": force})
            frame.to_csv(file, header=False, index=False, float_format="%.6f")


def peer(path):
    """The job as a script does it: read, convert, phases and metrics, write Parquet."""
    frame = pd.read_csv(path)
    t = frame["t_s"].to_numpy()
    theta, velocity = np.radians(frame["angle_deg"].to_numpy()), np.radians(frame["velocity_deg_s"].to_numpy())
    force = frame["force_n"].to_numpy()
    fast = np.flatnonzero(np.abs(velocity) > np.radians(10.0))
    slow = np.flatnonzero(np.abs(velocity[fast[-1] :]) < np.radians(5.0))
    first, last = fast[0], fast[-1] + slow[0] if len(slow) else len(t) - 1
    turn = first + int(np.argmax(theta[first : last + 1]))
    path_rad = np.abs(np.diff(theta[first : last + 1])).sum()
    area_j = 0.05 * np.trapezoid(force[first : last + 1], theta[first : last + 1])
    slope, _ = np.polyfit(theta[first : turn + 1], force[first : turn + 1], 1)
    print(t[first], t[turn], velocity.max(), velocity.min(), path_rad, area_j, slope, np.sqrt(np.mean(force**2)))
    out = pd.DataFrame({"t_s": t, "theta_rad": theta, "theta_dot_rad_s": velocity, "force_ex_n": force})
    out.to_parquet(path.with_suffix(".parquet"), compression="zstd", index=False)


def measured(command):
    """Runs a command: seconds, and the largest resident set, MB."""
    begun = time.perf_counter()
    process = subprocess.Popen([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    seconds = time.perf_counter() - begun
    code = os.waitstatus_to_exitcode(status)
    # 3: something is to be read with care.
    if code not in (0, 3):
        raise SystemExit(f"{command} ended with {code}: {said.decode()}")
    return seconds, usage.ru_maxrss / 1024


def turn(zwidth, root, csv):
    """Seconds and memory of each step, once."""
    (root / "raw/long").mkdir(parents=True)
    (root / "raw/long/study.toml").write_text(STUDY)
    (root / "map.toml").write_text(MAP)
    reader = "import sys, importlib; importlib.import_module(sys.argv[1]).read_csv(sys.argv[2])"
    steps = {
        "import": [zwidth, "--quiet", "--root", root, "import", "long", "--map", root / "map.toml", csv],
        "pandas reads": [sys.executable, "-c", reader, "pandas", csv],
        "polars reads": [sys.executable, "-c", reader, "polars", csv],
        "verify": [zwidth, "--quiet", "--root", root, "verify", "long"],
        "run": [zwidth, "--quiet", "--root", root, "run", "long"],
        "pandas": [sys.executable, __file__, "--peer", csv],
    }
    return {name: measured(command) for name, command in steps.items()}


def measure(zwidth, rows, folder, turns):
    """The size of a recording of so many rows, MB, and seconds and memory of each step."""
    csv = folder / "long.csv"
    write_csv(csv, rows)
    found = [turn(zwidth, folder / str(i), csv) for i in range(turns)]
    of_all = {name: list(zip(*(one[name] for one in found))) for name in found[0]}
    summed = {name: (statistics.median(seconds), max(memory)) for name, (seconds, memory) in of_all.items()}
    return csv.stat().st_size / 1e6, summed


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--zwidth", type=Path)
    arguments.add_argument("--peer", type=Path)
    arguments.add_argument("--rows", default=",".join(map(str, ROWS)))
    arguments.add_argument("--turns", type=int, default=3)
    arguments.add_argument("--folder", type=Path)
    given = arguments.parse_args()
    if given.peer:
        peer(given.peer)
        return
    head = "rows | CSV, MB | import, s | MB | pandas reads, s | polars reads, s | verify, s | MB | run, s | MB"
    print(f"| {head} | the three, s | largest, MB | pandas, s | MB |")
    print("| ---: " * 14 + "|")
    for rows in map(int, given.rows.split(",")):
        with tempfile.TemporaryDirectory(dir=given.folder) as folder:
            size, found = measure(given.zwidth.resolve(), rows, Path(folder), given.turns)
        ours = [found[name] for name in ("import", "verify", "run")]
        cells = [f"{rows:,}", f"{size:,.0f}"]
        for seconds, memory in ours:
            cells += [f"{seconds:.2f}", f"{memory:,.0f}"]
        cells[4:4] = [f"{found[name][0]:.2f}" for name in ("pandas reads", "polars reads")]
        cells += [f"{sum(s for s, _ in ours):.1f}", f"{max(m for _, m in ours):,.0f}"]
        cells += [f"{found['pandas'][0]:.2f}", f"{found['pandas'][1]:,.0f}"]
        print("| " + " | ".join(cells) + " |", flush=True)
    print(f"\nPython {platform.python_version()}, pandas {pd.__version__}, NumPy {np.__version__}.")


main()
