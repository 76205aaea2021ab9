"""Do other readers open what zwidth writes, and do other libraries find the same numbers?

    python interop.py --zwidth PROGRAM --root FOLDER

FOLDER holds raw/thesis-twin, and derived/ and reports/ after `zwidth run thesis-twin`. Where ZWIDTH_REAL_DATA names the folder of
the recordings made by others, those are imported into a temporary folder and checked too. One line a check; the
last line counts them, and the exit code is 1 where one failed.
"""

import argparse
import os
from pathlib import Path

import axes
import beside
import checks
import compared
import folders
import foreign
import joined
import laboratory
import made
import mixed
import others
import outside
import peers
import people
import recordings
import results
import walls

WORKSPACE = Path(__file__).resolve().parents[2]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--zwidth", type=Path, required=True, help="the program")
    arguments.add_argument("--root", type=Path, default=WORKSPACE, help="where raw/thesis-twin lies [default: the workspace]")
    given = arguments.parse_args()
    zwidth, root = given.zwidth.resolve(), given.root.resolve()
    checks.run(zwidth, "--root", root, "run", "thesis-twin", "--quiet")
    folders.study(zwidth, root, "thesis-twin")
    results.tables("thesis-twin", root / "reports/thesis-twin/tables")
    results.figures("thesis-twin", root / "reports/thesis-twin/figures", synthetic=True)
    mixed.check(zwidth)
    compared.study(zwidth)
    compared.made(root / "derived/thesis-twin")
    foreign.check_all(zwidth)
    laboratory.check_all(zwidth)
    joined.check_all(zwidth)
    beside.check_all(zwidth)
    walls.frequencies(zwidth)
    made.check_all(zwidth)
    others.check_all(zwidth)
    outside.check_all(zwidth)
    peers.check_all(zwidth)
    axes.check_all(zwidth)
    real = os.environ.get("ZWIDTH_REAL_DATA")
    if real:
        recordings.all_sets(zwidth, Path(real), WORKSPACE / "studies")
        people.check_all(zwidth, Path(real), WORKSPACE / "studies")
        walls.boundaries(zwidth, Path(real))
    else:
        print("skipped: ZWIDTH_REAL_DATA is not set")
    checks.end()


main()
