"""Devices with several axes: a surgical console by formula, imported as docs/import.md says, against the formula, NumPy
and SciPy; and uneven times with gaps.

    python axes.py --zwidth PROGRAM

With --keep FOLDER the study stays there, and the times that import and run take are printed.
"""

import argparse
import math
import re
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
from scipy.signal import butter, filtfilt

from checks import DONE_OR_WITH_CARE, check, close, end, run

WORKSPACE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(WORKSPACE / "examples/console"))
import make  # noqa: E402

LOW_PASS_HZ = 10.0
PUSH = np.array([0.0, 0.0, -1.0])


def blocks(page):
    """The code blocks of "A surgical console"."""
    part = page.split("### A surgical console")[1].split("\n## ")[0]
    return re.findall(r"```toml\n(.*?)```", part, re.S)


def study(zwidth, root):
    """The study of the documentation, imported and run; the seconds that both took."""
    axes, mapping = blocks((WORKSPACE / "docs/import.md").read_text(encoding="utf-8"))
    recordings = root / "recordings"
    make.write(recordings)
    run(zwidth, "--root", root, "new", "console", "--imported")
    file = root / "raw/console/study.toml"
    text = file.read_text(encoding="utf-8").replace("schema = 2", "schema = 3").replace("repeats = 3", "repeats = 2")
    text = text.replace('id = "a"\nlabel = "A"', 'id = "unassisted"\nlabel = "Unassisted"')
    text = text.replace('id = "b"\nlabel = "B"', 'id = "assisted"\nlabel = "Assisted"')
    file.write_text(text + axes, encoding="utf-8")
    (root / "raw/console/participants.csv").write_bytes((recordings / "participants.csv").read_bytes())
    (root / "map.toml").write_text(mapping, encoding="utf-8")
    files = sorted(recordings.glob("P*.csv"))
    began = time.monotonic()
    run(zwidth, "--root", root, "import", "console", "--map", root / "map.toml", *files, codes=DONE_OR_WITH_CARE)
    imported = time.monotonic()
    run(zwidth, "--root", root, "run", "console", "--quiet", codes=DONE_OR_WITH_CARE)
    return imported - began, time.monotonic() - imported


def low_passed(x, step):
    """Two passes of Butterworth's second order, as Winter corrects them, the ends mirrored."""
    correction = (math.sqrt(2) - 1) ** 0.25
    wide = 2 / math.pi * math.atan(math.tan(math.pi * LOW_PASS_HZ * step) / correction)
    padding = min(math.ceil(6 / (step * LOW_PASS_HZ)), len(x) - 1)
    return filtfilt(*butter(2, wide), x, padtype="odd", padlen=padding)


def in_space(t, positions, forces, onset=0.01, offset=0.005):
    """What zwidth's metrics of axes are, from arrays (columns are axes)."""
    step = max(np.median(np.diff(t)), 0.01 / LOW_PASS_HZ)
    cuts = np.flatnonzero(np.diff(t) > max(0.25 / LOW_PASS_HZ, 5 * step)) + 1
    even, filtered = [], []
    for part, place in zip(np.split(t, cuts), np.split(positions, cuts)):
        times = np.minimum(part[0] + step * np.arange(int((part[-1] - part[0]) / step + 1e-6) + 1), part[-1])
        on = np.column_stack([np.interp(times, part, axis) for axis in place.T])
        if len(times) > 1:
            on = np.column_stack([low_passed(axis, step) for axis in on.T])
        even.append(times)
        filtered.append(on)
    gaps = [(a[-1], b[0]) for a, b in zip(even, even[1:])]
    even, filtered = np.concatenate(even), np.concatenate(filtered)
    speed = np.linalg.norm(np.gradient(filtered, even, axis=0), axis=1)
    moving = np.flatnonzero(speed > onset)
    first, last = moving[0], moving[-1]
    slow = np.flatnonzero(speed[last:] < offset)
    last = last + slow[0] if len(slow) else len(even) - 1
    steps = np.linalg.norm(np.diff(filtered[first : last + 1], axis=0), axis=1)
    begin, stop = even[first], even[last]
    magnitude = np.linalg.norm(forces, axis=1)
    across = np.linalg.norm(forces - np.outer(forces @ PUSH, PUSH), axis=1)
    span = t[-1] - t[0]
    inside = (t >= begin) & (t <= stop)
    outside = (t[1:] <= begin) | (t[:-1] >= stop)
    seconds = np.diff(t)[outside]
    rest = (seconds * (magnitude[1:] + magnitude[:-1])[outside] / 2).sum() / seconds.sum() if outside.any() else None
    moved = np.diff(positions[inside], axis=0)
    pushed = (forces[inside][1:] + forces[inside][:-1]) / 2
    distance = np.linalg.norm(filtered[last] - filtered[first])
    return {
        "completion_s": stop - begin,
        "path_m": steps.sum(),
        "distance_m": distance,
        "path_over_distance": steps.sum() / distance,
        "path_gap_s": sum(max(0.0, min(b, stop) - max(a, begin)) for a, b in gaps),
        "force_magnitude_largest_n": magnitude.max(),
        "force_magnitude_mean_n": np.trapezoid(magnitude, t) / span,
        "force_magnitude_rest_n": rest,
        "force_across_share": np.trapezoid(across, t) / np.trapezoid(magnitude, t),
        "work_j": (moved * pushed).sum(),
    }


