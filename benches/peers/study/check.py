"""Whether the script and zwidth made the same numbers: the largest difference of each column of each table that both
have, over the column's largest value.

    python check.py OURS THEIRS STUDY       (two roots)
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

# (table, keys that name a row, columns or None for all numbers)
TABLES = [
    ("derived", "metrics", ["trial"], None),
    ("derived", "conditions", ["environment", "mode"], None),
    ("derived", "replay", ["trial", "causality"], None),
    ("derived", "replay.agreement", ["causality", "mode", "quantity"], None),
    ("derived", "likert", ["environment", "mode"], None),
    ("derived", "identify", ["parameter"], None),
    ("derived", "identify.profile", ["parameter", "point"], None),
    ("derived", "identify.threshold", ["threshold"], None),
    ("derived", "identify.held_out", ["environment", "mode"], None),
    ("derived", "identify.trials", ["trial"], None),
    ("reports/tables", "characteristic.brake", ["model"], ["rms", "left_out_rms", "r2"]),
    ("reports/tables", "characteristic.motor", ["model"], ["rms", "left_out_rms", "r2"]),
    ("reports/tables", "modes", ["mode"], None),
    ("reports/tables", "weight", ["quantity"], None),
]
AVERAGES = ["theta_mean_rad", "force_ex_mean_n", "theta_dot_ci_low_rad_s"]
# A column that differs by more than this of its largest value is named.
NAMED = 1e-6


def difference(ours, theirs, groups=None):
    """Largest difference over the largest value (of the group), and how often one is null and the other is not."""
    a, b = (np.asarray(v, dtype=float) for v in (ours, theirs))
    alone = np.isnan(a) != np.isnan(b)
    gap, size = np.where(np.isnan(a - b), 0.0, np.abs(a - b)), np.where(np.isnan(a - b), 0.0, np.abs(a))
    groups = np.zeros(len(a), int) if groups is None else pd.factorize(groups)[0]
    each = [(gap[groups == g].max(), size[groups == g].max()) for g in np.unique(groups)]
    return max((d / largest if largest else d) for d, largest in each), int(alone.sum())


def read(path, keys):
    table = pd.read_parquet(path)
    if "point" in keys:  # a profile's points have no name but their place
        table["point"] = table.groupby("parameter").cumcount()
    if "model" in table and "causality" in table:  # the script replays the model by eye alone
        table = table[table["model"] == "by_eye"]
    return table.set_index(keys)


def compare(roots, study):
    """Rows (table, columns compared, null in one alone, largest difference, its column, columns that are named)."""
    rows = []
    for folder, name, keys, columns in TABLES:
        where = [root / folder.split("/")[0] / study / Path(*folder.split("/")[1:]) / f"{name}.parquet" for root in roots]
        if not all(p.exists() for p in where):
            continue
        ours, theirs = (read(p, keys) for p in where)
        theirs = theirs.reindex(ours.index)
        numbers = columns or [c for c in ours.select_dtypes(["number", "bool"]) if c in theirs]
        by = "parameter" if "parameter" in keys else None  # each has its own unit, and so its own largest value
        found = {c: difference(ours[c], theirs[c], by and ours.index.get_level_values(by)) for c in numbers}
        rows.append(row(name, found))
    found = {}
    averages = roots[0] / "derived" / study / "average"
    # The script makes no averages of the loop, force by angle.
    for path in sorted(path for path in averages.glob("*.parquet") if not path.stem.endswith(".loop")):
        ours, theirs = pd.read_parquet(path), pd.read_parquet(roots[1] / "derived" / study / "average" / path.name)
        for column in AVERAGES:
            found[f"{path.stem} {column}"] = difference(ours[column], theirs[column])
    return [row("averages", found)] + rows


def row(name, found):
    column, (largest, _) = max(found.items(), key=lambda item: item[1][0])
    named = {c: d for c, (d, _) in found.items() if d > NAMED}
    return name, len(found), sum(n for _, n in found.values()), largest, column, named


if __name__ == "__main__":
    for name, count, nulls, largest, column, named in compare([Path(sys.argv[1]), Path(sys.argv[2])], sys.argv[3]):
        print(f"{name}: {count} columns, largest difference {largest:.1e} ({column}), {nulls} null in one alone")
        for c, d in named.items():
            print(f"    {c}: {d:.1e}")
