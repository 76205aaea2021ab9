"""Whether a peer's metrics are zwidth's, column by column over all trials.

    python check.py OURS.parquet THEIRS.parquet

Prints a line per column: its name, how many trials have a value, how many have one in one table alone, and the largest
relative difference. Ends with 1 if one differs by more than 1e-9.
"""

import sys

import pandas as pd

from study import KEYS

TOLERANCE = 1e-9


def compare(ours, theirs):
    ours, theirs = (pd.read_parquet(path).astype({"participant": str, "session": str}) for path in (ours, theirs))
    ours, theirs = (table.set_index(KEYS).sort_index() for table in (ours, theirs))
    if not ours.index.equals(theirs.index):
        raise SystemExit(f"{len(ours)} trials in one table, {len(theirs)} in the other, or not the same")
    both = lambda name: (ours[name].astype(float), theirs[name].astype(float))
    return [(name, *difference(*both(name))) for name in sorted(theirs.columns)]


def difference(a, b):
    alone = int((a.isna() != b.isna()).sum())
    larger = a.abs().combine(b.abs(), max)
    return int(a.notna().sum()), alone, float(((a - b).abs() / larger).where(a != b, 0.0).max())


def main():
    rows = compare(sys.argv[1], sys.argv[2])
    for row in rows:
        print(*row, sep="\t")
    wrong = [name for name, _, alone, largest in rows if alone or not largest <= TOLERANCE]
    if wrong:
        raise SystemExit(f"{', '.join(wrong)}: not the same in {sys.argv[1]} and {sys.argv[2]}")


main()