def same(what, row, expect):
    """Every metric of a trial against NumPy's."""
    for name, value in expect.items():
        if value is None:
            check(f"{what}: {name} is null", row[name] is None, row[name])
        elif value == 0.0:
            check(f"{what}: {name}", row[name] == 0.0, row[name])
        else:
            close(f"{what}: {name} as NumPy and SciPy have it", row[name], value, 1e-6)


def formula(root):
    """The console's metrics against its formula, and against NumPy and SciPy from the CSV files."""
    metrics = pq.read_table(root / "derived/console/metrics.parquet").to_pylist()
    check("console: a row a trial", len(metrics) == 24, len(metrics))
    rows = {(row["participant"], row["mode"], row["repeat"]): row for row in metrics}
    for trial in make.trials():
        row = rows[trial.person, trial.mode, trial.repeat]
        what = f"{trial.person} {trial.mode} {trial.repeat}"
        close(f"{what}: path by the formula", row["path_m"], trial.path_m, 2e-3)
        # To a sample at either end.
        check(
            f"{what}: completion time by the formula",
            abs(row["completion_s"] - trial.completion_s) < 0.1,
            (row["completion_s"], trial.completion_s),
        )
        close(f"{what}: work by the formula", row["work_j"], trial.work_j, 5e-3)
        check(f"{what}: |F| at rest", 0.19 < row["force_magnitude_rest_n"] < 0.35, row["force_magnitude_rest_n"])
        close(f"{what}: largest |F|", row["force_magnitude_largest_n"], trial.force_n, 1e-3)
        table = np.loadtxt(root / f"recordings/{trial.person}_{trial.mode}_{trial.repeat}.csv", delimiter=",", skiprows=1)
        same(what, row, in_space(table[:, 0] / 1000, table[:, 1:4] / 1000, table[:, 4:7]))
    novices = [row["path_m"] for row in metrics if row["participant"] < "P04" and row["mode"] == "unassisted"]
    contrasts = pq.read_table(root / "derived/console/compare/contrasts.parquet").to_pylist()
    path = [row for row in contrasts if row["metric"] == "path_m"]
    check("console: the path is compared between the modes", len(path) == 1, contrasts)
    people = {}
    for (person, mode, _), row in rows.items():
        people.setdefault(person, {}).setdefault(mode, []).append(row["path_m"])
    means = [np.mean(own["assisted"]) - np.mean(own["unassisted"]) for own in people.values()]
    close("console: the mean difference of the path", path[0]["difference"], np.mean(means), 1e-6)
    check("console: novices take longer ways", np.mean(novices) > 3.0, novices)
    for stem in ("space", "force_magnitude"):
        found = list((root / "reports/console/figures").glob(f"{stem}.*.png"))
        check(f"console: a figure {stem} for each person", len(found) == 6, found)


