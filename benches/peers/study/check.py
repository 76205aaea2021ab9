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
    ("derived", "replay", ["trial", "causality"], None),
    ("derived", "replay.agreement", ["causality", "mode", "quantity"], None),
    ("derived", "likert", ["environment", "mode"], None),
    ("reports/tables", "identify", ["parameter"], ["fitted", "rmse_fitted_rad", "rmse_halved_rad", "rmse_doubled_rad"]),
    ("reports/tables", "identify.trials", ["trial"], None),
    ("reports/tables", "characteristic.brake", ["model"], ["rms", "left_out_rms", "r2"]),
    ("reports/tables", "characteristic.motor", ["model"], ["rms", "left_out_rms", "r2"]),
]
AVERAGES = ["theta_mean_rad", "force_ex_mean_n", "theta_dot_ci_low_rad_s"]
# A column that differs by more than this of its largest value is named.
NAMED = 1e-6


def difference(ours, theirs):
    """Largest difference over the largest value, and how often one is null and the other is not."""
    a, b = (np.asarray(v, dtype=float) for v in (ours, theirs))
    both = ~np.isnan(a) & ~np.isnan(b)
    largest = np.abs(a[both]).max(initial=0.0)
    gap = np.abs(a[both] - b[both]).max(initial=0.0)
    return (gap / largest if largest else gap), int(np.sum(np.isnan(a) != np.isnan(b)))


def compare(roots, study):
    """Rows (table, columns compared, null in one alone, largest difference, its column, columns that are named)."""
    rows = []
    for folder, name, keys, columns in TABLES:
        where = [root / folder.split("/")[0] / study / Path(*folder.split("/")[1:]) / f"{name}.parquet" for root in roots]
        if not all(p.exists() for p in where):
            continue
        ours, theirs = (pd.read_parquet(p).set_index(keys) for p in where)
        theirs = theirs.reindex(ours.index)
        numbers = columns or [c for c in ours.select_dtypes(["number", "bool"]) if c in theirs]
        found = {c: difference(ours[c], theirs[c]) for c in numbers}
        rows.append(row(name, found))
    found = {}
    for path in sorted((roots[0] / "derived" / study / "average").glob("*.parquet")):
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
