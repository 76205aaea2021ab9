"""Boundaries of walls and impedance against frequency, once more: NumPy and SciPy on the files themselves."""

import tempfile
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
from scipy import signal
from scipy.stats import t as student

from checks import check, close, equal, run

# `[analysis] confidence` and `device.lever_m` of a new study.
LEVEL = 0.95
# Sums of a few numbers, and of many; intervals rest on a quantile that `stats::rounded` leaves nine digits of.
DIGITS, SPECTRA, INTERVALS = 1e-12, 1e-9, 5e-9
# Segments of about 2 s, from the second bin to 0.8 of half the rate.
SEGMENT_S, FIRST, TOP = 2.0, 2, 0.8
# Squared correlation of neighbouring segments: Hann, half of them common.
OVERLAP = 1.0 / 36.0


def boundaries(zwidth, real):
    """`zwidth stability --beside` on the haptic paddle's two boundaries."""
    files = sorted((real / "ethz_haptic_paddle/kb").glob("*.csv"))
    with tempfile.TemporaryDirectory() as folder:
        beside = [part for file in files for part in ("--beside", file)]
        pair = ["--x", "wall_damping", "--y", "stiffness", "--cells", "3"]
        run(zwidth, "--root", folder, "stability", *pair, *beside, "--quiet")
        table = pd.read_parquet(Path(folder) / "reports/stability/measured_by_others.parquet").set_index("boundary")
    equal("boundaries: files", list(table.index), [file.stem for file in files])
    for file in files:
        measured = pd.read_csv(file).sort_values("B")
        row, area = table.loc[file.stem], np.trapezoid(measured["K"], measured["B"])
        close(f"{file.stem}: area", row["area"], area, DIGITS)
        close(f"{file.stem}: K(0)", row["stiffness_undamped"], measured["K"].iloc[0], DIGITS)
        close(f"{file.stem}: largest K", row["stiffness_largest"], measured["K"].max(), DIGITS)
        close(f"{file.stem}: its B", row["damping_of_largest"] + 1.0, measured["B"].iloc[measured["K"].argmax()] + 1.0, DIGITS)
        rectangle = measured["K"].iloc[0] * measured["B"].max()
        close(f"{file.stem}: fullness", row["fullness"], area / rectangle, DIGITS)
        check(f"{file.stem}: units are not known", not row["is_si"])


def frequencies(zwidth):
    """`frequency` of `zwidth characterise STUDY impedance`: SciPy's csd, welch and coherence on the same samples."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        run(zwidth, "--root", root, "twin", "demo", "--participants", 1, "--sessions", 1, "--seed", 3, "--quiet")
        run(zwidth, "--root", root, "characterise", "demo", "impedance", "--quiet")
        table = pd.read_parquet(root / "reports/demo/impedance/frequency.parquet")
        trials = pd.concat([trial(file) for file in sorted((root / "raw/demo").rglob("trial-*.parquet"))])
        # Familiarisation does not count.
        trials = trials[trials["kind"] == "trial"]
        study = tomllib.loads((root / "raw/demo/study.toml").read_text())
    label = {kind: {one["id"]: one["label"] for one in study[kind]} for kind in ("environments", "modes")}
    conditions = table.groupby(["environment", "mode"], sort=False)
    equal("frequency: conditions", len(conditions), len(trials.groupby(["environment", "mode"])))
    worst = {}
    for (environment, mode), records in trials.groupby(["environment", "mode"], sort=False):
        rows = conditions.get_group((label["environments"][environment], label["modes"][mode]))
        found = response([record for _, record in records.groupby("file", sort=False)], study["device"]["lever_m"])
        equal(f"frequency: {environment}, {mode}: rows", len(rows), len(found))
        for column in found:
            expect = found[column].to_numpy()
            off = np.abs(rows[column].to_numpy() - expect) / np.abs(expect).max()
            worst[column] = max(worst.get(column, 0.0), float(off.max()))
    for column, off in worst.items():
        bound = INTERVALS if column.startswith("ci_") or column.endswith("_half_interval_rad") else SPECTRA
        check(f"frequency: {column} is SciPy's to {bound:g} of its largest", off <= bound, off)


def response(records, lever):
    """Impedance against frequency of the records of one condition."""
    news = [updates(record) for record in records]
    steps = np.sort(np.concatenate([np.diff(t) for t, _ in news]))
    rate = 1.0 / steps[len(steps) // 2]
    length = 2 ** int(np.round(np.log2(SEGMENT_S * rate)))
    options = {"fs": rate, "window": "hann", "nperseg": length, "noverlap": length // 2, "detrend": "constant"}
    sums, segments, spread = 0.0, 0, 0.0
    for record, (t, force) in zip(records, news, strict=True):
        first, last = t[t >= record["t_s"].iloc[0]][0], min(t[-1], record["t_s"].iloc[-1])
        grid = np.minimum(first + np.arange(int((last - first) * rate * (1 + 1e-9)) + 1) / rate, last)
        x, f = np.interp(grid, record["t_s"], record["theta_rad"]), np.interp(grid, t, force)
        if len(grid) < length:
            continue
        n = (len(grid) - length) // (length // 2) + 1
        xy, xx, yy = (signal.csd(a, b, **options)[1] for a, b in [(x, f), (x, x), (f, f)])
        sums = sums + n * np.array([xy, xx, yy])
        segments, spread = segments + n, spread + n + 2 * (n - 1) * OVERLAP
    (xy, xx, yy), averages = sums / segments, segments**2 / spread
    xx, yy = xx.real, yy.real
    frequency = np.arange(length // 2 + 1) * rate / length
    keep = (np.arange(len(frequency)) >= FIRST) & (frequency <= TOP * rate / 2)
    frequency, xy, xx, yy = frequency[keep], xy[keep], xx[keep], yy[keep]
    velocity = 2j * np.pi * frequency * lever
    z, coherence = np.conj(velocity) * xy / (np.abs(velocity) ** 2 * xx), np.abs(xy) ** 2 / (xx * yy)
    t = student.ppf(0.5 + LEVEL / 2, 2 * (averages - 1))
    half = t * np.sqrt((1 - coherence) / (2 * (averages - 1) * coherence))
    return pd.DataFrame(
        {
            "frequency_hz": frequency,
            "magnitude_ns_per_m": np.abs(z),
            "ci_low": np.maximum(np.abs(z) * (1 - half), 0),
            "ci_high": np.abs(z) * (1 + half),
            "real_ns_per_m": z.real,
            "imaginary_ns_per_m": z.imag,
            "coherence": coherence,
            "phase_half_interval_rad": half,
            "velocity_density": np.abs(velocity) ** 2 * xx,
            "force_density": yy,
            "averages": averages,
            "chance": 1 - (1 - LEVEL) ** (1 / (averages - 1)),
        }
    )


def trial(file):
    """A trial's samples, with its condition."""
    said = pq.read_metadata(file).metadata
    words = {key: said[key.encode()].decode() for key in ("environment", "mode", "kind")}
    return pd.read_parquet(file, partitioning=None).assign(file=file.name, **words)


def updates(record):
    """When the force was new, and what it was."""
    t, age = record["t_s"].to_numpy(), record["force_age_s"].to_numpy().astype(float)
    new = np.append(True, age[1:] < age[:-1] + np.diff(t) / 2)
    return (t - age)[new], record["force_ex_n"].to_numpy().astype(float)[new]