def uneven(zwidth, root):
    """A recording at uneven times, with lost samples and two gaps, noise, and projections on the push."""
    chance = np.random.default_rng(59)
    t = np.cumsum(chance.uniform(0.002, 0.009, 4000))
    t = np.round(t[((t < 6) | (t > 6.4)) & ((t < 11) | (t > 13))], 5)
    speed = 1.3
    curve = np.column_stack([0.08 * np.cos(speed * t), 0.05 * np.sin(2 * speed * t), 0.03 * np.sin(speed * t)])
    places = np.round(curve + chance.normal(0, 1e-4, curve.shape), 7)
    forces = np.round(np.column_stack([np.cos(t), 0.5 * np.sin(t), 1 + 0.2 * t]) + chance.normal(0, 0.05, curve.shape), 6)
    names = "t,x,y,z,fx,fy,fz"
    table = np.column_stack([t, places, forces])
    np.savetxt(root / "uneven.csv", table, fmt="%.9g", delimiter=",", header=names, comments="")
    run(zwidth, "--root", root, "new", "uneven", "--imported")
    file = root / "raw/uneven/study.toml"
    text = file.read_text(encoding="utf-8").replace("schema = 2", "schema = 3").replace("# lever_m = 0.05", "lever_m = 0.1")
    file.write_text(text + '\n[axes]\nframe = "x right"\npush = [0, 0, -1]\n', encoding="utf-8")
    column = '[[column]]\nto = "{}"\nfrom = "{}"\nunit = "{}"\n'
    mapping = 'kind = "trials"\n[trial]\nparticipant = "P01"\nsession = "S01"\nenvironment = "task"\nmode = "a"\n'
    mapping += '[time]\nfrom = "t"\nunit = "s"\n'
    mapping += "".join(column.format(f"{axis}_m", axis, "m") for axis in "xyz")
    mapping += "".join(column.format(f"force_{axis}_n", f"f{axis}", "N") for axis in "xyz")
    mapping += '[[column]]\nto = "theta_rad"\nderive = "along push"\norigin = [0.0, 0.0, 0.02]\n'
    mapping += '[[column]]\nto = "force_ex_n"\nderive = "along push"\n'
    (root / "uneven.toml").write_text(mapping, encoding="utf-8")
    mapped = ["--map", root / "uneven.toml", root / "uneven.csv"]
    run(zwidth, "--root", root, "import", "uneven", *mapped, codes=DONE_OR_WITH_CARE)
    run(zwidth, "--root", root, "run", "uneven", "--quiet", codes=DONE_OR_WITH_CARE)
    (row,) = pq.read_table(root / "derived/uneven/metrics.parquet").to_pylist()
    expect = in_space(t, places, forces)
    check("uneven: both gaps are told", abs(expect["path_gap_s"] - 2.4) < 0.1, expect["path_gap_s"])
    same("uneven", row, expect)
    (trial,) = (root / "raw/uneven/trials").rglob("*.parquet")
    samples = pq.ParquetFile(trial).read()
    projected = ((places - [0, 0, 0.02]) @ PUSH) / 0.1
    off = np.abs(samples["theta_rad"].to_numpy() - projected).max()
    check("uneven: the coordinate is the projection per lever", off < 1e-12, off)
    off = np.abs(samples["force_ex_n"].to_numpy() - forces @ PUSH).max()
    check("uneven: the force is the projection", off < 1e-12, off)


def check_all(zwidth, keep=None):
    """All of it."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(keep or folder)
        took = study(zwidth, root)
        if keep:
            print(f"import {took[0]:.1f} s, run {took[1]:.1f} s")
        formula(root)
        uneven(zwidth, root)


if __name__ == "__main__":
    given = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    given.add_argument("--zwidth", type=Path, required=True, help="the program")
    given.add_argument("--keep", type=Path, help="where the study is made and stays")
    arguments = given.parse_args()
    check_all(arguments.zwidth.resolve(), arguments.keep)
    end()
